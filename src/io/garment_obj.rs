//! The sewn garment as Wavefront OBJ, with the rest coordinates of its panels.
//!
//! A particle is one `v`, a point of a panel one `vt`: where panels are sewn, one `v` is named with
//! several `vt`, so that the file holds both the welded garment and its flat pattern. Normals are left
//! out: every reader computes smooth ones from the welded mesh, and a file without them is a third
//! smaller.

use crate::garment::Level;
use crate::geometry::Vector3;
use crate::pattern::Pattern;
use std::fmt::Write;

/// The text of the file. `positions` are the level's, one per particle, m, world.
///
/// Numbers are printed with as many digits as reading back the same `f64` takes.
pub fn write(pattern: &Pattern, level: &Level, positions: &[Vector3]) -> String {
    text(pattern, level, positions, Parts::Objects)
}

/// The same as one object, its panels groups of faces: programs that read each object as a mesh of its own, with
/// vertices of its own, then keep the garment sewn and its vertices in the order of the particles.
pub fn write_as_one(pattern: &Pattern, level: &Level, positions: &[Vector3]) -> String {
    text(pattern, level, positions, Parts::Groups)
}

/// What the panels are in the file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Parts {
    Objects,
    Groups,
}

fn text(pattern: &Pattern, level: &Level, positions: &[Vector3], parts: Parts) -> String {
    let mut text = String::with_capacity(64 * (positions.len() + level.rest.len()) + 40 * level.triangles.len());
    header(&mut text, parts);
    for p in positions {
        line(&mut text, format_args!("v {} {} {}", p.x, p.y, p.z));
    }
    for r in &level.rest {
        line(&mut text, format_args!("vt {} {}", r.x, r.y));
    }
    for (panel, range) in pattern.panels.iter().zip(&level.panels) {
        let key = if parts == Parts::Objects { "o" } else { "g" };
        line(&mut text, format_args!("{key} {}", one_line(&panel.name)));
        for triangle in &level.triangles[range.triangles.clone()] {
            // OBJ counts from one.
            let [a, b, c] = triangle.map(|point| (level.particle_of[point as usize] + 1, point + 1));
            line(&mut text, format_args!("f {}/{} {}/{} {}/{}", a.0, a.1, b.0, b.1, c.0, c.1));
        }
    }
    text
}

fn header(text: &mut String, parts: Parts) {
    line(text, format_args!("# Sewn garment by toile {}", env!("CARGO_PKG_VERSION")));
    line(text, format_args!("# v: positions in metres, y up, the body facing +z"));
    line(text, format_args!("# vt: rest coordinates on the panel in metres, in the panel's own frame"));
    match parts {
        Parts::Objects => line(text, format_args!("# o: one object for each panel, named as in the pattern")),
        Parts::Groups => {
            line(text, format_args!("# g: one group for each panel, named as in the pattern"));
            line(text, format_args!("o garment"));
        }
    }
}

fn line(text: &mut String, content: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{content}");
}

/// A name that stays on its line. Patterns with line breaks in a name are refused when they are
/// checked; a pattern made in memory may never have been.
fn one_line(name: &str) -> String {
    name.chars().map(|c| if breaks_lines(c) { '_' } else { c }).collect()
}

fn breaks_lines(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}')
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::sample::two_panels;

    /// `v`, `vt`, and per object its name and faces, as plain as a reader can be.
    type Read = (Vec<Vec<f64>>, Vec<Vec<f64>>, Vec<(String, Vec<Vec<[usize; 2]>>)>);

    fn read(text: &str) -> Read {
        let (mut v, mut vt, mut objects) = (Vec::new(), Vec::new(), Vec::<(String, Vec<Vec<[usize; 2]>>)>::new());
        for line in text.lines() {
            let (key, rest) = line.split_once(' ').unwrap();
            let numbers = || rest.split(' ').map(|n| n.parse().unwrap()).collect();
            match key {
                "v" => v.push(numbers()),
                "vt" => vt.push(numbers()),
                "o" => objects.push((rest.to_owned(), Vec::new())),
                "f" => objects.last_mut().unwrap().1.push(
                    rest.split(' ')
                        .map(|c| {
                            let (v, vt) = c.split_once('/').unwrap();
                            [v.parse::<usize>().unwrap() - 1, vt.parse::<usize>().unwrap() - 1]
                        })
                        .collect(),
                ),
                "#" => {}
                other => panic!("{other}"),
            }
        }
        (v, vt, objects)
    }

    #[test]
    fn every_number_reads_back_the_same() {
        let (pattern, garment, mut positions) = two_panels();
        positions[0] = Vector3::new(0.1 + 0.2, -1e-17, 1.0 / 3.0);
        let (v, vt, _) = read(&write(&pattern, &garment.levels[1], &positions));
        assert_eq!(v.len(), positions.len());
        assert!(v.iter().zip(&positions).all(|(a, b)| a.as_slice() == b.as_slice()));
        assert!(vt.iter().zip(&garment.levels[1].rest).all(|(a, b)| a.as_slice() == b.as_slice()));
    }

    #[test]
    fn a_sewn_vertex_is_one_v_with_several_vt() {
        let (pattern, garment, positions) = two_panels();
        let level = &garment.levels[1];
        let (v, vt, objects) = read(&write(&pattern, level, &positions));
        let names: Vec<&str> = objects.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["front", "back"]);
        assert_eq!(objects.iter().map(|(_, faces)| faces.len()).sum::<usize>(), level.triangles.len());
        let mut partners = vec![std::collections::BTreeSet::new(); v.len()];
        for [v, vt] in objects.iter().flat_map(|(_, faces)| faces.iter().flatten()) {
            partners[*v].insert(*vt);
        }
        let sewn = partners.iter().filter(|p| p.len() == 2).count();
        assert_eq!(sewn, level.seams[0][0].len());
        assert_eq!(vt.len(), v.len() + sewn);
    }

    #[test]
    fn normals_face_the_right_side_of_the_fabric() {
        let (pattern, garment, positions) = two_panels();
        let (v, _, objects) = read(&write(&pattern, &garment.levels[1], &positions));
        for ((_, faces), panel) in objects.iter().zip(&pattern.panels) {
            let [a, b, c] = [0, 1, 2].map(|k| Vector3::from_row_slice(&v[faces[0][k][0]]));
            assert!((b - a).cross(&(c - a)).dot(&panel.outward_normal()) > 0.0, "{}", panel.name);
        }
    }

    #[test]
    fn as_one_object_only_the_names_of_the_parts_differ() {
        let (pattern, garment, positions) = two_panels();
        let level = &garment.levels[1];
        let numbers = |text: String| text.lines().filter(|l| l.starts_with(['v', 'f'])).map(str::to_owned).collect();
        let apart: Vec<String> = numbers(write(&pattern, level, &positions));
        let one = write_as_one(&pattern, level, &positions);
        let keys: Vec<&str> = one.lines().filter(|l| l.starts_with(['o', 'g'])).collect();
        assert_eq!(keys, ["o garment", "g front", "g back"]);
        assert_eq!(apart, numbers(one));
    }

    #[test]
    fn no_name_breaks_its_line() {
        let (mut pattern, garment, positions) = two_panels();
        pattern.panels[0].name = "left\nf 1/1 2/2 3/3\r\u{2028}#".to_owned();
        let (_, _, objects) = read(&write(&pattern, &garment.levels[1], &positions));
        assert_eq!(objects.len(), 2);
        assert_eq!(objects[0].0, "left_f 1/1 2/2 3/3__#");
    }
}
