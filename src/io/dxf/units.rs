//! The unit of a drawing: no header of a pattern file can be believed, so the size of the pieces decides.

use crate::io::length::{Unit, describe};
use crate::{Error, Warning};

/// Pieces of a garment that are longer than this were drawn in millimetres.
const MILLIMETRES_ABOVE: f64 = 150.0;
/// Pieces of this length or longer, and not in millimetres, are in centimetres or inches.
const CENTIMETRES_ABOVE: f64 = 15.0;
/// Pieces of less than this length were drawn in metres.
const METRES_BELOW: f64 = 3.0;

/// The unit of pieces whose middle one is `extent` long, and how it was found. `said` is the text `Units:`.
pub fn guess(extent: f64, said: Option<&str>) -> (Unit, Warning) {
    let says = |word: &str| said.is_some_and(|s| s.to_ascii_uppercase().contains(word));
    let (metric, english) = (says("METRIC"), says("ENGLISH") || says("IMPERIAL"));
    let unit = match extent {
        e if e > MILLIMETRES_ABOVE => Unit::Millimetre,
        e if e >= CENTIMETRES_ABOVE => {
            if english {
                Unit::Inch
            } else {
                Unit::Centimetre
            }
        }
        e if e < METRES_BELOW && !english => Unit::Metre,
        _ => {
            if metric {
                Unit::Centimetre
            } else {
                Unit::Inch
            }
        }
    };
    let text = match said {
        Some(said) => format!("the file says {}", said.chars().take(20).collect::<String>()),
        None => "the file does not say".to_owned(),
    };
    let doubt = match unit {
        Unit::Inch if metric => ", which does not fit",
        Unit::Millimetre | Unit::Centimetre | Unit::Metre if english => ", which does not fit",
        _ => "",
    };
    let warning = Error::new(
        format!(
            "The unit is taken to be {}: {text}{doubt}, and the middle one of the panels is {extent:.1} long, which makes {}.",
            unit.plural(),
            describe((unit.to_metres(extent) * 1e3).round() / 1e3)
        ),
        "If that is wrong, give --unit mm, cm, in or m.",
    );
    // A unit that the file gives and that fits is no doubt, but worth a look: programs write wrong ones.
    let certain = doubt.is_empty() && said.is_some();
    (unit, Warning(if certain { warning } else { warning.coded(crate::Code::UnitDoubtful) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn garments_of_all_units_are_recognized() {
        let (metric, english) = (Some("METRIC"), Some("English"));
        for (extent, said, unit) in [
            (640.0, metric, Unit::Millimetre),
            (640.0, None, Unit::Millimetre),
            (640.0, english, Unit::Millimetre),
            (64.0, metric, Unit::Centimetre),
            (64.0, None, Unit::Centimetre),
            (24.5, english, Unit::Inch),
            (118.0, english, Unit::Inch),
            (9.0, english, Unit::Inch),
            (9.0, None, Unit::Inch),
            (9.0, metric, Unit::Centimetre),
            (0.64, metric, Unit::Metre),
            (0.64, None, Unit::Metre),
        ] {
            assert_eq!(guess(extent, said).0, unit, "{extent} {said:?}");
        }
        assert!(guess(640.0, english).1.0.problem().contains("does not fit"));
    }
}
