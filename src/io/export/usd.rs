//! The sewn garment as USD text (`.usda`): a mesh with time samples, its flat rest coordinates as texture coordinates
//! *and* as a rest shape, a subset of faces for each panel, and the fabric as a physical material.
//!
//! The attributes `physics:...` of cloth are those of the proposal for deformable bodies that AOUSD, the alliance behind
//! USD, discusses (`PhysicsSurfaceDeformableSimAPI`, `PhysicsSurfaceDeformableMaterialAPI`), as Newton 1.8 reads them. USD
//! itself does not know these schemas yet and carries them along. What no schema has a place for is under `toile:`.

use super::frames::{Frames, for_each};
use super::{Isotropic, Source};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::io::atomic::Unfinished;
use std::collections::BTreeSet;
use std::fmt::Display;
use std::io::{self, Write};

/// Writes the text of the file, frame after frame.
pub fn write(source: &Source, frames: &mut dyn Frames, out: &mut impl Write) -> Result<(), Unfinished> {
    let (rate, count) = (frames.frame_rate(), frames.frame_count());
    layer(out, rate, count)?;
    writeln!(out, "def Xform \"garment\" (\n    kind = \"component\"\n)\n{{")?;
    writeln!(out, "    def Mesh \"cloth\" (")?;
    writeln!(
        out,
        "        prepend apiSchemas = [\"MaterialBindingAPI\", \"PhysicsSurfaceDeformableSimAPI\"]\n    )\n    {{"
    )?;
    points(out, frames)?;
    topology(out, source.level)?;
    rest(out, source.level)?;
    about(out, source)?;
    panels(out, source)?;
    writeln!(out, "    }}\n")?;
    material(out, source)?;
    writeln!(out, "}}")?;
    Ok(())
}

fn layer(out: &mut impl Write, rate: f64, count: usize) -> io::Result<()> {
    writeln!(out, "#usda 1.0\n(")?;
    writeln!(out, "    doc = \"Sewn garment by toile {}\"", env!("CARGO_PKG_VERSION"))?;
    writeln!(
        out,
        "    defaultPrim = \"garment\"\n    metersPerUnit = 1\n    kilogramsPerUnit = 1\n    upAxis = \"Y\""
    )?;
    if count > 1 {
        writeln!(out, "    startTimeCode = 0\n    endTimeCode = {}", count - 1)?;
        writeln!(out, "    timeCodesPerSecond = {rate}\n    framesPerSecond = {rate}")?;
    }
    writeln!(out, ")\n")
}

/// The first frame as what holds without a time, then all of them with theirs, and the box around each.
fn points(out: &mut impl Write, frames: &mut dyn Frames) -> Result<(), Unfinished> {
    let mut first = Vec::new();
    frames.read(0, &mut first)?;
    write!(out, "        point3f[] points = ")?;
    list(out, first.iter().map(|p| tuple(p.as_slice())))?;
    writeln!(out, "        float3[] extent = {}", extent(&first))?;
    if frames.frame_count() == 1 {
        return Ok(());
    }
    let mut extents = Vec::new();
    writeln!(out, "        point3f[] points.timeSamples = {{")?;
    for_each::<Unfinished>(frames, |frame, positions| {
        extents.push(extent(positions));
        write!(out, "            {frame}: ")?;
        items(out, positions.iter().map(|p| tuple(p.as_slice())))?;
        Ok(writeln!(out, ",")?)
    })?;
    writeln!(out, "        }}\n        float3[] extent.timeSamples = {{")?;
    for (frame, extent) in extents.iter().enumerate() {
        writeln!(out, "            {frame}: {extent},")?;
    }
    Ok(writeln!(out, "        }}")?)
}

fn extent(positions: &[Vector3]) -> String {
    let start = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
    let [low, high] = positions.iter().fold(start, |[low, high], p| [low.inf(p), high.sup(p)]);
    format!("[{}, {}]", tuple(low.as_slice()), tuple(high.as_slice()))
}

fn topology(out: &mut impl Write, level: &Level) -> io::Result<()> {
    write!(out, "        int[] faceVertexCounts = ")?;
    list(out, level.triangles.iter().map(|_| 3))?;
    write!(out, "        int[] faceVertexIndices = ")?;
    list(out, level.particle_triangles().iter().flatten())?;
    writeln!(out, "        uniform token subdivisionScheme = \"none\"")?;
    writeln!(out, "        uniform token orientation = \"rightHanded\"")?;
    writeln!(out, "        uniform bool doubleSided = 1")
}

