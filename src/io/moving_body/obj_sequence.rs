//! Sequences of OBJ files: the same triangles in all of them, vertices in the order of the file.

use crate::Error;
use crate::body::Motion;
use crate::body::motion::{MOST_FRAMES, check_baked_size};
use crate::geometry::Vector3;
use crate::io::{body_obj, read};
use std::path::{Path, PathBuf};

/// Positions, m, and triangles.
pub type Mesh = (Vec<Vector3>, Vec<[u32; 3]>);

/// The mesh of an OBJ file with all its vertices in their order, which caches count on.
pub fn mesh(bytes: &[u8]) -> Result<Mesh, Error> {
    body_obj::mesh_in_file_order(bytes)
}

/// A single file: a motion of one frame.
pub fn still(bytes: &[u8], frame_rate: f64) -> Result<Motion, Error> {
    let (positions, triangles) = mesh(bytes)?;
    Motion::baked(triangles, frame_rate, vec![positions])
}

/// Does the name stand for many files: `walk_%04d.obj`, `walk_%d.obj` or `walk_####.obj`?
pub fn is_pattern(path: &Path) -> bool {
    Pattern::of(path).is_some() && !path.exists()
}

/// All frames of a folder or of a pattern, in the order of their numbers.
pub fn open(path: &Path, frame_rate: f64) -> Result<Motion, Error> {
    let files = files(path).map_err(|e| e.within(path.display()))?;
    let mut frames = Vec::new();
    let mut first: Option<Vec<[u32; 3]>> = None;
    for file in &files {
        let (positions, triangles) = read::bytes(file).and_then(|b| mesh(&b).map_err(|e| e.within(file.display())))?;
        let vertices = frames.first().map_or(positions.len(), Vec::len);
        check_baked_size(vertices, files.len()).map_err(|e| e.within(path.display()))?;
        match &first {
            None => first = Some(triangles),
            Some(first) => {
                same_mesh(first, vertices, &triangles, positions.len()).map_err(|e| e.within(file.display()))?
            }
        }
        frames.push(positions);
    }
    Motion::baked(first.unwrap_or_default(), frame_rate, frames).map_err(|e| e.within(path.display()))
}

fn same_mesh(first: &[[u32; 3]], vertices: usize, now: &[[u32; 3]], vertices_now: usize) -> Result<(), Error> {
    let differs = |problem: String| {
        Error::new(
            problem,
            "All frames must be of one mesh: export them from one body, without modifiers that rebuild it.",
        )
    };
    if vertices_now != vertices {
        return Err(differs(format!("The frame has {vertices_now} vertices, the first one has {vertices}.")));
    }
    if now.len() != first.len() {
        return Err(differs(format!("The frame has {} triangles, the first one has {}.", now.len(), first.len())));
    }
    match first.iter().zip(now).position(|(a, b)| a != b) {
        None => Ok(()),
        Some(t) => Err(differs(format!("Triangle {} of the frame has other corners than in the first one.", t + 1))),
    }
}

/// What stands before and after the number in the name of a frame.
struct Pattern {
    folder: PathBuf,
    before: String,
    after: String,
}

impl Pattern {
    fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let (at, length) = number_place(name)?;
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned();
        Some(Self { folder, before: name[..at].to_owned(), after: name[at + length..].to_owned() })
    }
}

/// Where `%d`, `%04d` or `###` stands in a name, and how long it is.
fn number_place(name: &str) -> Option<(usize, usize)> {
    if let Some(at) = name.find('%') {
        let digits = name[at + 1..].bytes().take_while(u8::is_ascii_digit).count();
        return name[at + 1 + digits..].starts_with('d').then_some((at, digits + 2));
    }
    let at = name.find('#')?;
    Some((at, name[at..].bytes().take_while(|&b| b == b'#').count()))
}

