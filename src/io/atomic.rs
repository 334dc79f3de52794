//! Files that are either the old one or the whole new one, whatever happens in between.
//!
//! The bytes go to a temporary file in the same folder, which takes the final name once it is on the
//! disk. A process that is killed leaves at most a file named `.NAME.PROCESS-COUNT.tmp`.

use crate::Error;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes `bytes` to `path`, which may exist. The errors name the path and what to do.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    replace(path, |file| file.write_all(bytes)).map_err(|e| refused(path, &e))
}

/// Why a file that is written piece by piece did not become whole.
#[derive(Debug)]
pub enum Unfinished {
    /// It could not be written.
    Disk(io::Error),
    /// What it was to be made of is wrong.
    Input(Error),
}

impl From<io::Error> for Unfinished {
    fn from(error: io::Error) -> Self {
        Unfinished::Disk(error)
    }
}

impl From<Error> for Unfinished {
    fn from(error: Error) -> Self {
        Unfinished::Input(error)
    }
}

/// Writes what is too large to be held in memory: `fill` gives it piece by piece.
pub fn write_pieces(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), Unfinished>,
) -> Result<(), Error> {
    let mut wrong = None;
    let written = replace(path, |file| {
        let mut pieces = BufWriter::with_capacity(1 << 20, file);
        match fill(&mut pieces) {
            Ok(()) => pieces.flush(),
            Err(Unfinished::Disk(e)) => Err(e),
            Err(Unfinished::Input(e)) => {
                wrong = Some(e);
                Err(io::Error::other("the input is wrong"))
            }
        }
    });
    written.map_err(|e| wrong.unwrap_or_else(|| refused(path, &e)))
}

/// Writes by `fill` to a temporary file, then gives it the name `path`.
fn replace(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let temporary = temporary_beside(path)?;
    let written = (|| {
        // `create_new` refuses to follow a link that somebody else laid there.
        let mut file = OpenOptions::new().write(true).create_new(true).open(&temporary)?;
        fill(&mut file)?;
        file.sync_all()?;
        drop(file);
        fs::rename(&temporary, path)
    })();
    match &written {
        Ok(()) => sync_folder(path),
        // A file of that name that we did not make is not ours to remove.
        Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
        Err(_) => {
            let _ = fs::remove_file(&temporary);
        }
    }
    written
}

fn temporary_beside(path: &Path) -> io::Result<PathBuf> {
    /// Distinguishes the files of one process.
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().ok_or_else(|| io::Error::new(ErrorKind::InvalidInput, "the path has no file name"))?;
    loop {
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let mut temporary = std::ffi::OsString::from(".");
        temporary.push(name);
        temporary.push(format!(".{}-{count}.tmp", std::process::id()));
        let temporary = path.with_file_name(temporary);
        // One may be left over from a process of the same number.
        if !temporary.exists() {
            return Ok(temporary);
        }
    }
}

/// Asks for the new name to be on the disk too. Not every file system can; the file is whole anyway.
fn sync_folder(path: &Path) {
    if let Ok(folder) = File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

pub(super) fn refused(path: &Path, error: &io::Error) -> Error {
    let folder = folder_of(path).display();
    let (problem, remedy) = match error.kind() {
        ErrorKind::NotFound => {
            (format!("The folder {folder} does not exist."), "Create it, or name another.".to_owned())
        }
        ErrorKind::NotADirectory => (format!("{folder} is not a folder."), "Name a folder.".to_owned()),
        ErrorKind::IsADirectory | ErrorKind::DirectoryNotEmpty => {
            ("There is a folder of that name.".to_owned(), "Name another file, or move the folder away.".to_owned())
        }
        ErrorKind::PermissionDenied => (
            format!("Writing to {folder} is not permitted."),
            "Change the permissions of the folder, or name another.".to_owned(),
        ),
        ErrorKind::ReadOnlyFilesystem => {
            (format!("{folder} can only be read."), "Name a folder on a disk that can be written.".to_owned())
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => (
            format!("The disk that holds {folder} is full."),
            "Make room, or name a folder on another disk.".to_owned(),
        ),
        _ => (format!("The file cannot be written: {error}."), "Check the path, or name another.".to_owned()),
    };
    Error::new(problem, remedy).within(path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn files_are_created_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("garment.obj");
        for bytes in [&b"first"[..], b"the second, longer", b""] {
            write(&path, bytes).unwrap();
            assert_eq!(fs::read(&path).unwrap(), bytes);
            assert_eq!(names(folder.path()), ["garment.obj"]);
        }
    }

    #[test]
    fn an_existing_file_is_whole_after_a_failing_write() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("garment.obj");
        write(&path, b"whole").unwrap();
        let full = replace(&path, |file| {
            file.write_all(b"ha")?;
            Err(ErrorKind::StorageFull.into())
        });
        assert!(refused(&path, &full.unwrap_err()).problem().contains("full"));
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(folder.path()), ["garment.obj"]);
    }

    #[test]
    fn until_the_end_nothing_has_the_final_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("garment.obj");
        replace(&path, |file| {
            file.write_all(b"half")?;
            let names = names(folder.path());
            assert!(names.len() == 1 && names[0].starts_with(".garment.obj."), "{names:?}");
            Ok(())
        })
        .unwrap();
        assert_eq!(names(folder.path()), ["garment.obj"]);
    }

    #[test]
    fn a_file_whose_pieces_end_in_an_error_is_not_there_and_tells_that_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("garment.pc2");
        let told = write_pieces(&path, |file| {
            file.write_all(b"half")?;
            Err(Error::new("Frame 2 is damaged.", "Simulate it again.").into())
        });
        assert_eq!(told.unwrap_err().problem(), "Frame 2 is damaged.");
        assert!(names(folder.path()).is_empty());
        write_pieces(&path, |file| Ok(file.write_all(b"whole")?)).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
    }

    #[test]
    fn errors_name_the_path_and_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let error = write(&folder.path().join("none/garment.obj"), b"").unwrap_err();
        assert!(error.problem().contains("does not exist") && error.place().contains("garment.obj"));
        let error = write(folder.path(), b"").unwrap_err();
        assert!(error.problem().contains("folder"), "{error}");
        fs::write(folder.path().join("file"), b"").unwrap();
        assert!(write(&folder.path().join("file/garment.obj"), b"").unwrap_err().problem().contains("not a folder"));
        for path in ["", "/", ".."] {
            assert!(write(Path::new(path), b"").is_err(), "{path}");
        }
        assert_eq!(names(folder.path()), ["file"]);
    }
}
