//! `state.toile`: all that a later command needs to go on from a fitted garment.
//!
//! The file holds the pattern as text, in our own format, and the settings, from which the levels are built again
//! exactly; of the run it holds the positions alone. Layout, all numbers little-endian:
//!
//! ```text
//! 8 bytes   "TOILE\0\r\n"      the line break shows transfers that mend line ends
//! u32       version            1
//! u64       length             of the whole file, bytes
//! sections  4 bytes tag, u64 length, as many bytes; each tag once, in any order
//! u32       CRC-32             of everything before it (IEEE 802.3)
//! ```
//!
//! A reader skips tags that it does not know; whatever changes the meaning of a known one is a new
//! version.

use super::{dxf, fabric_toml, pattern_file, settings_toml};
use crate::Error;
use crate::garment::Garment;
use crate::geometry::Vector3;
use crate::pattern::{Fabric, Pattern};
use crate::prepositioning::Settings;

/// A fitted garment, to be gone on from.
#[derive(Clone, Debug)]
pub struct State {
    /// Of the program that wrote the file.
    pub toile_version: String,
    pub pattern_name: String,
    /// The pattern as a file of text, such as [`pattern_file::stored`] makes.
    pub pattern_text: String,
    /// Hexadecimal, of the pattern file.
    pub pattern_sha256: String,
    pub body_name: String,
    /// Hexadecimal, of the body file.
    pub body_sha256: String,
    pub fabric: Fabric,
    pub settings: Settings,
    /// One per particle of the finest level, m, world; finite.
    pub positions: Vec<Vector3>,
    /// How far each panel was moved before its seams closed, m; finite.
    pub shifts: Vec<Vector3>,
    /// Particles of the waist line that the garment hangs from; none if it hangs from elsewhere, and of states that were
    /// written before this was recorded.
    pub waist: Vec<u32>,
}

const MAGIC: &[u8; 8] = b"TOILE\0\r\n";
const VERSION: u32 = 1;
/// Magic, version and length.
const HEADER_BYTES: usize = 8 + 4 + 8;
const CHECKSUM_BYTES: usize = 4;

/// The bytes of the file.
pub fn write(state: &State) -> Vec<u8> {
    let State {
        toile_version,
        pattern_name,
        pattern_text,
        pattern_sha256,
        body_name,
        body_sha256,
        fabric,
        settings,
        positions,
        shifts,
        waist,
    } = state;
    let (fabric, settings) = (fabric_toml::write(fabric), settings_toml::write(settings));
    let (positions, shifts) = (vector_bytes(positions), vector_bytes(shifts));
    let waist: Vec<u8> = waist.iter().flat_map(|p| p.to_le_bytes()).collect();
    let sections: [(&[u8; 4], &[u8]); 11] = [
        (b"VERS", toile_version.as_bytes()),
        (b"NAME", pattern_name.as_bytes()),
        (b"PATT", pattern_text.as_bytes()),
        (b"PSHA", pattern_sha256.as_bytes()),
        (b"BODY", body_name.as_bytes()),
        (b"BSHA", body_sha256.as_bytes()),
        (b"FABR", fabric.as_bytes()),
        (b"SETT", settings.as_bytes()),
        (b"POSI", &positions),
        (b"SHIF", &shifts),
        (b"WAIS", &waist),
    ];
    let length = HEADER_BYTES + sections.iter().map(|(_, bytes)| 12 + bytes.len()).sum::<usize>() + CHECKSUM_BYTES;
    let mut file = Vec::with_capacity(length);
    file.extend(MAGIC);
    file.extend(VERSION.to_le_bytes());
    file.extend((length as u64).to_le_bytes());
    for (tag, bytes) in sections {
        file.extend(tag);
        file.extend((bytes.len() as u64).to_le_bytes());
        file.extend(bytes);
    }
    file.extend(crc32fast::hash(&file).to_le_bytes());
    file
}

