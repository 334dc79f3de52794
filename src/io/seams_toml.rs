//! Seams beside the pattern, in TOML: `NAME.seams.toml`, the format of `docs/formats.md`.

use super::length;
use super::stretch_text;
use super::toml_keys::{Keys, quoted, remedy_for_key};
use crate::pattern::sewing::{Ease, Resolved, SeamPlan, Stretch, resolve};
use crate::pattern::suggest::Suggestion;
use crate::pattern::{Pattern, Sense};
use crate::{Code, Error};

/// More seams or stretches than any garment has; a file with more is damaged.
const MOST_SEAMS: usize = 5_000;
const MOST_STRETCHES: usize = 30;

const KEYS: [&str; 7] = ["name", "sides", "direction", "right_wrong", "ease", "confidence", "reason"];

/// Reads the seams of a pattern. What is sewn to what is checked, lengths and directions are not.
pub fn parse(text: &str, pattern: &Pattern) -> Result<Vec<SeamPlan>, Error> {
    let keys = Keys::parse(text.trim_start_matches('\u{feff}'), &["seam", "pattern", "leave_out"])?;
    // Free text: which pattern the file was made for.
    keys.text("pattern")?;
    let out = left_out(&keys, pattern)?;
    let tables = keys.tables("seam", &KEYS)?;
    if tables.len() > MOST_SEAMS {
        return Err(Error::new(
            format!("The file has {} seams.", tables.len()),
            format!("A file of more than {MOST_SEAMS} seams is taken as damaged."),
        ));
    }
    let mut plans: Vec<SeamPlan> = Vec::with_capacity(tables.len());
    let mut faults = Vec::new();
    for (keys, line) in &tables {
        let plan = match read_seam(keys, line, pattern) {
            Ok(plan) => plan,
            Err(fault) => {
                faults.push(fault);
                continue;
            }
        };
        if let Some(other) = plans.iter().find(|other| other.name == plan.name) {
            faults.push(plan.complain(
                format!("The seam of {} has the same name.", other.place),
                "Give every seam a name of its own, or none.",
            ));
        }
        if let Some(stretch) = plan.sides.iter().flatten().find(|stretch| out[stretch.panel]) {
            let name = &pattern.panels[stretch.panel].name;
            return Err(plan.complain(
                format!("It sews panel \"{name}\", which is left out."),
                format!("Take \"{name}\" from `leave_out`, or delete the seam."),
            ));
        }
        plans.push(plan);
    }
    faults.extend(crate::pattern::sewing::check_overlaps(pattern, &plans).err());
    Error::all(faults).map_or(Ok(plans), |fault| Err(fault.coded(Code::SeamUnusable)))
}

/// Per panel: is it no part of what is sewn?
fn left_out(keys: &Keys, pattern: &Pattern) -> Result<Vec<bool>, Error> {
    let mut out = vec![false; pattern.panels.len()];
    for name in keys.lists("leave_out")?.unwrap_or_default().into_iter().flatten() {
        let Some(panel) = pattern.panels.iter().position(|panel| panel.name == name) else {
            let known: Vec<&str> = pattern.panels.iter().map(|panel| panel.name.as_str()).collect();
            let e = Error::new(format!("There is no panel \"{name}\" to leave out."), remedy_for_key(name, &known));
            return Err(e.within(keys.place("leave_out")));
        };
        out[panel] = true;
    }
    if out.iter().all(|&out| out) {
        let e = Error::new("All panels are left out.", "Keep those that are sewn: linings and bindings are left out.");
        return Err(e.within(keys.place("leave_out")));
    }
    Ok(out)
}