fn rest(out: &mut impl Write, level: &Level) -> io::Result<()> {
    write!(out, "        texCoord2f[] primvars:st = ")?;
    items(out, level.rest.iter().map(|r| tuple(r.as_slice())))?;
    writeln!(out, " (\n            interpolation = \"faceVarying\"\n        )")?;
    write!(out, "        int[] primvars:st:indices = ")?;
    list(out, level.triangles.iter().flatten())?;
    // The panels flat, each in its own frame: only differences between the corners of a triangle have a meaning.
    write!(out, "        point3f[] physics:restShapePoints = ")?;
    list(out, level.rest.iter().map(|r| tuple(&[r.x, r.y, 0.0])))?;
    write!(out, "        int3[] physics:restTriVertexIndices = ")?;
    list(out, level.triangles.iter().map(|[a, b, c]| format!("({a}, {b}, {c})")))?;
    writeln!(out, "        token physics:restBendAnglesDefault = \"flat\"")
}

fn about(out: &mut impl Write, source: &Source) -> io::Result<()> {
    writeln!(out, "        float[] physics:thicknesses = [{}]", source.fabric.thickness as f32)?;
    writeln!(out, "        token physics:thicknesses:elementType = \"constant\"")?;
    writeln!(out, "        rel material:binding:physics = </garment/fabric>")?;
    writeln!(out, "        custom string toile:pattern = {}", quoted(&source.pattern.name))?;
    writeln!(out, "        custom double toile:clearance = {}", source.clearance)?;
    write!(out, "        custom int[] toile:particleOfPoint = ")?;
    list(out, source.level.particle_of.iter())
}

fn panels(out: &mut impl Write, source: &Source) -> io::Result<()> {
    writeln!(out, "        uniform token subsetFamily:panel:familyType = \"partition\"")?;
    let mut taken = BTreeSet::new();
    for (panel, range) in source.pattern.panels.iter().zip(&source.level.panels) {
        let name = identifier(&panel.name, &mut taken);
        writeln!(
            out,
            "\n        def GeomSubset \"{name}\" (\n            displayName = {}\n        )\n        {{",
            quoted(&panel.name)
        )?;
        writeln!(
            out,
            "            uniform token elementType = \"face\"\n            uniform token familyName = \"panel\""
        )?;
        write!(out, "            int[] indices = ")?;
        list(out, range.triangles.clone())?;
        writeln!(out, "            custom int2 toile:points = ({}, {})", range.points.start, range.points.end)?;
        writeln!(out, "        }}")?;
    }
    Ok(())
}

fn material(out: &mut impl Write, source: &Source) -> io::Result<()> {
    let fabric = source.fabric;
    let isotropic = Isotropic::of(fabric);
    let (young, poisson) = (isotropic.stretch, fabric.poisson_ratio);
    writeln!(out, "    def Material \"fabric\" (\n        displayName = {}", quoted(&fabric.name))?;
    writeln!(
        out,
        "        prepend apiSchemas = [\"PhysicsMaterialAPI\", \"PhysicsSurfaceDeformableMaterialAPI\"]\n    )\n    {{"
    )?;
    let physics = [
        ("density", fabric.areal_density / fabric.thickness),
        ("staticFriction", fabric.friction),
        ("dynamicFriction", fabric.friction),
        ("poissonsRatio", poisson),
        ("surfaceStretchStiffness", young / (1.0 - poisson * poisson)),
        ("surfaceShearStiffness", fabric.shear),
        ("surfaceBendStiffness", isotropic.bending),
    ];
    for (name, value) in physics {
        writeln!(out, "        float physics:{name} = {}", value as f32)?;
    }
    for (name, value) in crate::io::fabric_toml::figures(fabric) {
        writeln!(out, "        custom double toile:{name} = {value}")?;
    }
    writeln!(out, "    }}")
}

/// Numbers as f32, printed with as many digits as reading back the same takes.
fn tuple(numbers: &[f64]) -> String {
    let texts: Vec<String> = numbers.iter().map(|&x| (x as f32).to_string()).collect();
    format!("({})", texts.join(", "))
}

fn list(out: &mut impl Write, values: impl Iterator<Item = impl Display>) -> io::Result<()> {
    items(out, values)?;
    writeln!(out)
}