/// Reads a state from the bytes of a file, whatever they are.
pub fn read(bytes: &[u8]) -> Result<State, Error> {
    let sections = Sections::of(checked(bytes)?)?;
    let fabric = fabric_toml::parse(&sections.text(b"FABR")?, "unnamed").map_err(|e| e.within("fabric"))?;
    let mut settings = Settings::default();
    settings_toml::apply(&sections.text(b"SETT")?, &mut settings).map_err(|e| e.within("settings"))?;
    Ok(State {
        toile_version: sections.text(b"VERS")?,
        pattern_name: sections.text(b"NAME")?,
        pattern_text: sections.text(b"PATT")?,
        pattern_sha256: sections.text(b"PSHA")?,
        body_name: sections.text(b"BODY")?,
        body_sha256: sections.text(b"BSHA")?,
        fabric,
        settings,
        positions: sections.vectors(b"POSI")?,
        shifts: sections.vectors(b"SHIF")?,
        waist: sections.particles(b"WAIS")?,
    })
}

impl State {
    /// The pattern and the garment that the positions belong to, built again.
    pub fn rebuild(&self) -> Result<(Pattern, Garment), Error> {
        let text = self.pattern_text.as_bytes();
        let (pattern, _) = pattern_file::open(text, &self.pattern_name, &dxf::Options::default())?;
        let garment = Garment::build(&pattern, &self.settings.resolutions)?;
        let particles = garment.levels.last().map_or(0, |level| level.particle_count);
        if (particles, pattern.panels.len()) != (self.positions.len(), self.shifts.len()) {
            return Err(Error::new(
                format!(
                    "The state has {} particles, but its pattern now has {particles}; toile {} wrote it.",
                    self.positions.len(),
                    self.toile_version
                ),
                "Fit the garment again with this version.",
            ));
        }
        if let Some(beyond) = self.waist.iter().find(|&&p| p as usize >= particles) {
            return Err(damaged(format!("Particle {beyond} of the waist line is none of {particles}.")));
        }
        Ok((pattern, garment))
    }
}

fn damaged(problem: impl Into<String>) -> Error {
    Error::new(problem, "The file is damaged; copy it again, or fit the garment again.")
}

/// The sections of a file whose header and checksum are right.
fn checked(bytes: &[u8]) -> Result<&[u8], Error> {
    if bytes.is_empty() || !bytes.starts_with(&MAGIC[..bytes.len().min(MAGIC.len())]) {
        return Err(Error::new(
            "It is not a state of toile.",
            "Give the file `state.toile` that `toile fit` wrote, or its folder.",
        ));
    }
    if bytes.len() < HEADER_BYTES + CHECKSUM_BYTES {
        return Err(damaged(format!("The file ends after {} bytes, within its header.", bytes.len())));
    }
    let mut header = Reader(&bytes[MAGIC.len()..]);
    let version = u32::from_le_bytes(header.array()?);
    if version != VERSION {
        return Err(Error::new(
            format!("The state has version {version}; this toile reads version {VERSION}."),
            if version > VERSION { "Use a newer toile, or fit the garment again." } else { "Fit the garment again." },
        ));
    }
    let length = u64::from_le_bytes(header.array()?);
    if length != bytes.len() as u64 {
        return Err(damaged(format!("The file has {} bytes instead of {length}.", bytes.len())));
    }
    let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM_BYTES);
    if crc32fast::hash(content).to_le_bytes() != checksum {
        return Err(damaged("The checksum of the file is wrong."));
    }
    Ok(&content[HEADER_BYTES..])
}

/// What is left to be read.
struct Reader<'b>(&'b [u8]);

impl<'b> Reader<'b> {
    fn take(&mut self, count: u64) -> Result<&'b [u8], Error> {
        let count = usize::try_from(count).ok().filter(|&count| count <= self.0.len());
        let Some(count) = count else {
            return Err(damaged("A section reaches beyond the end of the file."));
        };
        let (taken, left) = self.0.split_at(count);
        self.0 = left;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N as u64)?);
        Ok(array)
    }
}

/// Sections by their tags.
struct Sections<'b>(Vec<([u8; 4], &'b [u8])>);

/// More sections than any version has; a file with more was made to waste time.
const MOST_SECTIONS: usize = 100;

