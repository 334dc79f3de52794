//! Arrangement files: where single panels are to start, in the place of what is found by itself. TOML, see `docs/formats.md`.

use super::length;
use super::toml_keys::{line_of, quoted, remedy_for_key};
use crate::Error;
use crate::arrangement::placing::{Limb, Override, Report};
use crate::pattern::Pattern;
use std::fmt::Write as _;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

const KEYS: [&str; 7] = ["part", "height", "aside", "angle", "turn", "distance", "bend"];
const PARTS: [Limb; 6] = [Limb::Torso, Limb::Head, Limb::Arm(0), Limb::Arm(1), Limb::Leg(0), Limb::Leg(1)];
/// The largest angle that is read, degrees; beyond it is a slip.
const MOST_DEGREES: f64 = 360.0;
/// Nothing is farther from a body than this, m, nor bent around less or more.
const FARTHEST: f64 = 5.0;
const RADII: std::ops::RangeInclusive<f64> = 0.01..=5.0;

/// What the file asks of each panel of the pattern, in the pattern's order.
pub fn parse(text: &str, pattern: &Pattern) -> Result<Vec<Option<Override>>, Error> {
    let text = text.trim_start_matches('\u{feff}');
    let table = DeTable::parse(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start);
        Error::new(
            format!("It is not TOML: {}.", error.message().trim_end_matches('.').replace('\n', ", ")),
            "Write `[panel.\"NAME\"]` and below it one `key = value` a line.",
        )
        .within(line_of(text, start))
    })?;
    let mut overrides = vec![None; pattern.panels.len()];
    let names: Vec<&str> = pattern.panels.iter().map(|panel| panel.name.as_str()).collect();
    for (key, value) in in_order(table.get_ref()) {
        let at = || line_of(text, key.span().start);
        if key.get_ref() != "panel" {
            let problem = format!("The key `{}` is not known.", key.get_ref().chars().take(60).collect::<String>());
            return Err(Error::new(problem, "Write `[panel.\"NAME\"]` for each panel.").within(at()));
        }
        let Some(panels) = value.get_ref().as_table() else {
            return Err(Error::new("`panel` is no table.", "Write `[panel.\"NAME\"]` for each panel.").within(at()));
        };
        for (name, value) in in_order(panels) {
            let at = || line_of(text, name.span().start);
            let Some(panel) = names.iter().position(|known| known == name.get_ref()) else {
                let problem = format!("The pattern has no panel {}.", quoted(name.get_ref()));
                return Err(Error::new(problem, remedy_for_key(name.get_ref(), &names)).within(at()));
            };
            let Some(keys) = value.get_ref().as_table() else {
                let remedy = "Write `[panel.\"NAME\"]` and below it one `key = value` a line.";
                return Err(Error::new(format!("{} is no table.", quoted(name.get_ref())), remedy).within(at()));
            };
            overrides[panel] =
                Some(panel_override(text, keys).map_err(|e| e.within(format!("panel \"{}\"", names[panel])))?);
        }
    }
    Ok(overrides)
}

type Entry<'a, 't> = (&'a Spanned<std::borrow::Cow<'t, str>>, &'a Spanned<DeValue<'t>>);

/// The entries as they stand in the file, so that the first slip is the one that is told.
fn in_order<'a, 't>(table: &'a DeTable<'t>) -> Vec<Entry<'a, 't>> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    entries
}

fn panel_override(text: &str, keys: &DeTable) -> Result<Override, Error> {
    let mut asked = Override::default();
    for (key, value) in in_order(keys) {
        let name = key.get_ref().as_ref();
        let slip = |problem: &str, remedy: &str| Error::new(format!("`{name}` {problem}."), remedy);
        let words = || value.get_ref().as_str().ok_or_else(|| slip("is not text", "Put the value in double quotes."));
        let degrees = || {
            let number = match value.get_ref() {
                DeValue::Float(float) => float.as_str().replace('_', "").parse::<f64>().ok(),
                DeValue::Integer(integer) => integer.as_str().replace('_', "").parse::<f64>().ok(),
                _ => None,
            };
            let sensible = number.filter(|n| n.abs() <= MOST_DEGREES);
            sensible
                .map(f64::to_radians)
                .ok_or_else(|| slip("is no angle", "Give degrees from -360 to 360, without quotes."))
        };
        let metres = || words().and_then(signed);
        let set = |asked: &mut Override| -> Result<(), Error> {
            match name {
                "part" => asked.limb = Some(part(words()?)?),
                "height" => asked.height = Some(metres()?),
                "aside" => asked.aside = Some(metres()?),
                "angle" => asked.angle = Some(degrees()?),
                "turn" => asked.turn = Some(degrees()?),
                "distance" => asked.distance = Some(metres()?),
                "bend" if words()? == "flat" => asked.bend = Some(f64::INFINITY),
                "bend" => {
                    let radius = length::parse(words()?)?;
                    if !RADII.contains(&radius) {
                        return Err(slip("is no radius", "Give one from 10 mm to 5 m, or \"flat\"."));
                    }
                    asked.bend = Some(radius);
                }
                _ => {
                    let known: String = name.chars().take(60).collect();
                    return Err(Error::new(format!("The key `{known}` is not known."), remedy_for_key(name, &KEYS)));
                }
            }
            Ok(())
        };
        set(&mut asked).map_err(|e| e.within(line_of(text, key.span().start)))?;
    }
    Ok(asked)
}

