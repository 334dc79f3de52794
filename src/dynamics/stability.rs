//! How long a step of an explicit method may be.
//!
//! A particle of mass `m` that is bound with stiffness `K` must not be carried farther in a step than
//!
//! ```text
//!     Δt = 0.4 π √(m / K)                   (theory, equation 26; Vassilev and Spanlang 2001, section 3.2)
//! ```
//!
//! where `K` adds up all that pulls at it; how much stiffer particles are together than one alone is measured once
//! (`forces.rs`). One small triangle would set the pace for all: such particles are given
//! inertia, never weight, until the step is as long as a given share of the garment's mass can buy (selective mass
//! scaling, Olovsson, Simonsson and Unosson 2005). What hangs at rest hangs the same.

/// `0.4 π`.
const REACH: f64 = 0.4 * std::f64::consts::PI;

/// The longest stable step, and the inertia that makes it so.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace {
    /// s.
    pub step: f64,
    /// kg, one per particle, at least its mass.
    pub inertia: Vec<f64>,
    /// Inertia added, as a share of all mass.
    pub added: f64,
}

impl Pace {
    /// For masses, kg, bound by stiffnesses, N/m, where at most `share` of all mass is added.
    pub fn new(masses: &[f64], stiffness: &[f64], share: f64) -> Self {
        let total: f64 = masses.iter().sum();
        let needed = |step: f64| {
            let inertia = masses.iter().zip(stiffness).map(move |(&m, k)| m.max(k * (step / REACH).powi(2)));
            inertia.collect::<Vec<f64>>()
        };
        let added = |inertia: &[f64]| inertia.iter().zip(masses).map(|(i, m)| i - m).sum::<f64>() / total;
        let alone = masses.iter().zip(stiffness).map(|(m, k)| REACH * (m / k).sqrt()).fold(f64::INFINITY, f64::min);
        if !alone.is_finite() {
            // Nothing is bound to anything.
            return Self { step: FREE_STEP, inertia: masses.to_vec(), added: 0.0 };
        }
        let (mut shorter, mut longer) = (alone, 2.0 * alone);
        while added(&needed(longer)) <= share && longer < FREE_STEP {
            (shorter, longer) = (longer, 2.0 * longer);
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (shorter + longer);
            if added(&needed(middle)) <= share { shorter = middle } else { longer = middle }
        }
        let step = shorter.min(FREE_STEP);
        let inertia = needed(step);
        Self { step, added: added(&inertia), inertia }
    }
}

/// Step of particles that nothing binds, s.
const FREE_STEP: f64 = 1e-2;
/// They leave a millionth of the step.
const BISECTIONS: usize = 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mass_on_a_spring_does_not_explode_at_this_pace_and_does_at_twice_of_it() {
        let pace = Pace::new(&[0.3], &[5e4], 0.0);
        let swing = |step: f64| {
            let (mut x, mut v) = (1.0f64, 0.0f64);
            (0..10_000)
                .map(|_| {
                    v -= step * 5e4 / 0.3 * x;
                    x += step * v;
                    x.abs()
                })
                .fold(0.0, f64::max)
        };
        assert!(swing(pace.step) < 2.0);
        assert!(swing(2.0 * pace.step) > 1e6);
    }

    #[test]
    fn little_mass_buys_a_longer_step_where_few_are_small() {
        let mut stiffness = vec![1.0; 1000];
        stiffness[7] = 100.0;
        let masses = vec![1e-3; 1000];
        let (alone, scaled) = (Pace::new(&masses, &stiffness, 0.0), Pace::new(&masses, &stiffness, 0.01));
        assert!(scaled.step > 2.5 * alone.step && scaled.added <= 0.01);
        assert_eq!(scaled.inertia.iter().filter(|&&i| i > 1e-3).count(), 1);
        assert!(alone.added < 1e-5);
    }
}