impl<'b> Sections<'b> {
    fn of(content: &'b [u8]) -> Result<Self, Error> {
        let mut reader = Reader(content);
        let mut sections: Vec<([u8; 4], &[u8])> = Vec::new();
        while !reader.0.is_empty() {
            let tag = reader.array()?;
            let length = u64::from_le_bytes(reader.array()?);
            if sections.len() == MOST_SECTIONS || sections.iter().any(|(other, _)| *other == tag) {
                return Err(damaged(format!("The section {} is there twice.", tag.escape_ascii())));
            }
            sections.push((tag, reader.take(length)?));
        }
        Ok(Self(sections))
    }

    fn bytes(&self, tag: &[u8; 4]) -> Result<&'b [u8], Error> {
        let found = self.0.iter().find(|(other, _)| other == tag).map(|(_, bytes)| *bytes);
        found.ok_or_else(|| damaged(format!("The section {} is missing.", tag.escape_ascii())))
    }

    fn text(&self, tag: &[u8; 4]) -> Result<String, Error> {
        let text = str::from_utf8(self.bytes(tag)?);
        text.map(str::to_owned).map_err(|_| damaged(format!("The section {} is not UTF-8.", tag.escape_ascii())))
    }

    /// Numbers of particles; none if the section is not there.
    fn particles(&self, tag: &[u8; 4]) -> Result<Vec<u32>, Error> {
        let Ok(bytes) = self.bytes(tag) else { return Ok(Vec::new()) };
        let (numbers, rest) = bytes.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(damaged(format!("The section {} ends within a number.", tag.escape_ascii())));
        }
        Ok(numbers.iter().map(|number| u32::from_le_bytes(*number)).collect())
    }

    fn vectors(&self, tag: &[u8; 4]) -> Result<Vec<Vector3>, Error> {
        let bytes = self.bytes(tag)?;
        let (vectors, rest) = bytes.as_chunks::<24>();
        if !rest.is_empty() {
            return Err(damaged(format!("The section {} ends within a vector.", tag.escape_ascii())));
        }
        let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
        let vectors: Vec<Vector3> =
            vectors.iter().map(|v| Vector3::new(number(&v[..8]), number(&v[8..16]), number(&v[16..]))).collect();
        if vectors.iter().flatten().any(|x| !x.is_finite()) {
            return Err(damaged(format!("The section {} has a number that is not finite.", tag.escape_ascii())));
        }
        Ok(vectors)
    }
}

