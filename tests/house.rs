//! The plan of the house (docs/architecture.md): arrows point downwards, and only the doors lead outside.

use std::path::{Path, PathBuf};

/// Rooms from the cellar up; a room uses those in the lines above its own. `error` is carried everywhere.
const FLOORS: [&[&str]; 10] = [
    &["error"],
    &["geometry"],
    &["minimize"],
    &["pattern", "body"],
    &["garment"],
    &["energy", "contact", "assess", "arrangement"],
    &["prepositioning", "check"],
    &["dynamics"],
    &["io"],
    &["cli"],
];
/// Rooms that may read, write, print and ask the machine.
const DOORS: [&str; 2] = ["io", "cli"];

fn floor(room: &str) -> usize {
    let found = FLOORS.iter().position(|rooms| rooms.contains(&room));
    found.unwrap_or_else(|| panic!("give the room {room} a floor, here and in docs/architecture.md"))
}

/// Room and code of every file of the library and of the command line, without comments and unit tests.
fn files() -> Vec<(PathBuf, String, String)> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![source.clone()];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let inner = path.strip_prefix(&source).unwrap().with_extension("");
            let room = inner.iter().next().unwrap().to_str().unwrap().to_owned();
            if path.extension().is_none_or(|e| e != "rs") || ["lib", "main"].contains(&room.as_str()) {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
            let code = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
            files.push((inner, room, code));
        }
    }
    files.sort();
    files
}

/// The rooms that `crate::room` and `crate::{room, ...}` name; the crate's own names are those of `error`.
fn rooms_used(code: &str) -> Vec<&str> {
    let after = code.match_indices("crate::").map(|(at, found)| &code[at + found.len()..]);
    let named = after.flat_map(|rest| match rest.strip_prefix('{') {
        Some(list) => list.split('}').next().unwrap().split(',').collect::<Vec<_>>(),
        None => vec![rest],
    });
    let first = |path: &'_ str| path.trim().split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap().len();
    let rooms = named.map(|path| &path.trim()[..first(path)]).filter(|room| !room.is_empty());
    rooms.map(|room| if room.starts_with(char::is_uppercase) { "error" } else { room }).collect()
}

#[test]
fn arrows_point_downwards() {
    let mut arrows = 0;
    for (file, room, code) in files() {
        for used in rooms_used(&code).into_iter().filter(|used| *used != room) {
            assert!(floor(used) < floor(&room), "{} uses the room {used}", file.display());
            arrows += 1;
        }
    }
    assert!(arrows > 50, "{arrows} arrows are too few to be all");
}

#[test]
fn only_the_doors_lead_outside() {
    for (file, room, code) in files().iter().filter(|(_, room, _)| !DOORS.contains(&room.as_str())) {
        for outside in ["std::fs", "std::io", "std::env", "std::time", "std::process", "print!", "println!", "dbg!"] {
            assert!(!code.contains(outside), "{} of {room} uses {outside}", file.display());
        }
    }
}
