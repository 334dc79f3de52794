//! What speaks for and against a seam where panels have their places around the body.

use super::{Edges, PROBES, Scored};
use crate::geometry::Vector3;
use crate::pattern::names::Part;

impl Edges<'_> {
    /// Along the limb away from the torso's middle.
    fn limb(&self, edge: usize) -> Vector3 {
        match self.part(edge) {
            Some(Part::Sleeve | Part::Cuff) => {
                // Arms hang at about forty degrees in an A-pose, and are held out in a T-pose.
                let side = self.middle[self.ids[edge].panel].x.signum();
                Vector3::new(0.8 * side, -0.6, 0.0)
            }
            _ => Vector3::new(0.0, -1.0, 0.0),
        }
    }

    /// Panels around a body: cloth goes on in the plane (a waist, an armhole), or folds over to the other side of the
    /// body (a side seam, a shoulder).
    pub(super) fn placed(&self, made: &mut Scored, p: &[Vector3; PROBES], q: &[Vector3; PROBES]) {
        let (ea, eb) = (&self.edges[made.a], &self.edges[made.b]);
        let gaps = |opposed: bool| -> [Vector3; PROBES] {
            std::array::from_fn(|k| (if opposed { q[PROBES - 1 - k] } else { q[k] }) - p[k])
        };
        let mean = |gaps: &[Vector3; PROBES], normal: Vector3| {
            gaps.iter().map(|g| (g - normal * g.dot(&normal)).norm()).sum::<f64>() / PROBES as f64
        };
        let whole = |gaps: &[Vector3; PROBES]| gaps.iter().map(|g| g.norm()).sum::<f64>() / PROBES as f64;
        let (near, far) = (gaps(true), gaps(false));
        if whole(&near) > whole(&far) + 0.25 * ea.length.min(eb.length) {
            made.score -= 2.5;
        }
        let facing = ea.normal.dot(&eb.normal);
        let outwards = ea.outwards.dot(&eb.outwards);
        if facing < -0.3 {
            // Folded over an edge of the body.
            let aside = mean(&near, ea.normal);
            made.score += 1.5 - (aside / 0.04).min(5.0) - if outwards > 0.5 { 0.0 } else { 6.0 };
            made.score += self.open(made);
            if aside < 0.03 {
                made.reasons.push("opposite each other on the body".to_owned());
            }
        } else {
            let same = self.part(made.a).is_some() && self.part(made.a) == self.part(made.b);
            let gap = whole(&near);
            let ahead = near.iter().map(|g| g.dot(&ea.outwards)).sum::<f64>() / PROBES as f64;
            made.score += 1.5 - (gap / 0.15).min(6.0) - 6.0 * (outwards + if same { 0.7 } else { 0.3 }).clamp(0.0, 1.0);
            made.score -= if ahead > -0.05 { 0.0 } else { 1.0 };
            // Beside each other, not shifted along, and not turned away from each other but for what is gathered.
            let mean = near.iter().sum::<Vector3>() / PROBES as f64;
            let along = (p[PROBES - 1] - p[0]).try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
            let size = 0.5 * (ea.length + eb.length);
            made.score -= (0.6 * mean.dot(&along).abs() / size).min(1.2);
            let spread = near.iter().map(|g| (g - mean).norm()).sum::<f64>() / PROBES as f64;
            let gathered = 0.5 * (ea.length - eb.length).abs() / size;
            made.score -= (4.0 * (spread / size - gathered).max(0.0)).min(2.0);
            if same && self.part(made.a) != Some(Part::Trouser) && ea.bulge < -0.1 && eb.bulge < -0.1 {
                // Two halves of a neckline.
                made.score -= 3.0;
            }
            if gap < 0.1 {
                made.reasons.push("beside each other on the body".to_owned());
            }
        }
        self.labels(made);
    }

    /// What speaks against closing front to back where the body has to go through.
    fn open(&self, made: &Scored) -> f64 {
        let (ea, eb) = (&self.edges[made.a], &self.edges[made.b]);
        let along = ea.outwards.dot(&self.limb(made.a)).min(eb.outwards.dot(&self.limb(made.b)));
        let against = ea.outwards.dot(&self.limb(made.a)).max(eb.outwards.dot(&self.limb(made.b)));
        let inwards = ea.bulge < -0.04 && eb.bulge < -0.04;
        let side = ea.points.map_or(0.0, |p| p[PROBES / 2].x.signum());
        let mut against_it = 0.0;
        if along > 0.6 {
            // A hem, or the end of a sleeve.
            against_it -= 9.0;
        }
        if against < -0.6 {
            // Upwards or towards the torso: of these only shoulders are closed.
            // So are sides that flare widely, and the crown of a hood.
            let out = if matches!(self.part(made.a), Some(Part::Torso) | None) { -0.05 } else { 0.3 };
            let shoulder =
                !inwards && ea.outwards.x * side > out && ea.curved.max(eb.curved) < 0.1 || ea.normal.x.abs() > 0.7;
            against_it -= if shoulder { 0.0 } else { 9.0 };
        }
        if self.part(made.a) == Some(Part::Hood) && (ea.outwards.z > 0.6 || ea.outwards.y < -0.3) {
            // The face, and the neck.
            against_it -= 9.0;
        }
        if inwards {
            // Armholes and necklines.
            against_it -= 5.0;
        }
        against_it
    }
}
