//! A stretch of an outline in words: `front:3`, `front:2+3`, `front:3 from notch 1 to end`, `front:corner 2 to notch 0`.
//!
//! ```text
//! stretch := PANEL ":" ( edges [ "from" place ] [ "to" place ] | mark "to" mark )
//! edges   := N | N "+" N ... | N ".." N        consecutive, in the order of the outline; `..` may pass the last
//! mark    := "corner" N | "notch" N
//! place   := mark | "start" | "end" | P "%" | LENGTH      along the first edge (from) or the last (to), from its start
//! ```
//!
//! Edges, corners and notches are counted from 0 in the order of the file; corner N is where edge N starts.

use super::length;
use super::toml_keys::remedy_for_key;
use crate::pattern::Pattern;
use crate::pattern::sewing::Stretch;
use crate::{Code, Error};

const FORM: &str = "Write \"PANEL:3\", \"PANEL:2+3\", \"PANEL:3 from notch 1 to end\" or \"PANEL:corner 2 to notch 0\"; `toile seams show` draws the numbers.";

/// A place on an outline: a segment and a fraction of its arc length.
type Place = (usize, f64);

/// Reads a stretch of one of the pattern's panels.
pub fn parse(text: &str, pattern: &Pattern) -> Result<Stretch, Error> {
    let Some((panel, run)) = split(text, pattern) else {
        return Err(Error::new(format!("\"{}\" names no panel and edge.", cut(text)), FORM));
    };
    let Some(index) = pattern.panels.iter().position(|p| p.name == panel) else {
        let names: Vec<&str> = pattern.panels.iter().map(|p| p.name.as_str()).collect();
        let error = Error::new(format!("The pattern has no panel \"{}\".", cut(panel)), remedy_for_key(panel, &names));
        return Err(error.coded(Code::SeamUnknownEdge));
    };
    let outline = Outline { pattern, index };
    let words: Vec<String> = run.to_lowercase().replace('%', " % ").split_whitespace().map(str::to_owned).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    outline.stretch(&words).map_err(|e| e.within(format!("\"{}\"", cut(text))))
}

/// Panel and run; names of panels may hold colons themselves.
fn split<'t>(text: &'t str, pattern: &Pattern) -> Option<(&'t str, &'t str)> {
    let known = |name: &str| pattern.panels.iter().any(|panel| panel.name == name);
    let parts = || text.match_indices(':').map(|(at, _)| (text[..at].trim(), text[at + 1..].trim()));
    parts().find(|(name, _)| known(name)).or_else(|| parts().next_back())
}

fn cut(text: &str) -> String {
    text.chars().take(60).collect()
}

struct Outline<'p> {
    pattern: &'p Pattern,
    index: usize,
}

