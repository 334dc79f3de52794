//! Lengths as people write them: `5 mm`, `0.5 cm`, `0.005 m`, `40,20,10,5 mm`.
//!
//! A length without a unit is refused, because half of all pattern programs think in centimetres
//! and half in millimetres. Equal lengths in different units give the same bits.

use crate::Error;

/// The longest list that is read; no cascade has more levels.
const MOST_LENGTHS: usize = 32;
/// Lengths outside this range, m, are a slip of the unit: from a nanometre to ten kilometres.
const SENSIBLE: std::ops::RangeInclusive<f64> = 1e-9..=1e4;

/// Units by the power of ten that makes them metres.
const UNITS: [(&str, i32); 3] = [("mm", -3), ("cm", -2), ("m", 0)];
/// Units that are understood but not taken, m.
const FOREIGN_UNITS: [(&[&str], f64); 2] =
    [(&["in", "inch", "inches", "\"", "″", "”"], 0.0254), (&["ft", "foot", "feet", "'", "′", "’"], 0.3048)];

/// The unit in which a pattern file is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub enum Unit {
    #[serde(rename = "mm")]
    Millimetre,
    #[serde(rename = "cm")]
    Centimetre,
    #[serde(rename = "in")]
    Inch,
    #[serde(rename = "m")]
    Metre,
}

impl Unit {
    /// A unit by its usual sign.
    pub fn named(sign: &str) -> Result<Self, Error> {
        match sign.trim() {
            "mm" => Ok(Self::Millimetre),
            "cm" => Ok(Self::Centimetre),
            "in" | "inch" => Ok(Self::Inch),
            "m" => Ok(Self::Metre),
            other => Err(Error::new(format!("The unit {} is not known.", quoted(other)), "Give mm, cm, in or m.")),
        }
    }

    /// A number of the file in metres. A metre is exact.
    pub fn to_metres(self, number: f64) -> f64 {
        match self {
            Self::Millimetre => number / 1000.0,
            Self::Centimetre => number / 100.0,
            Self::Inch => number * 0.0254,
            Self::Metre => number,
        }
    }

    /// In words, for messages.
    pub fn plural(self) -> &'static str {
        match self {
            Self::Millimetre => "millimetres",
            Self::Centimetre => "centimetres",
            Self::Inch => "inches",
            Self::Metre => "metres",
        }
    }

    /// The usual sign.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Inch => "in",
            Self::Metre => "m",
        }
    }
}

/// A positive length with its unit, in metres.
pub fn parse(text: &str) -> Result<f64, Error> {
    positive(text, parse_or_zero(text)?)
}

/// A length with its unit that may be zero, in metres.
pub fn parse_or_zero(text: &str) -> Result<f64, Error> {
    let (number, unit) = split(text);
    if unit.is_empty() {
        return Err(without_unit(text, number));
    }
    in_metres(text, number, unit)
}

/// Lengths separated by commas, in metres. Those without a unit have that of the last.
pub fn parse_list(text: &str) -> Result<Vec<f64>, Error> {
    let parts: Vec<&str> = text.split(',').map(str::trim).take(MOST_LENGTHS + 1).collect();
    if parts.len() > MOST_LENGTHS {
        return Err(Error::new(
            format!("The list has more than {MOST_LENGTHS} lengths."),
            "Give a few, from coarse to fine, such as \"40,20,10,5 mm\".",
        ));
    }
    if parts.iter().any(|part| part.is_empty()) {
        return Err(Error::new(
            format!("{} has a place without a length.", quoted(text)),
            "Write lengths with one comma between them, such as \"40,20,10,5 mm\".",
        ));
    }
    let (last_number, last_unit) = split(parts.last().copied().unwrap_or_default());
    if last_unit.is_empty() {
        return Err(without_unit(text, last_number));
    }
    let one = |&part: &&str| {
        let (number, unit) = split(part);
        let unit = if unit.is_empty() { last_unit } else { unit };
        positive(part, in_metres(part, number, unit)?)
    };
    parts.iter().map(one).collect()
}

/// A length as it is best read in a message, such as `2.5 mm` or `1.2 m`.
pub fn describe(metres: f64) -> String {
    let (scale, unit) = match metres.abs() {
        m if m >= 1.0 => (1.0, "m"),
        m if m >= 0.1 => (1e2, "cm"),
        _ => (1e3, "mm"),
    };
    // Three decimals hide the last bits of the conversion and no length that matters.
    let rounded = (metres * scale * 1e3).round() / 1e3;
    format!("{rounded} {unit}")
}

/// The number and the unit of a length, each perhaps empty.
fn split(text: &str) -> (&str, &str) {
    let text = text.trim();
    let of_unit =
        |c: char| c.is_alphabetic() || FOREIGN_UNITS.iter().any(|(names, _)| names.iter().any(|n| n.starts_with(c)));
    let number = text.trim_end_matches(of_unit);
    (number.trim_end(), &text[number.len()..])
}

fn in_metres(text: &str, number: &str, unit: &str) -> Result<f64, Error> {
    if number.is_empty() {
        return Err(Error::new(format!("{} has no number.", quoted(text)), "Write a length such as \"5 mm\"."));
    }
    let value = shifted(number, 0).ok_or_else(|| {
        let remedy = match number.replace(',', ".") {
            point if number.contains(',') && point.parse::<f64>().is_ok() => format!("Write \"{point} {unit}\"."),
            _ => "Write a length such as \"5 mm\".".to_owned(),
        };
        Error::new(format!("{} is not a number.", quoted(number)), remedy)
    })?;
    let Some(&(_, power)) = UNITS.iter().find(|(name, _)| *name == unit) else {
        return Err(unknown_unit(value, unit));
    };
    let metres = shifted(number, power).unwrap_or(f64::NAN);
    if metres != 0.0 && !SENSIBLE.contains(&metres.abs()) {
        return Err(Error::new(
            format!("{} is no length of a garment.", quoted(text)),
            "Check the number and its unit.",
        ));
    }
    if metres < 0.0 {
        return Err(not_positive(text));
    }
    // A zero that was written with a minus is zero.
    Ok(metres.abs())
}

