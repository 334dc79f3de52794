//! What the name of a panel says: which part of the body it dresses, at which side.
//!
//! Names are hints, never needed: what they leave open the seams tell, and where they all are silent (`panel_0`, `panel_1`)
//! nothing is lost but the certainty of what is front and what is left.

use crate::pattern::{BodyPart, Panel};

/// The part of the body that a panel dresses, as its name tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Zone {
    Torso,
    Arm,
    Leg,
    /// Around both legs or the hips.
    Skirt,
    Waistband,
    Neck,
    Head,
}

/// What a name says of a panel; none where it is silent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hints {
    pub zone: Option<Zone>,
    /// 1 at the front, -1 at the back.
    pub front: Option<f64>,
    /// 1 at the body's left (+x), -1 at its right.
    pub left: Option<f64>,
}

/// Words of names, in the languages in which patterns are sold most, without accents. Earlier zones win: a "pant cuff" is of the
/// leg, a "neck facing front bodice" of the neck.
const ZONES: [(Zone, &[&str]); 7] = [
    (
        Zone::Leg,
        &[
            "pant",
            "pants",
            "trouser",
            "trousers",
            "leg",
            "legs",
            "jean",
            "jeans",
            "shorts",
            "hose",
            "hosenbein",
            "pantalon",
        ],
    ),
    (Zone::Head, &["hood", "kapuze", "capuche"]),
    (Zone::Neck, &["collar", "neck", "neckband", "lapel", "kragen", "col", "turtle"]),
    (
        Zone::Arm,
        // A cuff alone may be that of a leg: what it is sewn to tells.
        &["sleeve", "sleeves", "sl", "slv", "arm", "armel", "aermel", "manche", "manica", "raglan"],
    ),
    (Zone::Waistband, &["wb", "waistband", "bund", "ceinture", "belt"]),
    (Zone::Skirt, &["skirt", "rock", "jupe", "godet", "gore", "insert", "ruffle"]),
    (Zone::Torso, &["torso", "bodice", "body", "yoke", "bust", "chest", "shirt", "top", "vest", "corsage", "leib"]),
];
const FRONT: &[&str] = &["front", "f", "fr", "fwd", "vorderteil", "vorne", "devant", "davanti", "delantero"];
const BACK: &[&str] = &["back", "b", "bk", "rear", "ruckenteil", "rueckenteil", "hinten", "dos", "dietro", "espalda"];
const LEFT: &[&str] = &["left", "l", "lt", "lft", "links", "gauche"];
const RIGHT: &[&str] = &["right", "r", "rt", "rgt", "rechts", "droite"];
/// Prefixes that are written together with the part: `ftorso`, `backskirt`.
const FACES: [(&str, f64); 4] = [("front", 1.0), ("back", -1.0), ("f", 1.0), ("b", -1.0)];

impl Hints {
    pub fn of(panel: &Panel) -> Self {
        let mut hints = Self::of_name(&panel.name);
        // A label is coarser than a name: a sleeve's cuff is "arm", a collar "body".
        hints.zone = hints.zone.or(match panel.part {
            Some(BodyPart::Arm) => Some(Zone::Arm),
            Some(BodyPart::Body) => Some(Zone::Torso),
            Some(BodyPart::Leg) | None => None,
        });
        hints
    }

    pub fn of_name(name: &str) -> Self {
        let words = words(name);
        let mut hints = Self::default();
        let mut zone_rank = ZONES.len();
        for word in &words {
            let is = |list: &[&str]| list.contains(&word.as_str());
            let sign = |plus: &[&str], minus: &[&str]| match (is(plus), is(minus)) {
                (true, _) => Some(1.0),
                (_, true) => Some(-1.0),
                _ => None,
            };
            hints.front = hints.front.or(sign(FRONT, BACK));
            hints.left = hints.left.or(sign(LEFT, RIGHT));
            let mut rank = ZONES.iter().position(|(_, list)| is(list));
            if rank.is_none() {
                for (prefix, front) in FACES {
                    let rest = word.strip_prefix(prefix).filter(|rest| rest.len() > 2);
                    let of_rest = rest.and_then(|rest| ZONES.iter().position(|(_, list)| list.contains(&rest)));
                    if of_rest.is_some() && rank.is_none() {
                        rank = of_rest;
                        hints.front = hints.front.or(Some(front));
                    }
                }
            }
            zone_rank = zone_rank.min(rank.unwrap_or(ZONES.len()));
        }
        hints.zone = ZONES.get(zone_rank).map(|(zone, _)| *zone);
        hints
    }
}

/// The words of a name, in small letters and without accents: parted at all that is no letter and at capitals in the middle.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in name.chars().take(MOST_LETTERS) {
        if !c.is_alphabetic() || (c.is_uppercase() && before.is_lowercase()) {
            words.push(String::new());
        }
        if c.is_alphabetic() {
            let plain = match c.to_lowercase().next().unwrap_or(c) {
                'ä' | 'à' | 'á' | 'â' => 'a',
                'ö' | 'ó' | 'ô' => 'o',
                'ü' | 'ú' | 'û' => 'u',
                'é' | 'è' | 'ê' => 'e',
                other => other,
            };
            words.last_mut().expect("there is always a word").push(plain);
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// A name is read so far.
const MOST_LETTERS: usize = 200;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_many_spellings_say_where_a_panel_belongs() {
        let (front, back) = (Some(1.0), Some(-1.0));
        let (left, right) = (Some(1.0), Some(-1.0));
        for (name, zone, face, side) in [
            ("left_ftorso", Some(Zone::Torso), front, left),
            ("right_btorso", Some(Zone::Torso), back, right),
            ("sl_right_cuff_b", Some(Zone::Arm), back, right),
            ("pant_f_l", Some(Zone::Leg), front, left),
            ("PantCuff-R", Some(Zone::Leg), None, right),
            ("cuff (mirrored)", None, None, None),
            ("wb_back", Some(Zone::Waistband), back, None),
            ("skirt_front", Some(Zone::Skirt), front, None),
            ("Front Bodice 2", Some(Zone::Torso), front, None),
            ("FRONT", None, front, None),
            ("teagan.back", None, back, None),
            ("Ärmel links", Some(Zone::Arm), None, left),
            ("right_collar_back", Some(Zone::Neck), back, right),
            ("left_hood", Some(Zone::Head), None, left),
            ("panel_0", None, None, None),
            ("", None, None, None),
        ] {
            assert_eq!(Hints::of_name(name), Hints { zone, front: face, left: side }, "{name}");
        }
    }
}
