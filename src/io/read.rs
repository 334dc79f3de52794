//! Files as they come from users: missing, huge, folders, or not text at all.

use crate::Error;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// The largest file that is read, bytes; patterns have a megabyte, bodies a few hundred at most.
pub const MOST_BYTES: u64 = 512 << 20;

/// The bytes of a file.
pub fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    at_most(path, MOST_BYTES).map_err(|e| e.within(path.display()))
}

/// The text of a file, which must be UTF-8.
pub fn text(path: &Path) -> Result<String, Error> {
    utf8(bytes(path)?).map_err(|e| e.within(path.display()))
}

/// Bytes as text. The error names the offset of the first that is not UTF-8.
pub fn utf8(bytes: Vec<u8>) -> Result<String, Error> {
    String::from_utf8(bytes).map_err(|e| {
        Error::new(
            format!("It is not UTF-8 text: the byte at offset {} does not fit.", e.utf8_error().valid_up_to()),
            "Save the file as UTF-8, or check that it is the right file.",
        )
    })
}

/// The SHA-256 of some bytes in lower-case hexadecimal digits.
pub fn sha256_hex(bytes: &[u8]) -> String {
    hexadecimal(&sha256(bytes))
}

/// The SHA-256 of a file of any size, which is not held in memory, and its length in bytes.
pub fn sha256_of_file(path: &Path) -> Result<(String, u64), Error> {
    let unreadable = |e: io::Error| unreadable(path, &e).within(path.display());
    let mut file = File::open(path).map_err(unreadable)?;
    let mut digest = Sha256::new();
    let length = io::copy(&mut file, &mut Digested(&mut digest)).map_err(unreadable)?;
    Ok((hexadecimal(&digest.finalize()), length))
}

/// A digest that bytes are copied into.
struct Digested<'a>(&'a mut Sha256);

impl io::Write for Digested<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Bytes in lower-case hexadecimal digits.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The SHA-256 of some bytes.
pub fn sha256(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}

fn at_most(path: &Path, most: u64) -> Result<Vec<u8>, Error> {
    let too_large = || {
        Error::new(
            format!("The file has more than {} MiB.", most >> 20),
            "Check that it is the right file; reduce the mesh if it is.",
        )
    };
    let unreadable = |e: io::Error| unreadable(path, &e);
    let about = fs::metadata(path).map_err(unreadable)?;
    if about.is_dir() {
        return Err(Error::new("It is a folder.", "Name a file inside it."));
    }
    if about.len() > most {
        return Err(too_large());
    }
    // What is no plain file may be longer than it says.
    let mut bytes = Vec::with_capacity(about.len() as usize);
    File::open(path).and_then(|file| file.take(most + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
    if bytes.len() as u64 > most {
        return Err(too_large());
    }
    Ok(bytes)
}

pub(super) fn unreadable(path: &Path, error: &io::Error) -> Error {
    match error.kind() {
        ErrorKind::NotFound => {
            let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
            let problem = if folder.is_dir() {
                format!("There is no such file in the folder \"{}\".", folder.display())
            } else {
                format!("The folder {} does not exist.", folder.display())
            };
            Error::new(problem, "Check the path; a relative one starts from the current folder.")
        }
        ErrorKind::PermissionDenied => {
            Error::new("Reading it is not permitted.", "Change the permissions of the file, or copy it.")
        }
        _ => Error::new(format!("It cannot be read: {error}."), "Check the path and the disk."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "héllo").unwrap();
        assert_eq!(text(&path).unwrap(), "héllo");
        assert_eq!(bytes(&path).unwrap(), "héllo".as_bytes());
    }

    #[test]
    fn what_cannot_be_read_says_why() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        assert!(bytes(&path).unwrap_err().problem().contains("no such file in the folder"));
        assert!(bytes(&path.join("file")).unwrap_err().problem().starts_with("The folder"));
        assert!(bytes(folder.path()).unwrap_err().problem().contains("is a folder"));
        fs::write(&path, b"text\xff").unwrap();
        assert!(text(&path).unwrap_err().problem().contains("offset 4"));
        fs::write(&path, [0; 11]).unwrap();
        assert!(at_most(&path, 10).is_err() && at_most(&path, 11).is_ok());
    }

    #[test]
    fn a_file_has_the_digest_of_its_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let bytes = [1, 2, 3].repeat(100_000);
        fs::write(&path, &bytes).unwrap();
        assert_eq!(sha256_of_file(&path).unwrap(), (sha256_hex(&bytes), 300_000));
        assert!(sha256_of_file(&folder.path().join("none")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn an_endless_file_is_cut_short() {
        assert!(at_most(Path::new("/dev/zero"), 1000).is_err());
    }

    #[test]
    fn digests_are_those_of_the_standard() {
        // FIPS 180-4, the example of one block.
        assert_eq!(sha256_hex(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