/// Sews a pattern by the text of its file of seams, instead of the seams it has. Panels that the file leaves out are gone.
pub fn sew(pattern: &Pattern, text: &str) -> Result<Resolved, Error> {
    let mut plans = parse(text, pattern)?;
    let keys = Keys::parse(text.trim_start_matches('\u{feff}'), &["seam", "pattern", "leave_out"])?;
    let out = left_out(&keys, pattern)?;
    if !out.contains(&true) {
        return resolve(pattern, &plans);
    }
    let mut kept = pattern.clone();
    let mut at = 0..;
    kept.panels.retain(|_| at.next().is_none_or(|panel: usize| !out[panel]));
    kept.seams.clear();
    for stretch in plans.iter_mut().flat_map(|plan| plan.sides.iter_mut().flatten()) {
        stretch.panel -= out[..stretch.panel].iter().filter(|&&out| out).count();
    }
    resolve(&kept, &plans)
}

fn read_seam(keys: &Keys, line: &str, pattern: &Pattern) -> Result<SeamPlan, Error> {
    let given = keys.text("name")?;
    let within = |key: &str, e: Error| match given {
        Some(name) => e.within(format!("seam \"{name}\"")).within(keys.place(key)),
        None => e.within(keys.place(key)),
    };
    let lists = keys.lists("sides")?.ok_or_else(|| {
        let e = Error::new("The seam has no `sides`.", "Add `sides = [\"front:3\", \"back:1\"]`.");
        let e = given.map_or(e.clone(), |name| e.within(format!("seam \"{name}\"")));
        e.within(line)
    })?;
    let [a, b] = lists.as_slice() else {
        let e = Error::new(
            format!("The seam has {} sides.", lists.len()),
            "A seam has two sides, each a text or a list of texts.",
        )
        .coded(Code::SeamWithoutPartner);
        return Err(within("sides", e));
    };
    let side = |texts: &Vec<&str>| -> Result<Vec<Stretch>, Error> {
        if texts.is_empty() || texts.len() > MOST_STRETCHES {
            let e = Error::new(format!("A side has {} pieces.", texts.len()), format!("Give 1 to {MOST_STRETCHES}."));
            return Err(within("sides", e));
        }
        texts.iter().map(|text| stretch_text::parse(text, pattern).map_err(|e| within("sides", e))).collect()
    };
    let sides = [side(a)?, side(b)?];
    let direction = match keys.text("direction")? {
        None => None,
        Some("opposed") => Some(Sense::Opposed),
        Some("aligned") => Some(Sense::Aligned),
        Some(other) => {
            let known = ["opposed", "aligned"];
            let e = Error::new(format!("The direction \"{other}\" is not known."), remedy_for_key(other, &known));
            return Err(within("direction", e));
        }
    };
    let ease = keys.text("ease")?.map(read_ease).transpose().map_err(|e| within("ease", e))?;
    // What a suggestion says of itself.
    keys.number("confidence")?;
    keys.text("reason")?;
    Ok(SeamPlan {
        name: given.map_or_else(|| name_of(&sides, pattern), str::to_owned),
        sides,
        direction,
        right_wrong: keys.truth("right_wrong")?.unwrap_or(false),
        ease,
        place: line.to_owned(),
    })
}

fn read_ease(text: &str) -> Result<Ease, Error> {
    let Some(number) = text.trim().strip_suffix('%') else { return Ok(Ease::Length(length::parse_or_zero(text)?)) };
    match number.trim().parse::<f64>() {
        Ok(share) if share.is_finite() && share >= 0.0 => Ok(Ease::Share(share / 100.0)),
        _ => Err(Error::new(format!("\"{text}\" is no ease."), "Write \"12 mm\" or \"5 %\".")),
    }
}

/// A seam without a name is called by its sides: `front:3 + back:1`.
pub fn name_of(sides: &[Vec<Stretch>; 2], pattern: &Pattern) -> String {
    let side =
        |side: &Vec<Stretch>| side.iter().map(|s| stretch_text::write(s, pattern)).collect::<Vec<_>>().join(" and ");
    format!("{} + {}", side(&sides[0]), side(&sides[1]))
}

