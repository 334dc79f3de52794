//! The limbs, as branches of the surface.
//!
//! Distances along the skin from the crown have their maxima at the ends of limbs. Sink a water level from the farthest point to
//! the crown: each maximum becomes an island, and where two islands meet, the younger one ends. A limb is an island that stood
//! alone for long; legs meet at the crotch, an arm meets the torso in the armpit. This is the merge tree of the level sets (H. Carr,
//! J. Snoeyink, U. Axen, "Computing contour trees in all dimensions", Computational Geometry 24, 2003), pruned by persistence;
//! level sets of geodesic distances to segment people go back to A. Verroust and F. Lazarus, "Extracting skeletal curves from 3D
//! scattered data", The Visual Computer 16, 2000. Unlike horizontal sections it does not care how the arms are held.

use super::geodesic::{self, Fans};
use crate::Error;
use crate::geometry::{UnionFind, Vector3};

/// A branch of the surface.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Its farthest vertex.
    pub tip: u32,
    /// Where it meets an older branch; of the oldest, its tip.
    pub saddle: u32,
    /// Distance along the skin between both levels, m.
    pub length: f64,
}

/// Head, two arms and two legs, as vertices of the mesh.
#[derive(Clone, Debug)]
pub struct Limbs {
    pub crown: u32,
    pub arms: [Branch; 2],
    pub legs: [Branch; 2],
    pub crotch: u32,
    /// For each vertex its distance from the crown along the skin, m.
    pub from_crown: Vec<f64>,
}

/// Shorter branches, as parts of the height, are noses, fingers and toes.
const LEAST_BRANCH: f64 = 0.12;
/// An arm from armpit to fingertips, as a part of the height, is at least this long; 0.38 is usual.
const LEAST_ARM: f64 = 0.2;
/// Legs end below this part of the height, even where one is lifted; hanging hands end at 0.38.
const FEET: f64 = 0.3;
/// Where legs begin, as a part of the height; usual is 0.47 (NASA-STD-3000, crotch height).
const USUAL_CROTCH: f64 = 0.47;
const CROTCH: std::ops::RangeInclusive<f64> = 0.30..=0.62;
/// Where arms begin, as a part of the height.
const USUAL_ARMPIT: f64 = 0.75;
const ARMPIT: std::ops::RangeInclusive<f64> = 0.58..=0.90;

impl Limbs {
    /// How unlike a person the limbs are arranged: zero for one with usual proportions whose sides are alike.
    pub fn oddity(&self, positions: &[Vector3], up: Vector3) -> f64 {
        let height_of = |v: u32| positions[v as usize].dot(&up);
        let toe = height_of(self.legs[0].tip).min(height_of(self.legs[1].tip));
        let height = height_of(self.crown) - toe;
        let level = |v: u32| (height_of(v) - toe) / height;
        let unlike = |[a, b]: &[Branch; 2]| (a.length - b.length).abs() / height;
        let [one, other] = [level(self.arms[0].saddle), level(self.arms[1].saddle)];
        // The oldest branch is measured from the crown, and not comparable.
        (level(self.crotch) - USUAL_CROTCH).abs()
            + (one - USUAL_ARMPIT).abs()
            + (other - USUAL_ARMPIT).abs()
            + (one - other).abs()
            + unlike(&self.arms)
            + (level(self.legs[0].tip) - level(self.legs[1].tip)).abs()
    }
}

