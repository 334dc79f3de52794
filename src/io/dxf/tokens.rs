//! The text of a DXF file as entities: groups of a code and a value, cut at every code 0.

use crate::Error;
use crate::geometry::Vector2;

/// A number beyond this is damage; it is a kilometre in micrometres.
const LARGEST_NUMBER: f64 = 1e9;

/// An entity or a structure word (`SECTION`, `BLOCK`, ...) with what stands under it.
#[derive(Debug)]
pub struct Entity<'t> {
    pub kind: &'t str,
    groups: Vec<(i32, &'t str, usize)>,
}

/// Cuts a text into entities. A comment (999) may stand anywhere.
pub fn entities(text: &str) -> Result<Vec<Entity<'_>>, Error> {
    let mut lines = text.lines().enumerate().map(|(k, line)| (k + 1, line));
    let mut entities: Vec<Entity> = Vec::new();
    while let Some((number, code)) = lines.next() {
        let Some((value_line, value)) = lines.next() else {
            // Blank lines may follow the last word.
            if code.trim().is_empty() || code.trim() == "\u{1a}" {
                break;
            }
            return Err(cut_short(number));
        };
        if code.trim().is_empty() && value.trim().is_empty() {
            continue;
        }
        let code: i32 = code.trim().parse().map_err(|_| {
            let shown: String = code.trim().chars().take(30).collect();
            Error::new(
                format!("\"{shown}\" stands where the number of a group should be."),
                "The file is damaged, or not DXF: in it lines with a code and lines with a value take turns. Export it again.",
            )
            .within(format!("line {number}"))
        })?;
        let value = value.trim();
        match code {
            0 => entities.push(Entity { kind: value, groups: Vec::new() }),
            999 => {}
            code => match entities.last_mut() {
                Some(entity) => entity.groups.push((code, value, value_line)),
                None => {
                    return Err(Error::new(
                        format!("The file starts with group {code}."),
                        "A DXF file starts with a group 0 and the word SECTION; export it again.",
                    )
                    .within(format!("line {number}")));
                }
            },
        }
    }
    Ok(entities)
}

fn cut_short(line: usize) -> Error {
    Error::new("The file ends in the middle of a group.", "It is cut short: copy or export it again.")
        .within(format!("line {line}"))
}

impl<'t> Entity<'t> {
    /// The value of the first group with a code.
    pub fn text(&self, code: i32) -> Option<&'t str> {
        self.groups.iter().find(|(c, ..)| *c == code).map(|&(_, value, _)| value)
    }

    /// Layers are numbers that are written as names.
    pub fn layer(&self) -> &'t str {
        self.text(8).unwrap_or("0")
    }

    /// The number of the first group with a code, if there is one.
    pub fn number(&self, code: i32) -> Result<Option<f64>, Error> {
        let found = self.groups.iter().find(|(c, ..)| *c == code);
        found.map(|&(_, value, line)| number(value, line)).transpose()
    }

    /// The point of groups such as 10 and 20, or 11 and 21.
    pub fn point(&self, code_of_x: i32) -> Result<Option<Vector2>, Error> {
        match (self.number(code_of_x)?, self.number(code_of_x + 10)?) {
            (Some(x), Some(y)) => Ok(Some(Vector2::new(x, y))),
            _ => Ok(None),
        }
    }

    /// The bits of group 70. Some programs write them as `1.000000`.
    pub fn flags(&self) -> u32 {
        self.number(70).ok().flatten().filter(|f| (0.0..65536.0).contains(f)).map_or(0, |f| f as u32)
    }

    /// The vertices of an LWPOLYLINE with their bulges: one for each group 10.
    pub fn light_vertices(&self) -> Result<Vec<(Vector2, f64)>, Error> {
        let mut vertices: Vec<(Vector2, f64)> = Vec::new();
        for &(code, value, line) in &self.groups {
            match (code, vertices.last_mut()) {
                (10, _) => vertices.push((Vector2::new(number(value, line)?, 0.0), 0.0)),
                (20, Some(last)) => last.0.y = number(value, line)?,
                (42, Some(last)) => last.1 = number(value, line)?,
                _ => {}
            }
        }
        Ok(vertices)
    }
}

/// A number with a point or a comma before its decimals.
fn number(value: &str, line: usize) -> Result<f64, Error> {
    let parsed = value.parse().or_else(|_| value.replace(',', ".").parse());
    match parsed {
        Ok(number) if f64::abs(number) <= LARGEST_NUMBER => Ok(number),
        _ => {
            let shown: String = value.chars().take(30).collect();
            let error = Error::new(
                format!("\"{shown}\" is not a number that a drawing can have."),
                "Export the file again; coordinates are plain decimal numbers.",
            );
            Err(error.within(format!("line {line}")))
        }
    }
}

/// Bytes as text: UTF-8 or, as older programs write, Latin-1. Of Windows' own characters between 0x80 and 0x9f only
/// their number is kept; they occur in names alone.
pub fn decode(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_read_with_all_liberties_of_their_writers() {
        let text = "999\r\nby a program\r\n  0\r\nLINE\r\n  8\r\n7\r\n 10\r\n1,5\r\n 20\r\n-2.50E1\r\n 70\r\n1.000000\r\n  0\r\nEOF\r\n\r\n";
        let entities = entities(text).unwrap();
        assert_eq!(entities.len(), 2);
        let line = &entities[0];
        assert_eq!((line.kind, line.layer(), line.flags()), ("LINE", "7", 1));
        assert_eq!(line.point(10).unwrap(), Some(Vector2::new(1.5, -25.0)));
        assert_eq!(line.point(11).unwrap(), None);
    }

    #[test]
    fn what_is_wrong_names_its_line() {
        for (text, place) in [("0\nSECTION\nHEADER\n2", "line 3"), ("0\nLINE\n10", "line 3"), ("10\n5\n", "line 1")] {
            assert_eq!(entities(text).unwrap_err().place(), place, "{text}");
        }
        for bad in ["x", "nan", "inf", "1e99", "1,2,3"] {
            let text = format!("0\nLINE\n10\n{bad}\n20\n0\n");
            assert_eq!(entities(&text).unwrap()[0].point(10).unwrap_err().place(), "line 4", "{bad}");
        }
    }

    #[test]
    fn old_encodings_are_read() {
        assert_eq!(decode(b"\xef\xbb\xbfR\xc3\xbcckenteil"), "Rückenteil");
        assert_eq!(decode(b"R\xfcckenteil"), "Rückenteil");
    }
}