fn part(word: &str) -> Result<Limb, Error> {
    let known = PARTS.map(Limb::name);
    PARTS
        .into_iter()
        .find(|limb| limb.name() == word)
        .ok_or_else(|| Error::new(format!("The part {} is not known.", quoted(word)), remedy_for_key(word, &known)))
}

/// A length with its unit and its sign, m.
fn signed(text: &str) -> Result<f64, Error> {
    let (sign, rest) = match text.trim().strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text),
    };
    let metres = length::parse_or_zero(rest)?;
    if metres > FARTHEST {
        return Err(Error::new(format!("{} is too far.", quoted(text)), "Give at most 5 m."));
    }
    Ok(sign * metres)
}

/// A file that asks for nothing yet: what was found, as comments to take away and numbers to change.
pub fn write(pattern: &Pattern, report: &Report) -> String {
    let mut text = String::from(
        "# Where the panels start. What begins with # was found by itself: take the # away and change the value to ask for\n\
         # something else. Angles are degrees; docs/formats.md explains all keys.\n",
    );
    for placed in &report.panels {
        let stands = &placed.stands;
        let _ = write!(
            text,
            "\n[panel.{}]\n# part = \"{}\"\n",
            quoted(&pattern.panels[placed.panel].name),
            placed.limb.name()
        );
        let mut length = |key: &str, metres: Option<f64>| {
            if let Some(metres) = metres {
                let _ = writeln!(text, "# {key} = \"{:.3} m\"", metres + 0.0);
            }
        };
        length("height", stands.height);
        length("aside", stands.aside);
        length("distance", stands.distance);
        for (key, angle) in [("angle", stands.angle), ("turn", stands.turn)] {
            let degrees = (angle.unwrap_or(0.0).to_degrees() * 10.0).round() / 10.0;
            let _ = writeln!(text, "# {key} = {:?}", degrees + 0.0);
        }
        match stands.bend {
            Some(radius) => _ = writeln!(text, "# bend = \"{radius:.3} m\""),
            None => text.push_str("# bend = \"flat\"\n"),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::shapes;

    fn pattern() -> Pattern {
        let mut pattern = shapes::two_rectangles(0.2, 0.3);
        pattern.panels[0].name = "left_sleeve".into();
        pattern.panels[1].name = "front \"2\"".into();
        pattern
    }

    #[test]
    fn the_example_of_the_documentation_reads() {
        let example =
            include_str!("../../docs/formats.md").split("```").filter_map(|b| b.strip_prefix("toml\n")).nth(2).unwrap();
        let read = parse(example, &pattern()).unwrap();
        let asked = read[0].unwrap();
        assert_eq!((asked.limb, asked.bend, asked.turn), (Some(Limb::Arm(0)), Some(0.08), Some(0.0)));
        assert!((asked.angle.unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-15 && read[1].is_none());
    }

    #[test]
    fn slips_are_told_with_their_line_and_what_would_be_right() {
        for (text, place, hint) in [
            ("[panel.\"left_sleve\"]", "line 1", "left_sleeve"),
            ("\n[panels.front]", "line 2", "[panel."),
            ("panel = 3", "line 1", "[panel."),
            ("[panel]\nleft_sleeve = 2", "line 2", "key = value"),
            ("[panel.left_sleeve]\nhight = \"1 m\"", "panel \"left_sleeve\", line 2", "height"),
            ("[panel.left_sleeve]\nheight = 1", "panel \"left_sleeve\", line 2", "quotes"),
            ("[panel.left_sleeve]\nheight = \"900 m\"", "panel \"left_sleeve\", line 2", "5 m"),
            ("[panel.left_sleeve]\nangle = \"90\"", "panel \"left_sleeve\", line 2", "without quotes"),
            ("[panel.left_sleeve]\nangle = 900", "panel \"left_sleeve\", line 2", "360"),
            ("[panel.left_sleeve]\npart = \"left armm\"", "panel \"left_sleeve\", line 2", "left arm"),
            ("[panel.left_sleeve]\nbend = \"1 mm\"", "panel \"left_sleeve\", line 2", "flat"),
            ("[panel.left_sleeve", "line 1", "[panel."),
        ] {
            let error = parse(text, &pattern()).unwrap_err();
            assert_eq!(error.place(), place, "{text}: {error}");
            assert!(error.remedy().contains(hint), "{text}: {}", error.remedy());
        }
    }

    #[test]
    fn lengths_have_signs_and_a_bend_may_be_flat() {
        let text = "[panel.\"front \\\"2\\\"\"]\naside = \"-12 cm\"\nbend = \"flat\"\nheight = \"0 m\"";
        let asked = parse(text, &pattern()).unwrap()[1].unwrap();
        assert_eq!((asked.aside, asked.bend, asked.height), (Some(-0.12), Some(f64::INFINITY), Some(0.0)));
    }
}