/// A decimal number times a power of ten, rounded once.
fn shifted(number: &str, power: i32) -> Option<f64> {
    let (mantissa, exponent) = match number.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (number, 0),
    };
    // `parse` would also take words such as "inf".
    if !mantissa.bytes().all(|b| b.is_ascii_digit() || b"+-.".contains(&b)) {
        return None;
    }
    format!("{mantissa}e{}", exponent.saturating_add(power)).parse().ok()
}

fn positive(text: &str, metres: f64) -> Result<f64, Error> {
    if metres > 0.0 { Ok(metres) } else { Err(not_positive(text)) }
}

fn not_positive(text: &str) -> Error {
    Error::new(format!("{} is not positive.", quoted(text)), "Write a positive length such as \"5 mm\".")
}

fn without_unit(text: &str, number: &str) -> Error {
    if shifted(number, 0).is_none() {
        return Error::new(format!("{} is not a length.", quoted(text)), "Write a length such as \"5 mm\".");
    }
    Error::new(format!("{} has no unit.", quoted(text)), format!("Write {}.", quoted(&format!("{} mm", text.trim()))))
}

fn unknown_unit(value: f64, unit: &str) -> Error {
    if let Some((_, metres)) = FOREIGN_UNITS.iter().find(|(names, _)| names.contains(&unit)) {
        return Error::new(
            format!("The unit {unit} is not taken."),
            format!("Write {}.", quoted(&format!("{:.4} mm", value * metres * 1e3).replace(".0000", ""))),
        );
    }
    Error::new(format!("The unit {} is not known.", quoted(unit)), "Write mm, cm or m, such as \"5 mm\".")
}

/// The text in quotes, cut where it is too long for a message.
fn quoted(text: &str) -> String {
    const MOST_CHARACTERS: usize = 40;
    let text = text.trim();
    match text.char_indices().nth(MOST_CHARACTERS) {
        Some((end, _)) => format!("\"{}…\"", &text[..end]),
        None => format!("\"{text}\""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lengths_are_read_in_all_units() {
        for text in ["5 mm", "5mm", " 5 mm ", "0.5 cm", "0.005 m", "0.005m", "5e-3 m", "+5. mm", "0.05e1 cm"] {
            assert_eq!(parse(text), Ok(0.005), "{text}");
        }
        assert_eq!(parse("0.1 mm").unwrap(), 1e-4);
    }

    #[test]
    fn lists_take_the_unit_of_their_last() {
        assert_eq!(parse_list("40,20,10,5 mm").unwrap(), [0.04, 0.02, 0.01, 0.005]);
        assert_eq!(parse_list("4 cm, 20 mm, 5 mm").unwrap(), [0.04, 0.02, 0.005]);
        assert_eq!(parse_list("4 cm, 20, 5 mm").unwrap(), [0.04, 0.02, 0.005]);
        assert_eq!(parse_list("5 mm").unwrap(), [0.005]);
    }

    #[test]
    fn a_length_without_a_unit_shows_the_right_form() {
        let error = parse("5").unwrap_err();
        assert_eq!((error.problem(), error.remedy()), ("\"5\" has no unit.", "Write \"5 mm\"."));
        let error = parse_list("40,20,10,5").unwrap_err();
        assert_eq!((error.problem(), error.remedy()), ("\"40,20,10,5\" has no unit.", "Write \"40,20,10,5 mm\"."));
    }

    #[test]
    fn inches_are_converted_in_the_remedy() {
        for text in ["2 inch", "2 in", "2\"", "2″"] {
            assert_eq!(parse(text).unwrap_err().remedy(), "Write \"50.8000 mm\".", "{text}");
        }
        assert!(parse("5 km").unwrap_err().problem().contains("km"));
    }

    #[test]
    fn what_is_no_length_is_refused() {
        for text in [
            "",
            " ",
            "mm",
            "0 mm",
            "-0 mm",
            "-5 mm",
            "nan mm",
            "inf m",
            "infinity",
            "NaN",
            "1e300 m",
            "1e-300 mm",
            "1e99999999999 m",
            "5 5 mm",
            "0x5 mm",
            "5,5 mm",
            "--5 mm",
            "e5 mm",
            "5e mm",
            "5 Mm",
            "5 µm",
            "٥ mm",
            "1/2 m",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
        for text in ["", ",", "5 mm,", "5,,4 mm", "40, 0, 5 mm", "40;20 mm", &"1,".repeat(1000)] {
            assert!(parse_list(text).is_err(), "{text}");
        }
        assert_eq!(parse("0,5 cm").unwrap_err().remedy(), "Write \"0.5 cm\".");
        assert_eq!(parse_or_zero("0 mm"), Ok(0.0));
        assert!(parse_or_zero("-1 mm").is_err());
    }

    #[test]
    fn lengths_are_described_as_people_say_them() {
        let described = [0.005, 0.0025, 0.3, 1.75, 0.0].map(describe);
        assert_eq!(described, ["5 mm", "2.5 mm", "30 cm", "1.75 m", "0 mm"]);
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "\\PC{0,30}") {
            let _ = (parse(&text), parse_list(&text), parse_or_zero(&text));
        }

        #[test]
        fn metres_read_back_the_same(metres in 1e-8..1e4f64) {
            prop_assert_eq!(parse(&format!("{metres} m")), Ok(metres));
        }
    }
}
