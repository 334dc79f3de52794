//! `manifest.json`: what the files of an export are, what their numbers mean, and what they came from.
//!
//! Fields are added without a new version; when one changes its meaning or goes, the version grows. Nothing in it tells of
//! time or machine. `docs/formats.md` tells the fields one by one.

use super::frames::Frames;
use super::{Source, Target};
use crate::io::fabric_toml::figures;
use crate::io::report::{FabricPart, to_json};
use serde::Serialize;

/// Its name in the folder of an export.
pub const MANIFEST: &str = "manifest.json";

/// What an export came from; digests in hexadecimal.
#[derive(Clone, Debug, Serialize)]
pub struct Origin {
    /// Of the file `state.toile`.
    pub state_sha256: String,
    pub pattern: NamedFile,
    pub body: NamedFile,
    /// `null` for a garment at rest.
    pub motion: Option<MotionPart>,
    /// `null` where nothing follows a skin.
    pub skin: Option<SkinPart>,
}

#[derive(Clone, Debug, Serialize)]
pub struct NamedFile {
    pub name: String,
    pub sha256: String,
}

/// Which frames of which motion.
#[derive(Clone, Debug, Serialize)]
pub struct MotionPart {
    pub sha256: String,
    /// Number in the motion of the first frame that is exported.
    pub first_frame: usize,
    /// Every how manieth frame of the motion is exported.
    pub step: usize,
}

/// The body that a skinned garment follows, and the frame in whose pose the garment is.
#[derive(Clone, Debug, Serialize)]
pub struct SkinPart {
    #[serde(flatten)]
    pub file: NamedFile,
    /// As it was asked for; `null` for the first.
    pub clip: Option<String>,
    pub frame: usize,
}

/// A file of the set.
#[derive(Clone, Debug, Serialize)]
pub struct FilePart {
    pub name: String,
    pub about: &'static str,
    pub bytes: u64,
    pub sha256: String,
}

#[derive(Serialize)]
struct Manifest<'a> {
    format: &'static str,
    version: u32,
    toile_version: &'static str,
    targets: Vec<&'static str>,
    from: &'a Origin,
    units: Units,
    axes: Axes,
    vertices: Vertices,
    triangles: Triangles,
    panels: Vec<PanelPart<'a>>,
    rest: Rest,
    fabric: FabricPart,
    clearance_m: f64,
    resolution_m: f64,
    frames: FramesPart,
    files: &'a [FilePart],
}

#[derive(Serialize)]
struct Units {
    length: &'static str,
    mass: &'static str,
    time: &'static str,
    metres_per_unit: f64,
}

#[derive(Serialize)]
struct Axes {
    up: &'static str,
    front_of_body: &'static str,
    left_of_body: &'static str,
    handedness: &'static str,
    /// How to turn a position for a program whose z is up.
    z_up_from_y_up: &'static str,
}

#[derive(Serialize)]
struct Vertices {
    sewn: usize,
    sewn_order: &'static str,
    flat: usize,
    flat_order: &'static str,
}

#[derive(Serialize)]
struct Triangles {
    count: usize,
    winding: &'static str,
}

#[derive(Serialize)]
struct PanelPart<'a> {
    name: &'a str,
    /// Its flat vertices, the first and the one after the last.
    flat_vertices: [usize; 2],
    triangles: [usize; 2],
    /// The right side of the fabric is its own -z; its triangles run clockwise in rest coordinates.
    clockwise: bool,
}

#[derive(Serialize)]
struct Rest {
    file: &'static str,
    /// Arrays of the file: two numbers for each flat vertex, m, warp along y.
    coordinates: &'static str,
    /// The sewn vertex of each flat vertex.
    sewn_from_flat: &'static str,
    /// Flat vertices of each triangle, and sewn ones.
    triangles_flat: &'static str,
    triangles_sewn: &'static str,
    in_garment_obj: &'static str,
}

#[derive(Serialize)]
struct FramesPart {
    count: usize,
    /// Frames a second; `null` for a garment at rest.
    rate: Option<f64>,
}

/// The text of the file.
pub fn text(source: &Source, origin: &Origin, targets: &[Target], frames: &dyn Frames, files: &[FilePart]) -> String {
    let (pattern, level) = (source.pattern, source.level);
    let count = frames.frame_count();
    let panels = pattern.panels.iter().zip(&level.panels).map(|(panel, range)| PanelPart {
        name: &panel.name,
        flat_vertices: [range.points.start, range.points.end],
        triangles: [range.triangles.start, range.triangles.end],
        clockwise: panel.signed_area() < 0.0,
    });
    to_json(&Manifest {
        format: "toile export",
        version: 1,
        toile_version: env!("CARGO_PKG_VERSION"),
        targets: Target::ALL.into_iter().filter(|kind| targets.contains(kind)).map(Target::name).collect(),
        from: origin,
        units: Units { length: "m", mass: "kg", time: "s", metres_per_unit: 1.0 },
        axes: Axes {
            up: "+y",
            front_of_body: "+z",
            left_of_body: "+x",
            handedness: "right",
            z_up_from_y_up: "(x, y, z) -> (x, -z, y)",
        },
        vertices: Vertices {
            sewn: level.particle_count,
            sewn_order: "the particles of the finest level, as `v` in garment.obj; in all files but those of flat vertices",
            flat: level.rest.len(),
            flat_order: "the points of the panels, panel by panel, as `vt` in garment.obj; in garment.glb and rest.ply",
        },
        triangles: Triangles {
            count: level.triangles.len(),
            winding: "counter-clockwise seen from the right side of the fabric, the same order in all files",
        },
        panels: panels.collect(),
        rest: Rest {
            file: "rest.npz",
            coordinates: "rest",
            sewn_from_flat: "particle_of_point",
            triangles_flat: "triangle_points",
            triangles_sewn: "triangle_particles",
            in_garment_obj: "f v/vt: v counts sewn vertices, vt flat ones, both from one",
        },
        fabric: FabricPart { name: source.fabric.name.clone(), figures: figures(source.fabric).into_iter().collect() },
        clearance_m: source.clearance,
        resolution_m: level.resolution,
        frames: FramesPart { count, rate: (count > 1).then(|| frames.frame_rate()) },
        files,
    })
}