fn items(out: &mut impl Write, values: impl Iterator<Item = impl Display>) -> io::Result<()> {
    write!(out, "[")?;
    for (k, value) in values.enumerate() {
        write!(out, "{}{value}", if k == 0 { "" } else { ", " })?;
    }
    write!(out, "]")
}

/// A name as USD allows them, that no other panel has.
fn identifier(name: &str, taken: &mut BTreeSet<String>) -> String {
    let mut plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !plain.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        plain.insert(0, '_');
    }
    let numbered = |n: usize| if n == 1 { plain.clone() } else { format!("{plain}_{n}") };
    let free = (1..).map(numbered).find(|name| !taken.contains(name)).expect("there are more numbers than panels");
    taken.insert(free.clone());
    free
}

/// Text in quotes, which stays on its line.
fn quoted(text: &str) -> String {
    let escaped: String = text
        .chars()
        .map(|c| match c {
            '"' => "\\\"".to_owned(),
            '\\' => "\\\\".to_owned(),
            c if c.is_control() => "_".to_owned(),
            c => c.to_string(),
        })
        .collect();
    format!("\"{escaped}\"")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::export::Sequence;
    use crate::io::sample::two_panels;
    use crate::pattern::Fabric;

    fn written(count: usize, rename: impl Fn(&mut crate::pattern::Pattern)) -> (String, Level, Vec<Vector3>) {
        let (mut pattern, garment, positions) = two_panels();
        rename(&mut pattern);
        let level = garment.levels[1].clone();
        let source =
            Source { pattern: &pattern, level: &level, fabric: &Fabric::default(), clearance: 0.0007, skin: None };
        let moved = |k: usize| positions.iter().map(|p| p + Vector3::x() * k as f64).collect();
        let mut frames = Sequence { frame_rate: 25.0, frames: (0..count).map(moved).collect() };
        let mut file = Vec::new();
        write(&source, &mut frames, &mut file).unwrap();
        (String::from_utf8(file).unwrap(), level, positions)
    }

    /// The numbers after an attribute's name on its line.
    fn numbers(text: &str, name: &str) -> Vec<f32> {
        let line = text.lines().find(|line| line.contains(name)).unwrap_or_else(|| panic!("no {name}"));
        let value = line.split_once(name).unwrap().1;
        let split = value.split(|c: char| !c.is_ascii_digit() && !"+-.".contains(c));
        split.filter_map(|number| number.parse().ok()).collect()
    }

    #[test]
    fn points_rest_coordinates_and_faces_read_back_to_single_precision() {
        let (text, level, positions) = written(1, |_| {});
        let expected: Vec<f32> = positions.iter().flatten().map(|&x| x as f32).collect();
        assert_eq!(numbers(&text, "points = "), expected);
        let rest: Vec<f32> = level.rest.iter().flatten().map(|&x| x as f32).collect();
        assert_eq!(numbers(&text, "primvars:st = "), rest);
        assert_eq!(numbers(&text, "restShapePoints = ").len(), 3 * level.rest.len());
        let corners: Vec<f32> = level.particle_triangles().iter().flatten().map(|&i| i as f32).collect();
        assert_eq!(numbers(&text, "faceVertexIndices = "), corners);
        assert!(
            !text.contains("timeSamples") && text.contains("metersPerUnit = 1\n") && text.contains("upAxis = \"Y\"")
        );
        let open = |c: char| text.matches(c).count();
        assert_eq!((open('{'), open('[')), (open('}'), open(']')));
    }

    #[test]
    fn every_frame_is_a_time_sample_with_its_extent() {
        let (text, _, positions) = written(3, |_| {});
        assert!(text.contains("endTimeCode = 2\n") && text.contains("timeCodesPerSecond = 25\n"));
        let second = numbers(&text, " 2: [(");
        assert_eq!(second[0], (positions[0].x + 2.0) as f32);
        assert_eq!(text.matches(" 2: [").count(), 2);
    }

    #[test]
    fn names_of_panels_are_made_fit_and_kept_beside() {
        let (text, ..) = written(1, |pattern| {
            pattern.panels[0].name = "2 \"Ärmel\"\n".into();
            pattern.panels[1].name = "2 'Ärmel' ".into();
        });
        assert!(
            text.contains("def GeomSubset \"_2___rmel__\" (\n            displayName = \"2 \\\"Ärmel\\\"_\""),
            "{text}"
        );
        assert!(text.contains("def GeomSubset \"_2___rmel___2\""));
    }
}