impl Outline<'_> {
    fn count(&self) -> usize {
        self.pattern.panels[self.index].segments.len()
    }

    fn stretch(&self, words: &[&str]) -> Result<Stretch, Error> {
        let at = |word: &str| words.iter().position(|w| *w == word);
        if matches!(words.first(), Some(&("corner" | "notch"))) {
            let to = at("to").ok_or_else(|| Error::new("It has a start and no end.", FORM))?;
            let (from, to) = (self.mark(&words[..to])?, self.mark(&words[to + 1..])?);
            return Ok(self.between(from, to));
        }
        let (from, to) = (at("from"), at("to"));
        let edges = &words[..from.or(to).unwrap_or(words.len())];
        let segments = self.edges(&edges.concat())?;
        let (first, last) = (segments[0], segments[segments.len() - 1]);
        let from = match from {
            Some(at) => self.place(&words[at + 1..to.filter(|&t| t > at).unwrap_or(words.len())], first)?,
            None => (first, 0.0),
        };
        let to = match to {
            Some(at) => self.place(&words[at + 1..], last)?,
            None => (last, 1.0),
        };
        self.trimmed(segments, from, to)
    }

    /// `segments` without what is before `from` and after `to`.
    fn trimmed(&self, segments: Vec<usize>, from: Place, to: Place) -> Result<Stretch, Error> {
        let on = |(segment, fraction): Place, last: bool| {
            let found = segments.iter().position(|&s| s == segment);
            // The corner where the last edge ends is also where the next one starts.
            let before = (segment + self.count() - 1) % self.count();
            let at_end = (fraction == 0.0 && last).then(|| segments.iter().rposition(|&s| s == before)).flatten();
            match (at_end, found) {
                (Some(k), _) => Ok((k, 1.0)),
                (None, Some(k)) => Ok((k, fraction)),
                (None, None) => Err(Error::new(
                    "It starts or ends at a place that is not on its edges.",
                    "Name the edge that the notch or corner lies on; `toile seams show` draws the numbers.",
                )),
            }
        };
        let ((i, from), (j, to)) = (on(from, false)?, on(to, true)?);
        if i > j || (i == j && from >= to) {
            return Err(Error::new(
                "It ends before it starts.",
                "Places follow one another in the order in which the edges are numbered; swap the two.",
            ));
        }
        Ok(Stretch { panel: self.index, segments: segments[i..=j].to_vec(), from, to })
    }

    /// Along the outline from one place to the other, all around if they are one.
    fn between(&self, (first, from): Place, (mut last, mut to): Place) -> Stretch {
        let count = self.count();
        if to == 0.0 {
            (last, to) = ((last + count - 1) % count, 1.0);
        }
        let steps = (last + count - first) % count;
        // Within one segment backwards is all around.
        let steps = if steps == 0 && to <= from { count } else { steps };
        Stretch { panel: self.index, segments: (0..=steps).map(|k| (first + k) % count).collect(), from, to }
    }

    fn edges(&self, text: &str) -> Result<Vec<usize>, Error> {
        let count = self.count();
        let edge = |word: &str| self.number(word, "edge", count);
        if let Some((a, b)) = text.split_once("..") {
            let (a, b) = (edge(a)?, edge(b)?);
            return Ok((0..=(b + count - a) % count).map(|k| (a + k) % count).collect());
        }
        let segments: Vec<usize> = text.split('+').map(edge).collect::<Result<_, _>>()?;
        match segments.windows(2).find(|w| w[1] != (w[0] + 1) % count) {
            Some(w) => Err(Error::new(
                format!("Edge {} does not follow edge {} on the outline.", w[1], w[0]),
                "List the edges of a run in the order in which they are numbered; give pieces that lie apart as a list of their own, [\"PANEL:2\", \"PANEL:5\"].",
            )),
            None => Ok(segments),
        }
    }

    fn number(&self, word: &str, what: &str, count: usize) -> Result<usize, Error> {
        let panel = &self.pattern.panels[self.index].name;
        let Ok(number) = word.parse::<usize>() else {
            return Err(Error::new(format!("\"{}\" is not the number of {}.", cut(word), article(what)), FORM));
        };
        if number < count {
            return Ok(number);
        }
        let has =
            if count == 0 { format!("has no {what}") } else { format!("has {count}, counted from 0 to {}", count - 1) };
        Err(Error::new(
            format!("It names {what} {number} of panel \"{panel}\", which does not exist."),
            format!("The panel {has}; `toile seams show` draws the numbers."),
        )
        .coded(Code::SeamUnknownEdge))
    }

    fn mark(&self, words: &[&str]) -> Result<Place, Error> {
        match words {
            ["corner", number] => Ok((self.number(number, "corner", self.count())?, 0.0)),
            ["notch", number] => {
                let notches = &self.pattern.panels[self.index].markings.notches;
                let notch = notches[self.number(number, "notch", notches.len())?];
                Ok((notch.segment, notch.fraction))
            }
            _ => Err(Error::new(format!("\"{}\" is neither a corner nor a notch.", cut(&words.join(" "))), FORM)),
        }
    }

    /// A place; lengths and shares are along `edge`.
    fn place(&self, words: &[&str], edge: usize) -> Result<Place, Error> {
        let length = || self.pattern.panels[self.index].segments[edge].curve.length();
        match words {
            ["start"] => Ok((edge, 0.0)),
            ["end"] => Ok((edge, 1.0)),
            ["corner" | "notch", ..] => self.mark(words),
            [number, "%"] => match number.parse::<f64>() {
                Ok(share) if (0.0..=100.0).contains(&share) => Ok((edge, share / 100.0)),
                _ => Err(Error::new(format!("\"{} %\" is no part of an edge.", cut(number)), "Give 0 % to 100 %.")),
            },
            [] => Err(Error::new("A place is missing.", FORM)),
            _ => {
                let metres = length::parse_or_zero(&words.join(" "))?;
                if metres > length() {
                    return Err(Error::new(
                        format!("Edge {edge} is only {:.1} mm long.", 1e3 * length()),
                        "Give a length along the edge, from where it starts.",
                    ));
                }
                Ok((edge, metres / length()))
            }
        }
    }
}

fn article(what: &str) -> String {
    format!("{} {what}", if what.starts_with('e') { "an" } else { "a" })
}

/// A stretch as [`parse`] reads it.
pub fn write(stretch: &Stretch, pattern: &Pattern) -> String {
    let panel = &pattern.panels[stretch.panel];
    let (first, last) = (stretch.segments[0], stretch.segments[stretch.segments.len() - 1]);
    let edges = match stretch.segments.as_slice() {
        [one] => format!("{one}"),
        [a, b] => format!("{a}+{b}"),
        _ => format!("{first}..{last}"),
    };
    let place = |segment: usize, fraction: f64| {
        let here = |n: &crate::pattern::Notch| n.segment == segment && (n.fraction - fraction).abs() < 1e-9;
        match panel.markings.notches.iter().position(here) {
            Some(notch) => format!("notch {notch}"),
            None => format!("{} %", 100.0 * fraction),
        }
    };
    let from = if stretch.from > 0.0 { format!(" from {}", place(first, stretch.from)) } else { String::new() };
    let to = if stretch.to < 1.0 { format!(" to {}", place(last, stretch.to)) } else { String::new() };
    format!("{}:{edges}{from}{to}", panel.name)
}
