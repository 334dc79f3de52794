//! What the cloth of each panel runs into: collision levels (Nylen et al. 2020, section 5).
//!
//! What cannot be seen need not be kept apart: a lining, a pocket bag, the layers of a hem. Nor can a sleeve that was
//! drawn into the torso be kept out of it. A panel has one of four levels, each with all of the one before:
//!
//! ```text
//!     none      passes through the body and through all cloth
//!     body      keeps clear of the body
//!     others    and of other panels, as far as these keep clear of it
//!     all       and of itself
//! ```
//!
//! Two panels keep clear of each other if both are to. Where panels are sewn together the particles of the seam are of
//! both, and go by the higher level.

use crate::contact::{Meets, SelfContact, SelfContactSettings};
use crate::garment::Level;

/// How much the cloth of a panel runs into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Collide {
    Nothing,
    /// The body.
    Body,
    /// The body and other panels.
    Others,
    #[default]
    All,
}

impl Collide {
    pub const ALL: [(&'static str, Collide); 4] =
        [("none", Collide::Nothing), ("body", Collide::Body), ("others", Collide::Others), ("all", Collide::All)];

    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, one)| *one == self).expect("all have a name").0
    }
}

/// The level of each panel, in the order of a garment's; of panels beyond the last it is [`Collide::All`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Collisions(pub Vec<Collide>);

impl Collisions {
    pub fn of(&self, panel: usize) -> Collide {
        self.0.get(panel).copied().unwrap_or_default()
    }

    /// Do two panels, or a panel and itself, keep clear of each other?
    pub fn meet(&self, one: usize, other: usize) -> bool {
        self.of(one).min(self.of(other)) >= if one == other { Collide::All } else { Collide::Others }
    }

    /// Is all as if there were no levels?
    pub fn is_default(&self) -> bool {
        self.0.iter().all(|level| *level == Collide::All)
    }

    /// Which particles pass through the body: those of no panel that keeps clear of it. Empty if there are none.
    pub fn free_of_body(&self, level: &Level) -> Vec<bool> {
        if !self.0.contains(&Collide::Nothing) {
            return Vec::new();
        }
        let mut free = vec![true; level.particle_count];
        let held = level.panels.iter().enumerate().filter(|(panel, _)| self.of(*panel) != Collide::Nothing);
        for (_, range) in held {
            level.particle_of[range.points.clone()].iter().for_each(|&p| free[p as usize] = false);
        }
        free
    }

    /// Contact of cloth with cloth by these levels.
    pub fn of_cloth(&self, level: &Level, class_of: Vec<u32>, settings: SelfContactSettings) -> SelfContact {
        let meets = |panel| match self.of(panel) {
            Collide::Nothing | Collide::Body => Meets::Nothing,
            Collide::Others => Meets::OtherPanels,
            Collide::All => Meets::All,
        };
        SelfContact::by_panel(level, class_of, settings, meets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::shapes;

    #[test]
    fn seams_go_by_the_higher_level() {
        let level = Garment::build(&shapes::two_rectangles(0.2, 0.3), &[0.05]).unwrap().levels.remove(0);
        let of = |panel: usize| level.particle_of[level.panels[panel].points.clone()].to_vec();
        let (front, back) = (of(0), of(1));
        assert!(front.iter().any(|p| back.contains(p)), "they are sewn together");
        let free = Collisions(vec![Collide::Nothing, Collide::Body]).free_of_body(&level);
        for p in 0..level.particle_count as u32 {
            assert_eq!(free[p as usize], !back.contains(&p));
        }
        assert!(Collisions(vec![Collide::Body; 2]).free_of_body(&level).is_empty());
    }

    #[test]
    fn two_panels_keep_clear_if_both_are_to() {
        let collisions = Collisions(vec![Collide::All, Collide::Others, Collide::Body]);
        assert!(collisions.meet(0, 0) && collisions.meet(0, 1) && collisions.meet(1, 0));
        assert!(!collisions.meet(1, 1) && !collisions.meet(0, 2) && !collisions.meet(2, 2));
        // Of what is not told, all.
        assert!(collisions.meet(3, 0) && collisions.meet(3, 3) && Collisions::default().meet(0, 1));
    }
}
