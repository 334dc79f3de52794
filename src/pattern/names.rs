//! What the name of a panel tells: which part of the garment it is, on which side, and whether front or back.

/// Of the wearer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    Front,
    Back,
}

/// The parts of a garment that names speak of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Torso,
    Sleeve,
    Cuff,
    Skirt,
    Trouser,
    Waistband,
    Hood,
    Collar,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Role {
    pub side: Option<Side>,
    pub face: Option<Face>,
    pub part: Option<Part>,
}

/// Words within names; the first that is found counts, so that a sleeve's cuff is a cuff.
const PARTS: [(&str, Part); 26] = [
    ("cuff", Part::Cuff),
    ("waistband", Part::Waistband),
    ("belt", Part::Waistband),
    ("collar", Part::Collar),
    ("lapel", Part::Collar),
    ("hood", Part::Hood),
    ("sleeve", Part::Sleeve),
    ("slv", Part::Sleeve),
    ("skirt", Part::Skirt),
    ("trouser", Part::Trouser),
    ("pant", Part::Trouser),
    ("leg", Part::Trouser),
    ("torso", Part::Torso),
    ("bodice", Part::Torso),
    ("body", Part::Torso),
    ("yoke", Part::Torso),
    ("chest", Part::Torso),
    ("wb", Part::Waistband),
    ("ärmel", Part::Sleeve),
    ("manche", Part::Sleeve),
    ("rock", Part::Skirt),
    ("hose", Part::Trouser),
    ("kragen", Part::Collar),
    ("bund", Part::Waistband),
    ("jupe", Part::Skirt),
    ("top", Part::Torso),
];

/// Reads a name.
pub fn role(name: &str) -> Role {
    let lower = name.to_lowercase();
    let words: Vec<&str> = lower.split(|c: char| !c.is_alphabetic()).filter(|w| !w.is_empty()).collect();
    let has = |long: &str, short: &str| lower.contains(long) || words.contains(&short);
    let part = PARTS.iter().find(|(word, _)| lower.contains(word)).map(|(_, part)| *part);
    let front = has("front", "f") || lower.contains("ftorso");
    let back = has("back", "b") || lower.contains("btorso");
    let face = match (front, back) {
        (true, false) => Some(Face::Front),
        (_, true) => Some(Face::Back),
        _ => None,
    };
    let side = match (has("left", "l"), has("right", "r")) {
        (true, false) => Some(Side::Left),
        (false, true) => Some(Side::Right),
        _ => None,
    };
    Role { side, face, part }
}

/// How well two parts go together, from -3 (never sewn) to 1.
pub fn together(a: &Role, b: &Role) -> f64 {
    use Part::*;
    let parts = match (a.part, b.part) {
        (Some(a), Some(b)) if a == b => 0.8,
        (Some(a), Some(b)) => {
            let meets = |x: Part, y: Part| (a, b) == (x, y) || (a, b) == (y, x);
            let known = [
                (Torso, Sleeve),
                (Sleeve, Cuff),
                (Torso, Waistband),
                (Torso, Skirt),
                (Torso, Trouser),
                (Torso, Hood),
                (Torso, Collar),
                (Waistband, Skirt),
                (Waistband, Trouser),
                (Trouser, Cuff),
            ];
            if known.iter().any(|&(x, y)| meets(x, y)) { 1.0 } else { -2.5 }
        }
        _ => 0.0,
    };
    let sides = match (a.side, b.side) {
        (Some(a), Some(b)) if a != b => -0.2,
        (Some(_), Some(_)) => 0.5,
        _ => 0.0,
    };
    // Left and right of one part meet in the middle; of different parts they do not meet at all.
    let arm = matches!(a.part, Some(Sleeve | Cuff));
    let across = if sides < 0.0 && (a.part != b.part || arm) { -3.0 } else { 0.0 };
    // A front meets a back of its own part, and the fronts of other parts.
    let faces = match (a.face, b.face) {
        (Some(f), Some(g)) if f != g && a.part != b.part => -1.5,
        (Some(f), Some(g)) if f != g && sides < 0.0 => -2.0,
        (Some(_), Some(_)) => 0.5,
        _ => 0.0,
    };
    let sum: f64 = parts + sides + across + faces;
    sum.clamp(-4.0, 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_part_side_and_face() {
        let role_of = |part, side, face| Role { part: Some(part), side, face };
        assert_eq!(role("sl_left_cuff_f"), role_of(Part::Cuff, Some(Side::Left), Some(Face::Front)));
        assert_eq!(role("right_btorso"), role_of(Part::Torso, Some(Side::Right), Some(Face::Back)));
        assert_eq!(role("pant_b_l"), role_of(Part::Trouser, Some(Side::Left), Some(Face::Back)));
        assert_eq!(role("Teagan Sleeve").part, Some(Part::Sleeve));
    }
}
