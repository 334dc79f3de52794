//! One door for all patterns: what kind of file it is, is told by what is in it, not by its name.

use super::dxf::Options;
use super::{dxf, freesewing, garmentcode, toile_pattern};
use crate::pattern::Pattern;
use crate::{Code, Error, Warning};
use serde::Deserialize;
use serde::de::IgnoredAny;

/// The largest pattern file that is read, bytes; graded styles have a few megabytes.
const MOST_BYTES: usize = 64 << 20;

/// The kinds of pattern files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    GarmentCode,
    Dxf,
    FreeSewingDump,
    FreeSewingSvg,
    ToileJson,
    ToileToml,
}

/// Reads a pattern of any kind. `name` is what the garment is called if the file does not say. What comes out of a drawing
/// has neither seams nor places; see [`Pattern`].
pub fn open(bytes: &[u8], name: &str, options: &Options) -> Result<(Pattern, Vec<Warning>), Error> {
    let (pattern, warnings) = read(bytes, name, options).map_err(|e| e.coded(Code::PatternUnreadable))?;
    Ok((pattern, warnings.into_iter().map(|w| w.coded(Code::LeftAside)).collect()))
}

/// Per seam of a pattern file: does it state its ease? Empty where none does; only patterns of toile can.
pub fn stated_ease(bytes: &[u8]) -> Vec<bool> {
    match (recognize(bytes), text(bytes)) {
        (Ok(Format::ToileJson), Ok(text)) => toile_pattern::stated_ease_json(text),
        (Ok(Format::ToileToml), Ok(text)) => toile_pattern::stated_ease_toml(text),
        _ => Vec::new(),
    }
}

fn read(bytes: &[u8], name: &str, options: &Options) -> Result<(Pattern, Vec<Warning>), Error> {
    let format = recognize(bytes)?;
    let (pattern, mut warnings) = match format {
        Format::Dxf => dxf::parse(bytes, name, options)?,
        Format::GarmentCode => garmentcode::parse(text(bytes)?, name)?,
        Format::FreeSewingDump => freesewing::parse_dump(text(bytes)?, name)?,
        Format::FreeSewingSvg => freesewing::parse_svg(text(bytes)?, name)?,
        Format::ToileJson => toile_pattern::parse_json(text(bytes)?, name)?,
        Format::ToileToml => toile_pattern::parse_toml(text(bytes)?, name)?,
    };
    if format != Format::Dxf && *options != Options::default() {
        let given = if options.unit.is_some() { "--unit" } else { "--size" };
        warnings.push(Warning(Error::new(
            format!("{given} is left aside: only DXF files leave unit and size open."),
            "Leave the option out.",
        )));
    }
    Ok((pattern, warnings))
}

/// The pattern as a text that [`open`] turns into the same pattern, to the last bit.
pub fn stored(pattern: &Pattern) -> String {
    toile_pattern::write_json(pattern)
}

/// What kind of pattern the bytes are, by what they start with.
pub fn recognize(bytes: &[u8]) -> Result<Format, Error> {
    if bytes.len() > MOST_BYTES {
        return Err(Error::new(
            format!("The file has more than {} MiB.", MOST_BYTES >> 20),
            "Check that it is the right file: patterns are smaller.",
        ));
    }
    if let Some((what, remedy)) = foreign(bytes) {
        return Err(Error::new(format!("It is {what}."), remedy));
    }
    let content = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let start = content.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(content.len());
    let content = &content[start..];
    match content.first() {
        None => Err(Error::new("The file is empty.", "Export the pattern again.")),
        Some(b'{') => Ok(json(content)),
        Some(b'<') => xml(content),
        Some(_) if starts_as_dxf(content) => Ok(Format::Dxf),
        // A table of TOML is one line or many of `key = value`.
        Some(_) if content.contains(&b'=') && str::from_utf8(content).is_ok() => Ok(Format::ToileToml),
        Some(_) => Err(Error::new(
            "It is none of the pattern files that are known.",
            "Give GarmentCode JSON, DXF (AAMA or ASTM), FreeSewing JSON or SVG, or a pattern of toile.",
        )),
    }
}

/// What other programs write, and how to get at the pattern all the same.
fn foreign(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    const EXPORT: &str = "Export the pattern as DXF-AAMA or ASTM.";
    let starts = |magic: &[u8]| bytes.starts_with(magic);
    match () {
        () if starts(b"AutoCAD Binary DXF") => Some(("a binary DXF file", "Save it as ASCII DXF.")),
        () if starts(b"AC10") && bytes.get(4..6).is_some_and(|d| d.iter().all(u8::is_ascii_digit)) => {
            Some(("a DWG drawing", "Export the pattern as ASCII DXF, AAMA or ASTM."))
        }
        () if starts(b"PK\x03\x04") => Some(("a packed archive, such as CLO and Marvelous Designer write", EXPORT)),
        () if starts(b"%PDF") => Some(("a PDF file", "Export the pattern as DXF or, from FreeSewing, as SVG.")),
        () if starts(b"\xff\xfe") || starts(b"\xfe\xff") => Some(("text in UTF-16", "Save it as UTF-8.")),
        () if starts(b"TOILE\0") => Some(("a state of toile", "Give the pattern that was fitted.")),
        () if bytes.iter().take(4096).any(|&b| b == 0) => Some(("not text", EXPORT)),
        () => None,
    }
}