/// The limbs of a mesh that stands along the unit vector `up`; sides are in no order.
pub fn limbs(positions: &[Vector3], triangles: &[[u32; 3]], fans: &Fans, up: Vector3) -> Result<Limbs, Error> {
    let height_of = |v: u32| positions[v as usize].dot(&up);
    let used: Vec<u32> = (0..positions.len() as u32).filter(|&v| !fans.of(v).is_empty()).collect();
    let crown = used.iter().copied().max_by(|&a, &b| height_of(a).total_cmp(&height_of(b)));
    let crown = crown.expect("a body has triangles");
    let floor = used.iter().map(|&v| height_of(v)).fold(f64::INFINITY, f64::min);
    let height = height_of(crown) - floor;
    let level = |v: u32| (height_of(v) - floor) / height;

    let from_crown = geodesic::distances(positions, triangles, fans, &[crown]);
    let branches = branches(triangles, fans, &from_crown, LEAST_BRANCH * height);
    let mut low: Vec<&Branch> = branches.iter().filter(|b| level(b.tip) < FEET).collect();
    low.sort_by(|a, b| b.length.total_cmp(&a.length));
    let [first, second, ..] = low[..] else {
        return Err(Error::new(
            "Two legs cannot be told apart.",
            "Landmarks are found on bodies with two separate legs that stand upright; a dress form or a figure in a skirt has none. \
             Close the mesh between the legs, and check that the feet are at the bottom.",
        ));
    };
    // The oldest branch has no end of its own: legs meet where the younger of the two ends.
    let (elder, younger) = if first.length >= second.length { (first, second) } else { (second, first) };
    let crotch = younger.saddle;
    if !CROTCH.contains(&level(crotch)) {
        return Err(Error::new(
            format!("The legs meet at {:.0} % of the height, where no crotch can be.", 100.0 * level(crotch)),
            "If the legs are grown together in the mesh, take a body whose legs are apart.",
        ));
    }
    let is_arm = |b: &&Branch| {
        level(b.tip) >= FEET && b.length > LEAST_ARM * height && ARMPIT.contains(&level(b.saddle)) && b.tip != b.saddle
    };
    let mut arms: Vec<&Branch> = branches.iter().filter(is_arm).collect();
    arms.sort_by(|a, b| b.length.total_cmp(&a.length));
    let [one, other, ..] = arms[..] else {
        let found = if arms.is_empty() { "No arm" } else { "Only one arm" };
        return Err(Error::new(
            format!("{found} can be told from the torso."),
            "Landmarks are found on bodies with two arms that hang free, 0 to 80 degrees below the horizontal. If arms or hands \
             are grown together with the torso in the mesh, take a body in an A-pose.",
        ));
    };
    let leg = |b: &Branch| Branch { saddle: crotch, ..b.clone() };
    Ok(Limbs { crown, arms: [one.clone(), other.clone()], legs: [leg(elder), leg(younger)], crotch, from_crown })
}

/// The branches of at least some length; the oldest is among them.
fn branches(triangles: &[[u32; 3]], fans: &Fans, level: &[f64], least: f64) -> Vec<Branch> {
    let at = |v: u32| level[v as usize];
    let mut order: Vec<u32> = (0..level.len() as u32).filter(|&v| at(v).is_finite()).collect();
    order.sort_by(|&a, &b| at(b).total_cmp(&at(a)).then(a.cmp(&b)));
    let mut rank = vec![u32::MAX; level.len()];
    (0..).zip(&order).for_each(|(k, &v)| rank[v as usize] = k);
    let mut islands = UnionFind::new(level.len());
    // Of each island, by its root, the highest vertex.
    let mut tips: Vec<u32> = (0..level.len() as u32).collect();
    let mut branches = Vec::new();
    for &v in &order {
        for &t in fans.of(v) {
            for w in triangles[t as usize] {
                // Only what is above the water already.
                if rank[w as usize] >= rank[v as usize] {
                    continue;
                }
                let (mine, other) = (islands.find(v), islands.find(w));
                if mine == other {
                    continue;
                }
                let (a, b) = (tips[mine as usize], tips[other as usize]);
                let (elder, younger) = if rank[a as usize] <= rank[b as usize] { (a, b) } else { (b, a) };
                if at(younger) - at(v) >= least {
                    branches.push(Branch { tip: younger, saddle: v, length: at(younger) - at(v) });
                }
                islands.union(mine, other);
                let root = islands.find(mine);
                tips[root as usize] = elder;
            }
        }
    }
    if let Some(&oldest) = order.first() {
        branches.push(Branch { tip: oldest, saddle: oldest, length: at(oldest) });
    }
    branches
}

/// The vertices of a branch: what is connected to its tip and farther from the crown than where it ends.
pub fn members(triangles: &[[u32; 3]], fans: &Fans, level: &[f64], branch: &Branch) -> Vec<bool> {
    let shore = level[branch.saddle as usize];
    let mut inside = vec![false; level.len()];
    inside[branch.tip as usize] = true;
    let mut open = vec![branch.tip];
    while let Some(v) = open.pop() {
        for &t in fans.of(v) {
            for w in triangles[t as usize] {
                if !inside[w as usize] && level[w as usize] > shore {
                    inside[w as usize] = true;
                    open.push(w);
                }
            }
        }
    }
    inside
}
