//! The structure of a DXF file: blocks with what is drawn in them, where they are inserted, the texts of the style.

use super::outline::{Polyline, with_bulges};
use super::tokens::{Entity, entities};
use crate::Error;
use crate::geometry::Vector2;

/// What is drawn in one block; drawing units.
#[derive(Clone, Default)]
pub struct Block {
    pub name: String,
    pub base: Vector2,
    pub polylines: Vec<(i32, Polyline)>,
    pub points: Vec<Mark>,
    pub lines: Vec<(i32, [Vector2; 2])>,
    pub texts: Texts,
}

/// A POINT with its layer and its width (group 39).
#[derive(Clone, Copy)]
pub struct Mark {
    pub layer: i32,
    pub point: Vector2,
    pub width: f64,
}

/// One INSERT.
pub struct Insert {
    pub block: String,
    at: Vector2,
    scale: [f64; 2],
    /// rad.
    angle: f64,
}

/// All of a file.
#[derive(Default)]
pub struct Drawing {
    pub blocks: Vec<Block>,
    pub inserts: Vec<Insert>,
    /// Texts outside the blocks.
    pub style: Texts,
    /// What is drawn outside the blocks.
    pub loose: Block,
    /// Kinds of entities on layers of outlines that are not read, each once.
    pub unread: Vec<String>,
}

/// Texts of the form `Key: value`; keys in lower case.
#[derive(Clone, Default)]
pub struct Texts(Vec<(String, String)>);

impl Texts {
    fn add(&mut self, text: &str) {
        if let Some((key, value)) = text.split_once(':') {
            let key = key.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
            self.0.push((key, value.trim().to_owned()));
        }
    }

    /// The first value, not empty, of one of the keys.
    pub fn get(&self, keys: &[&str]) -> Option<&str> {
        let found = keys.iter().flat_map(|key| self.0.iter().filter(move |(k, v)| k == key && !v.is_empty()));
        found.map(|(_, value)| value.as_str()).next()
    }
}

/// A layer by its number; names that are none have -1.
fn layer_of(entity: &Entity) -> i32 {
    let name = entity.layer();
    name.parse::<i32>().ok().or_else(|| name.parse::<f64>().ok().map(|l| l as i32)).unwrap_or(-1)
}

/// Layers whose curves make outlines.
const OUTLINE_LAYERS: [i32; 4] = [1, 14, 84, 87];

impl Drawing {
    pub fn of(text: &str) -> Result<Self, Error> {
        let mut drawing = Self::default();
        let mut section = "";
        let mut block: Option<Block> = None;
        let mut all = entities(text)?.into_iter().peekable();
        while let Some(entity) = all.next() {
            match entity.kind {
                "SECTION" => section = entity.text(2).unwrap_or_default(),
                "BLOCK" => {
                    drawing.blocks.extend(block.take());
                    let name = entity.text(2).unwrap_or_default().to_owned();
                    let base = at(&entity, 10)?.unwrap_or_default();
                    block = Some(Block { name, base, ..Block::default() });
                }
                "ENDBLK" | "ENDSEC" => drawing.blocks.extend(block.take()),
                "INSERT" if block.is_none() && section == "ENTITIES" => drawing.inserts.push(insert(&entity)?),
                "TEXT" | "MTEXT" if block.is_none() && section == "ENTITIES" => {
                    drawing.style.add(entity.text(1).unwrap_or_default());
                }
                _ if section != "BLOCKS" && section != "ENTITIES" => {}
                _ => {
                    let target = block.as_mut().unwrap_or(&mut drawing.loose);
                    draw(&entity, &mut all, target, &mut drawing.unread)?;
                }
            }
        }
        drawing.blocks.extend(block);
        let system = |name: &str| {
            let name = name.to_ascii_uppercase();
            name.contains("MODEL_SPACE") || name.contains("PAPER_SPACE")
        };
        let (spaces, blocks) = drawing.blocks.into_iter().partition(|b: &Block| system(&b.name));
        drawing.blocks = blocks;
        // What lies in the model space is drawn outside the blocks.
        let spaces: Vec<Block> = spaces;
        for space in spaces {
            drawing.loose.polylines.extend(space.polylines);
            drawing.loose.points.extend(space.points);
            drawing.loose.lines.extend(space.lines);
        }
        Ok(drawing)
    }
}

fn at(entity: &Entity, code: i32) -> Result<Option<Vector2>, Error> {
    entity.point(code).map_err(|e| e.within(entity.kind))
}

