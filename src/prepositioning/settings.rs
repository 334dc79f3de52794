//! How a garment is pre-positioned.

use crate::Error;
use crate::contact::{SelfContact, SelfContactSettings};
use crate::energy::Model;
use crate::garment::{COARSEST_RESOLUTION, Level};
use crate::geometry::Vector3;
use crate::minimize::{Method, Settings as Steps};
use crate::pattern::Fabric;

/// When the finest level is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FinishLine {
    /// A simulator can take over: sewn, clear, with little strain; small forces are left.
    #[default]
    HandOff,
    /// The forces are in balance: rms residual at most [`Settings::equilibrium_residual`].
    Equilibrium,
}

/// How a garment is pre-positioned. Lengths in metres.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Of the levels, coarsest first.
    pub resolutions: Vec<f64>,
    /// Distance to be kept from the body by the middle of the cloth; [`resting_clearance`] is that of cloth on skin.
    pub clearance: f64,
    pub model: Model,
    /// For closing the seams and for all levels.
    pub minimizer: Method,
    pub until: FinishLine,
    /// Root mean square of the residual at which [`FinishLine::Equilibrium`] is reached, in particle
    /// weights.
    pub equilibrium_residual: f64,
    /// Evaluations granted to each level but the finest; in proportion to the resolution below 20 mm.
    pub coarse_evaluations: usize,
    /// Evaluations granted to the finest level until hand-off.
    pub finest_evaluations: usize,
    /// Evaluations granted to the finest level until equilibrium.
    pub equilibrium_evaluations: usize,
}

/// Distance kept from the body unless another is asked for, m: half the thickness of the cloth, whose middle is what is
/// computed, so that it lies on the skin. A fit is falsified by more: three millimetres all around are two centimetres of
/// girth, and cloth that is tight at all is stretched by that.
pub fn resting_clearance(fabric: &Fabric) -> f64 {
    (0.5 * fabric.thickness).max(LEAST_RESTING_CLEARANCE)
}

/// Thinner cloth keeps this, m: clearances hold within a tenth of a millimetre.
const LEAST_RESTING_CLEARANCE: f64 = 0.00025;
/// m. Of 200 garments that start in wrong places three crossed the body with 0.25 mm on all levels, one with this.
const LEAST_COARSE_CLEARANCE: f64 = 7e-4;
/// The coarsest level has at most this resolution, m: a sleeve has ten particles around it.
pub const COARSEST_LEVEL: f64 = 0.045;

impl Default for Settings {
    fn default() -> Self {
        Self::for_resolution(0.01)
    }
}

impl Settings {
    /// Levels that halve their resolution down to `resolution`, m.
    pub fn for_resolution(resolution: f64) -> Self {
        let mut resolutions = vec![resolution];
        while 2.0 * resolutions[0] <= COARSEST_LEVEL.min(COARSEST_RESOLUTION) {
            resolutions.insert(0, 2.0 * resolutions[0]);
        }
        Self {
            resolutions,
            clearance: resting_clearance(&Fabric::default()),
            model: Model::default(),
            minimizer: Method::default(),
            until: FinishLine::HandOff,
            equilibrium_residual: 0.1,
            coarse_evaluations: 2400,
            finest_evaluations: finest_evaluations(resolution),
            equilibrium_evaluations: 20_000,
        }
    }

    /// What cloth keeps from the body while it is sewn and on all levels but the finest, m: chords of coarse cloth cut limbs, and what
    /// is sewn nearer to them catches more of them.
    pub fn coarse_clearance(&self) -> f64 {
        self.clearance.max(LEAST_COARSE_CLEARANCE)
    }

    /// Are the figures possible?
    pub fn check(&self) -> Result<(), Error> {
        if !(0.0..=0.05).contains(&self.clearance) {
            return Err(Error::new(
                format!("A clearance of {} mm cannot be kept.", self.clearance * 1e3),
                "Give one from 0 mm to 50 mm.",
            ));
        }
        if self.equilibrium_residual <= 0.0 || self.equilibrium_residual.is_nan() {
            return Err(Error::new("The residual of the equilibrium is not positive.", "Give one such as 0.1."));
        }
        Ok(())
    }

    pub(super) fn steps(&self, level: &Level) -> Steps {
        Steps { evaluations: 0, largest_move: LARGEST_MOVE * level.resolution, restart_after: RESTART_AFTER }
    }

    /// Contact of a level with itself at `positions`, which should be free of intersections.
    pub(super) fn self_contact(
        &self,
        level: &Level,
        classes: Vec<u32>,
        fabric: &Fabric,
        positions: &[Vector3],
    ) -> SelfContact {
        let mut cloth = SelfContact::new(level, classes, SelfContactSettings::of(level.resolution, fabric));
        cloth.rebuild(positions);
        cloth
    }
}

/// Evaluations that bring the finest level to hand-off. They fall with the resolution, m: the finer
/// the level before, the nearer to its rest the cloth starts (counts for the stretch to settle within
/// a tenth of a per cent on garments at 10 mm and 5 mm).
fn finest_evaluations(resolution: f64) -> usize {
    (340.0 * (resolution / 0.005).powf(2.1)).clamp(300.0, 1500.0) as usize
}

/// The farthest that a particle moves in one step, in resolutions.
const LARGEST_MOVE: f64 = 0.17;
/// Steps of conjugate gradients until the direction is the gradient again: more than any run has, as
/// each run starts with the gradient.
const RESTART_AFTER: usize = 200;