fn files(path: &Path) -> Result<Vec<PathBuf>, Error> {
    let pattern = if path.is_dir() { None } else { Pattern::of(path) };
    let folder = pattern.as_ref().map_or(path, |p| &p.folder);
    let unreadable = |e: std::io::Error| {
        let problem = format!("The folder \"{}\" cannot be read: {e}.", folder.display());
        Error::new(problem, "Check the path; a relative one starts from the current folder.")
    };
    let mut found: Vec<(u64, String)> = Vec::new();
    let mut stem: Option<(String, String)> = pattern.as_ref().map(|p| (p.before.clone(), p.after.clone()));
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        names.extend(entry.map_err(unreadable)?.file_name().into_string());
        if names.len() > 10 * MOST_FRAMES {
            let problem = format!("The folder has more than {} files.", 10 * MOST_FRAMES);
            return Err(Error::new(problem, "Put the frames into a folder of their own."));
        }
    }
    names.sort_unstable();
    for name in names {
        let number = match &pattern {
            Some(p) => name.strip_prefix(&p.before).and_then(|rest| rest.strip_suffix(&p.after)).map(str::to_owned),
            None if name.to_ascii_lowercase().ends_with(".obj") => {
                let end = name.len() - 4;
                let digits = name[..end].bytes().rev().take_while(u8::is_ascii_digit).count();
                let here = (name[..end - digits].to_owned(), name[end..].to_owned());
                let first = stem.get_or_insert_with(|| here.clone());
                if *first != here {
                    return Err(Error::new(
                        format!("The folder has frames of two sequences: \"{}…\" and \"{}…\".", first.0, here.0),
                        "Name one of them by a pattern such as walk_%04d.obj.",
                    ));
                }
                Some(name[end - digits..end].to_owned())
            }
            None => None,
        };
        let Some(number) = number.filter(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit())) else { continue };
        let number =
            number.parse().map_err(|_| Error::new(format!("\"{name}\" has no possible number."), NUMBERING))?;
        found.push((number, name));
    }
    found.sort();
    if found.is_empty() {
        let problem = "There are no numbered OBJ files of this sequence.";
        return Err(Error::new(
            problem,
            "Name a folder of frames such as walk_0001.obj, or a pattern such as walk_%04d.obj.",
        ));
    }
    if let Some(w) = found.windows(2).find(|w| w[0].0.checked_add(1) != Some(w[1].0)) {
        return Err(Error::new(format!("After \"{}\" comes \"{}\".", w[0].1, w[1].1), NUMBERING));
    }
    if found.len() > MOST_FRAMES {
        let problem = format!("The sequence has {} frames, the limit is {MOST_FRAMES}.", found.len());
        return Err(Error::new(problem, "Cut it into shots."));
    }
    Ok(found.into_iter().map(|(_, name)| folder.join(name)).collect())
}

const NUMBERING: &str = "Number the frames one after the other, without gaps and each once.";

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

    fn write(folder: &Path, name: &str, text: &str) {
        std::fs::write(folder.join(name), text).unwrap();
    }

    #[test]
    fn a_folder_and_a_pattern_are_read_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        for k in 8..12 {
            let moved = TETRAHEDRON.replacen("v 0 0 0", &format!("v 0 0 -{k}"), 1);
            write(folder.path(), &format!("walk_{k}.obj"), &moved);
        }
        write(folder.path(), "notes.txt", "none");
        for name in ["", "walk_%d.obj", "walk_%04d.obj", "walk_##.obj"] {
            let motion = open(&folder.path().join(name), 30.0).unwrap();
            assert_eq!((motion.frame_count(), motion.vertex_count(), motion.frame_rate()), (4, 4, 30.0));
            assert_eq!([0, 1, 2, 3].map(|k| motion.positions(k)[0].z), [-8.0, -9.0, -10.0, -11.0]);
        }
    }

    #[test]
    fn the_frame_that_differs_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let problem = |third: &str| {
            (1..=3).for_each(|k| write(folder.path(), &format!("a{k}.obj"), if k == 3 { third } else { TETRAHEDRON }));
            open(folder.path(), 24.0).unwrap_err().to_string()
        };
        let turned = problem(&TETRAHEDRON.replace("f 2 3 4", "f 2 4 3"));
        assert!(turned.contains("a3.obj") && turned.contains("Triangle 4"), "{turned}");
        assert!(problem(&format!("{TETRAHEDRON}v 2 2 2\n")).contains("5 vertices"));
        assert!(problem("v nan 0 0").contains("a3.obj, line 1"));
        std::fs::remove_file(folder.path().join("a2.obj")).unwrap();
        write(folder.path(), "a3.obj", TETRAHEDRON);
        assert!(open(folder.path(), 24.0).unwrap_err().problem().contains("After \"a1.obj\" comes \"a3.obj\""));
        write(folder.path(), "b2.obj", TETRAHEDRON);
        assert!(open(folder.path(), 24.0).unwrap_err().problem().contains("two sequences"));
        assert!(open(&folder.path().join("c%d.obj"), 24.0).unwrap_err().problem().contains("no numbered"));
    }
}