/// The file of suggestions: the most certain first, each with its confidence and reason. [`parse`] reads it.
pub fn write_suggestions(suggestions: &[Suggestion], pattern: &Pattern) -> String {
    let mut text = format!(
        "# Seams proposed for {}: delete what is wrong, add what is missing. Edges are counted as `toile seams show`\n\
         # draws them; docs/formats.md explains the rest. Directions need not be given.\n\
         pattern = {}\n",
        pattern.name.replace(|c: char| c.is_control(), " "),
        quoted(&pattern.name)
    );
    for suggestion in suggestions {
        text += "\n[[seam]]\n";
        if suggestion.plan.name != name_of(&suggestion.plan.sides, pattern) {
            text += &format!("name = {}\n", quoted(&suggestion.plan.name));
        }
        text += &format!("sides = [{}]\n", suggestion.plan.sides.each_ref().map(|s| side_text(s, pattern)).join(", "));
        text += &format!("confidence = {:.2}\nreason = {}\n", suggestion.confidence, quoted(&suggestion.reason));
    }
    text
}

fn side_text(side: &[Stretch], pattern: &Pattern) -> String {
    let texts: Vec<String> = side.iter().map(|s| quoted(&stretch_text::write(s, pattern))).collect();
    if let [one] = texts.as_slice() { one.clone() } else { format!("[{}]", texts.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::shapes::two_rectangles;
    use proptest::prelude::*;

    #[test]
    fn every_form_of_a_stretch_is_read_and_reads_back() {
        let pattern = two_rectangles(0.2, 0.3);
        let read = |text: &str| stretch_text::parse(text, &pattern).unwrap();
        for (text, segments, from, to) in [
            ("left:3", vec![3], 0.0, 1.0),
            ("left: 3 + 0", vec![3, 0], 0.0, 1.0),
            ("left:2..0", vec![2, 3, 0], 0.0, 1.0),
            ("left:1 from 25 % to end", vec![1], 0.25, 1.0),
            ("left:0 to 5 cm", vec![0], 0.0, 0.25),
            ("left:1+2 from 6 cm to 50%", vec![1, 2], 0.2, 0.5),
            ("left:corner 1 to corner 3", vec![1, 2], 0.0, 1.0),
        ] {
            let stretch = read(text);
            assert_eq!(stretch.segments, segments, "{text}");
            assert!((stretch.from - from).abs() < 1e-12 && (stretch.to - to).abs() < 1e-12, "{text}");
            assert_eq!(read(&stretch_text::write(&stretch, &pattern)), stretch);
        }
        for text in [
            "left",
            "left:",
            "left:1 to 90 % from 10 cm x",
            "left:0 from 21 cm",
            "left:1 from 60 % to 50 %",
            "left:notch 0 to corner 1",
        ] {
            assert!(stretch_text::parse(text, &pattern).is_err(), "{text}");
        }
    }

    #[test]
    fn panels_that_are_left_out_are_gone() {
        let mut pattern = two_rectangles(0.2, 0.3);
        let mut strip = pattern.panels[0].clone();
        strip.name = "binding".to_owned();
        pattern.panels.insert(0, strip);
        let seam = "\n[[seam]]\nsides = [\"left:1\", \"right:3\"]";
        let sewn = sew(&pattern, &format!("leave_out = [\"binding\"]{seam}")).unwrap().pattern;
        let names: Vec<&str> = sewn.panels.iter().map(|panel| panel.name.as_str()).collect();
        assert_eq!(names, ["left", "right"]);
        assert_eq!(sewn.seams[0].sides.map(|side| side.panel), [0, 1]);
        for list in ["[\"bindin\"]", "[\"left\"]", "[\"left\", \"right\", \"binding\"]"] {
            assert!(sew(&pattern, &format!("leave_out = {list}{seam}")).is_err(), "{list}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "\\PC{0,60}", side in "(left|right|l):?[0-9+. a-z%]{0,20}") {
            let pattern = two_rectangles(0.2, 0.3);
            let _ = sew(&pattern, &text);
            let _ = sew(&pattern, &format!("[[seam]]\nsides = [{}, \"right:3\"]", quoted(&side)));
        }
    }
}