fn vector_bytes(vectors: &[Vector3]) -> Vec<u8> {
    vectors.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::read::sha256_hex;
    use crate::io::sample::{TWO_PANELS, two_panels};
    use proptest::prelude::*;

    fn state() -> State {
        let (_, garment, positions) = two_panels();
        let resolutions = garment.levels.iter().map(|level| level.resolution).collect();
        State {
            toile_version: "0.1.0".into(),
            pattern_name: "two panels".into(),
            pattern_text: TWO_PANELS.into(),
            pattern_sha256: sha256_hex(TWO_PANELS.as_bytes()),
            body_name: "ball".into(),
            body_sha256: sha256_hex(b"ball"),
            fabric: Fabric::default(),
            settings: Settings { resolutions, ..Settings::default() },
            positions,
            shifts: vec![Vector3::zeros(), Vector3::new(0.1, -0.0, 1.0 / 3.0)],
            waist: vec![2, 0, 3],
        }
    }

    /// The file with its last bytes made to fit the rest, as whoever forges one would.
    fn with_checksum(mut file: Vec<u8>) -> Vec<u8> {
        let content = file.len().saturating_sub(CHECKSUM_BYTES);
        let sum = crc32fast::hash(&file[..content]);
        file.truncate(content);
        file.extend(sum.to_le_bytes());
        file
    }

    fn problem(file: &[u8]) -> String {
        read(file).unwrap_err().problem().to_owned()
    }

    #[test]
    fn a_garment_is_built_again_from_its_state() {
        let (pattern, garment, _) = two_panels();
        let (pattern_again, garment_again) = read(&write(&state())).unwrap().rebuild().unwrap();
        assert_eq!(pattern, pattern_again);
        assert_eq!(garment.levels[1].rest, garment_again.levels[1].rest);
        let mut other = state();
        other.positions.pop();
        assert!(other.rebuild().unwrap_err().problem().contains("particles"));
        let beyond = State { waist: vec![1, 1_000_000], ..state() };
        assert!(beyond.rebuild().unwrap_err().problem().contains("waist line"));
    }

    #[test]
    fn a_state_without_a_waist_line_is_one_that_holds_none() {
        // As toile wrote it before waist lines were recorded: without the last section.
        let with = write(&state());
        let without = with.len() - CHECKSUM_BYTES - (12 + 4 * state().waist.len());
        let mut older = with[..without].to_vec();
        older.extend([0; CHECKSUM_BYTES]);
        let length = (older.len() as u64).to_le_bytes();
        older[12..20].copy_from_slice(&length);
        let read = read(&with_checksum(older)).unwrap();
        assert_eq!((read.waist, read.positions), (Vec::new(), state().positions));
    }

    #[test]
    fn errors_tell_what_is_wrong_with_the_file() {
        let file = write(&state());
        assert!(problem(b"").contains("not a state"));
        assert!(problem(b"o front\nv 0 0 0").contains("not a state"));
        assert!(problem(&file[..15]).contains("header"));
        assert!(problem(&file[..file.len() - 7]).contains("bytes instead of"));
        let mut newer = file.clone();
        newer[8] = 9;
        assert!(problem(&newer).contains("version 9"));
        let mut flipped = file.clone();
        flipped[100] ^= 1;
        assert!(problem(&flipped).contains("checksum"));
        // A length beyond the end, with a checksum that fits.
        let mut forged = file.clone();
        forged[HEADER_BYTES + 4..HEADER_BYTES + 12].fill(0xff);
        assert!(problem(&with_checksum(forged)).contains("beyond the end"));
        let mut renamed = file.clone();
        renamed[HEADER_BYTES..HEADER_BYTES + 4].copy_from_slice(b"ABCD");
        assert!(problem(&with_checksum(renamed.clone())).contains("VERS is missing"));
        renamed[HEADER_BYTES..HEADER_BYTES + 4].copy_from_slice(b"POSI");
        assert!(problem(&with_checksum(renamed)).contains("twice"));
    }

    #[test]
    fn positions_that_are_not_finite_are_refused() {
        let mut state = state();
        state.positions[5].y = f64::NAN;
        assert!(problem(&write(&state)).contains("not finite"));
    }

    proptest! {
        #[test]
        fn states_read_back_the_same(
            texts in proptest::collection::vec("\\PC*", 6),
            numbers in proptest::collection::vec([-1e9..1e9f64, -1.0..1.0f64, -1e-9..1e-9f64], 0..50),
        ) {
            let vectors: Vec<Vector3> = numbers.into_iter().map(Vector3::from).collect();
            let state = State {
                toile_version: texts[0].clone(),
                pattern_name: texts[1].clone(),
                pattern_text: texts[2].clone(),
                pattern_sha256: texts[3].clone(),
                body_name: texts[4].clone(),
                body_sha256: texts[5].clone(),
                shifts: vectors.clone(),
                positions: vectors,
                ..state()
            };
            let read = read(&write(&state)).unwrap();
            prop_assert_eq!(format!("{read:?}"), format!("{state:?}"));
        }

        #[test]
        fn damage_is_found(changes in proptest::collection::vec((any::<prop::sample::Index>(), 1u8..), 1..4)) {
            let file = write(&state());
            let mut damaged = file.clone();
            for (at, change) in changes {
                damaged[at.index(file.len())] ^= change;
            }
            prop_assume!(damaged != file);
            prop_assert!(read(&damaged).is_err());
        }

        #[test]
        fn a_shortened_file_is_refused(length in any::<prop::sample::Index>()) {
            let file = write(&state());
            prop_assert!(read(&file[..length.index(file.len())]).is_err());
        }

        #[test]
        fn a_forged_file_is_read_or_refused(
            changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        ) {
            let mut forged = write(&state());
            for (at, value) in changes {
                let at = at.index(forged.len());
                forged[at] = value;
            }
            let _ = read(&with_checksum(forged));
        }
    }
}