fn insert(entity: &Entity) -> Result<Insert, Error> {
    let number = |code: i32, or: f64| Ok::<f64, Error>(entity.number(code)?.unwrap_or(or));
    let scale = [number(41, 1.0)?, number(42, 1.0)?].map(|s| if s == 0.0 { 1.0 } else { s });
    Ok(Insert {
        block: entity.text(2).unwrap_or_default().to_owned(),
        at: at(entity, 10)?.unwrap_or_default(),
        scale,
        angle: number(50, 0.0)?.to_radians(),
    })
}

/// Adds an entity, and the vertices that follow it, to a block.
fn draw<'t>(
    entity: &Entity<'t>,
    rest: &mut std::iter::Peekable<impl Iterator<Item = Entity<'t>>>,
    block: &mut Block,
    unread: &mut Vec<String>,
) -> Result<(), Error> {
    let layer = layer_of(entity);
    match entity.kind {
        "POLYLINE" => {
            let mut vertices = Vec::new();
            while let Some(vertex) = rest.next_if(|e| e.kind == "VERTEX") {
                if let Some(point) = at(&vertex, 10)? {
                    vertices.push((point, vertex.number(42)?.unwrap_or(0.0)));
                }
            }
            rest.next_if(|e| e.kind == "SEQEND");
            let closed = entity.flags() & 1 == 1;
            block.polylines.push((layer, Polyline { points: with_bulges(&vertices, closed), closed }));
        }
        "LWPOLYLINE" => {
            let closed = entity.flags() & 1 == 1;
            let points = with_bulges(&entity.light_vertices()?, closed);
            block.polylines.push((layer, Polyline { points, closed }));
        }
        "LINE" => {
            if let (Some(a), Some(b)) = (at(entity, 10)?, at(entity, 11)?) {
                match OUTLINE_LAYERS.contains(&layer) {
                    true => block.polylines.push((layer, Polyline { points: vec![a, b], closed: false })),
                    false => block.lines.push((layer, [a, b])),
                }
            }
        }
        "POINT" | "CIRCLE" => {
            if let Some(point) = at(entity, 10)? {
                let width = entity.number(39)?.unwrap_or(0.0);
                block.points.push(Mark { layer, point, width });
            }
        }
        "TEXT" | "MTEXT" => block.texts.add(entity.text(1).unwrap_or_default()),
        // Attributes tie notches to points, and orphans belong to polylines that are not there.
        "ATTDEF" | "ATTRIB" | "VERTEX" | "SEQEND" | "INSERT" => {}
        other if OUTLINE_LAYERS.contains(&layer) => {
            const MOST_KINDS: usize = 5;
            if unread.len() < MOST_KINDS && !unread.iter().any(|kind| kind == other) {
                unread.push(other.chars().take(30).collect());
            }
        }
        _ => {}
    }
    Ok(())
}

impl Block {
    /// The block as an insert shows it.
    pub fn inserted(&self, insert: &Insert) -> Self {
        let (sin, cos) = insert.angle.sin_cos();
        self.mapped(|p| {
            let p = p - self.base;
            let (x, y) = (p.x * insert.scale[0], p.y * insert.scale[1]);
            insert.at + Vector2::new(cos * x - sin * y, sin * x + cos * y)
        })
    }

    /// With every point mapped.
    pub fn mapped(&self, map: impl Fn(Vector2) -> Vector2) -> Self {
        let mut block = self.clone();
        block.polylines.iter_mut().flat_map(|(_, line)| &mut line.points).for_each(|p| *p = map(*p));
        block.points.iter_mut().for_each(|mark| mark.point = map(mark.point));
        block.lines.iter_mut().for_each(|(_, ends)| *ends = ends.map(&map));
        block
    }

    /// The corners of the box around its outlines, or around all polylines if none is on a layer of outlines.
    pub fn bounds(&self) -> Option<(Vector2, Vector2)> {
        let of = |outlines: bool| {
            let lines = self.polylines.iter().filter(move |(layer, _)| !outlines || OUTLINE_LAYERS.contains(layer));
            let points = lines.flat_map(|(_, line)| &line.points);
            points.fold(None, |bounds: Option<(Vector2, Vector2)>, p| {
                Some(bounds.map_or((*p, *p), |(low, high)| (low.inf(p), high.sup(p))))
            })
        };
        of(true).or_else(|| of(false))
    }

    /// Does it hold anything that could be an outline?
    pub fn has_outline(&self) -> bool {
        self.polylines.iter().any(|(layer, _)| OUTLINE_LAYERS.contains(layer))
    }
}
