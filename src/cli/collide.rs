//! `--collide PANEL=LEVEL`: what single panels do not run into.

use super::Failure;
use super::simulate::{Fitted, named};
use crate::Error;
use crate::dynamics::{Collide, Collisions};
use serde_json::{Value, json};

/// Of each panel of all garments its name; of several garments also that of the garment before it, as in `tee/sleeve`.
fn names(fitted: &[Fitted]) -> Vec<[String; 2]> {
    let of = |f: &Fitted| {
        f.pattern.panels.iter().map(|p| [p.name.clone(), format!("{}/{}", f.pattern.name, p.name)]).collect::<Vec<_>>()
    };
    fitted.iter().flat_map(of).collect()
}

/// The levels that `asked` gives, one per panel.
pub fn levels(asked: &[String], fitted: &[Fitted]) -> Result<Collisions, Failure> {
    let names = names(fitted);
    let usage = |e: Error| Failure::Usage(e.within("--collide"));
    let mut levels = if asked.is_empty() { Vec::new() } else { vec![Collide::All; names.len()] };
    for text in asked {
        let (pattern, level) = text.rsplit_once('=').ok_or_else(|| {
            let problem = format!("\"{text}\" names no level.");
            usage(Error::new(problem, "Give a panel and a level, such as \"pocket*=none\"."))
        })?;
        let level = named("collision level", level.trim(), &Collide::ALL).map_err(usage)?;
        let pattern = pattern.trim();
        let mut found = false;
        for (own, names) in levels.iter_mut().zip(&names) {
            if names.iter().any(|name| fits(pattern, name)) {
                (*own, found) = (level, true);
            }
        }
        if !found {
            return Err(usage(unknown(pattern, &names)));
        }
    }
    Ok(Collisions(levels))
}

/// Panels that do not run into everything, as the report and the checkpoint have them: names and levels.
pub fn told(fitted: &[Fitted], collisions: &Collisions) -> Value {
    let level = |(k, [name, long]): (usize, &[String; 2])| {
        let level = collisions.of(k);
        let name = if fitted.len() > 1 { long } else { name };
        (level != Collide::All).then(|| json!([name, level.name()]))
    };
    names(fitted).iter().enumerate().filter_map(level).collect()
}

/// How many near names a message tells.
const NEAR_NAMES: usize = 3;

fn unknown(pattern: &str, names: &[[String; 2]]) -> Error {
    let wanted = pattern.replace('*', "");
    let mut near: Vec<&str> = names.iter().map(|[name, _]| name.as_str()).collect();
    near.sort_by(|a, b| strsim::jaro(b, &wanted).total_cmp(&strsim::jaro(a, &wanted)).then(a.cmp(b)));
    near.dedup();
    near.truncate(NEAR_NAMES);
    let near = near.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    Error::new(
        format!("No panel is named \"{pattern}\"."),
        format!("Panels with like names are {near}. A * stands for anything, such as \"*=body\"."),
    )
}

/// Is it that name, where each `*` stands for any letters or none?
fn fits(pattern: &str, name: &str) -> bool {
    let Some((start, rest)) = pattern.split_once('*') else { return pattern == name };
    let (between, end) = rest.rsplit_once('*').unwrap_or(("", rest));
    let Some(mut left) = name.strip_prefix(start).and_then(|name| name.strip_suffix(end)) else { return false };
    // Each as early as it can be: what follows has the most room then.
    between.split('*').all(|piece| match left.split_once(piece) {
        _ if piece.is_empty() => true,
        Some((_, after)) => {
            left = after;
            true
        }
        None => false,
    })
}

#[cfg(test)]
mod tests {
    use super::fits;

    #[test]
    fn a_star_stands_for_anything() {
        for (pattern, name) in [
            ("front", "front"),
            ("*", "front"),
            ("*", ""),
            ("f*", "front"),
            ("*nt", "front"),
            ("f*o*t", "front"),
            ("*ö*", "göre"),
        ] {
            assert!(fits(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [("front", "front_l"), ("f*x", "front"), ("", "front"), ("*front*", "back")] {
            assert!(!fits(pattern, name), "{pattern} {name}");
        }
    }
}