/// The members of JSON patterns that tell their kind.
#[derive(Deserialize)]
struct Probe {
    #[serde(default)]
    format: Option<String>,
    #[serde(default)]
    parts: Option<IgnoredAny>,
    #[serde(default)]
    panels: Option<IgnoredAny>,
}

/// GarmentCode has no mark of its own: what is nothing else, and what is damaged, is read as such.
fn json(content: &[u8]) -> Format {
    let probe = serde_json::from_slice::<Probe>(content);
    match probe {
        Ok(Probe { format: Some(format), .. }) if format.starts_with(freesewing::DUMP_FORMAT) => Format::FreeSewingDump,
        Ok(Probe { format: Some(format), .. }) if format == toile_pattern::FORMAT => Format::ToileJson,
        Ok(Probe { parts: Some(_), panels: None, .. }) => Format::FreeSewingDump,
        Ok(Probe { panels: Some(_), parts: None, .. }) => Format::ToileJson,
        _ => Format::GarmentCode,
    }
}

fn xml(content: &[u8]) -> Result<Format, Error> {
    let head = String::from_utf8_lossy(&content[..content.len().min(4096)]);
    let has = |word: &str| head.contains(word);
    if has("<svg") {
        return Ok(Format::FreeSewingSvg);
    }
    if has("<pattern") || has("<vit") || has("<smis") {
        return Err(Error::new(
            "It is a file of Valentina or Seamly2D, which holds formulas and no outlines.",
            "Export its details from there as DXF-AAMA or ASTM.",
        ));
    }
    Err(Error::new("It is XML, but not SVG.", "Give an SVG of FreeSewing, or another kind of pattern."))
}

/// DXF starts with a group 0, perhaps after a comment.
fn starts_as_dxf(content: &[u8]) -> bool {
    let first = content.split(|&b| b == b'\n' || b == b'\r').next().unwrap_or_default();
    matches!(first.trim_ascii(), b"0" | b"999")
}

fn text(bytes: &[u8]) -> Result<&str, Error> {
    str::from_utf8(bytes).map_err(|e| {
        Error::new(
            format!("It is not UTF-8 text: the byte at offset {} does not fit.", e.valid_up_to()),
            "Save the file as UTF-8, or check that it is the right file.",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::embedded;

    #[test]
    fn kinds_are_told_by_their_content() {
        let known: [(&[u8], Format); 8] = [
            (embedded::TEE.as_bytes(), Format::GarmentCode),
            (b"\xef\xbb\xbf  {\"format\": \"freesewing-draft-dump/1\", \"parts\": []}", Format::FreeSewingDump),
            (b"{\"format\": \"toile pattern\", \"version\": 1, \"panels\": []}", Format::ToileJson),
            (b"{\"pattern\": {", Format::GarmentCode),
            (b"format = \"toile pattern\"\n", Format::ToileToml),
            (b"<?xml version=\"1.0\"?><svg/>", Format::FreeSewingSvg),
            (b"  0\r\nSECTION\r\n", Format::Dxf),
            (b"999\nR\xfcckenteil\n  0\nSECTION\n", Format::Dxf),
        ];
        for (bytes, format) in known {
            assert_eq!(recognize(bytes), Ok(format), "{}", String::from_utf8_lossy(&bytes[..bytes.len().min(40)]));
        }
    }

    #[test]
    fn what_cannot_be_read_is_named_with_a_way_out() {
        let cases: [(&[u8], &str); 9] = [
            (b"", "empty"),
            (b"PK\x03\x04....", "archive"),
            (b"%PDF-1.7", "PDF"),
            (b"AutoCAD Binary DXF\r\n\x1a\0", "binary DXF"),
            (b"AC1027....", "DWG"),
            (b"\xff\xfe0\0", "UTF-16"),
            (b"<?xml version=\"1.0\"?><pattern><draw/></pattern>", "Valentina"),
            (b"v 0 0 0\nv 1 0 0\n", "none of the pattern files"),
            (b"\0\0\0\0", "not text"),
        ];
        for (bytes, word) in cases {
            let error = recognize(bytes).unwrap_err();
            assert!(error.problem().contains(word) && error.remedy().len() > 10, "{error}");
        }
    }
}
