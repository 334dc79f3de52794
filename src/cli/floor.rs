//! Where the floor is in a simulation: as it is asked for, or under the feet of the body.

use super::Failure;
use crate::Error;
use crate::body::Motion;
use crate::geometry::Vector3;
use crate::io::length;

/// A body stands on the floor if the lowest point of its first pose is no farther from y = 0 than this, m. Bodies that
/// garments are fitted on have their feet there; a torso without legs floats.
const STANDING: f64 = 0.1;

/// Height of the floor, m, if there is one: as `--floor` asks, else under a body that stands, which starts in a pose.
pub fn floor(asked: Option<&str>, motion: &Motion, pose: &[Vector3]) -> Result<Option<f64>, Failure> {
    let lowest = |positions: &[Vector3]| positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    // Of the whole motion, however much of it is simulated: the floor is not to sink when a shot is gone on with.
    let of_body = || (0..motion.frame_count()).map(|k| lowest(&motion.positions(k))).fold(lowest(pose), f64::min);
    match asked {
        None if lowest(pose).abs() > STANDING => Ok(None),
        None | Some("body") => Ok(Some(of_body())),
        Some("none") => Ok(None),
        Some(text) => {
            let (sign, size) = text.strip_prefix('-').map_or((1.0, text), |size| (-1.0, size));
            let height = length::parse_or_zero(size).map_err(|e| {
                let problem = format!("\"{text}\" is no height of a floor ({})", e.problem());
                Error::new(problem, "Give a height with its unit, such as \"-2 cm\", or \"body\", or \"none\".")
            });
            height.map(|height| Some(sign * height)).map_err(|e| Failure::Usage(e.within("--floor")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shapes;

    fn at(height: f64, asked: Option<&str>) -> Result<Option<f64>, Failure> {
        let (positions, triangles) = shapes::sphere(Vector3::new(0.0, height, 0.0), 0.5, 8);
        let motion = Motion::baked(triangles, 24.0, vec![positions.clone()]).unwrap();
        floor(asked, &motion, &positions)
    }

    #[test]
    fn a_body_that_stands_has_a_floor_and_one_that_floats_has_none() {
        assert!(at(0.5, None).unwrap().unwrap().abs() < 1e-9);
        assert_eq!(at(0.9, None).unwrap(), None);
        assert!((at(0.9, Some("body")).unwrap().unwrap() - 0.4).abs() < 1e-9);
        assert_eq!(at(0.5, Some("none")).unwrap(), None);
        assert_eq!(at(0.5, Some("-2 cm")).unwrap(), Some(-0.02));
        assert_eq!(at(0.5, Some("3 mm")).unwrap(), Some(0.003));
        assert!(at(0.5, Some("3")).is_err() && at(0.5, Some("--3 mm")).is_err() && at(0.5, Some("ground")).is_err());
    }
}
