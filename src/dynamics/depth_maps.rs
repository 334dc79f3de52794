//! Image-space maps of a body that stands still: what is seen of it from the front and from behind.
//!
//! The body is drawn twice along z, without perspective: each map keeps for every pixel how near the skin is to the
//! viewer, and of which triangle it is (Vassilev, Spanlang and Chrysanthou 2001, section 4.2, who have the graphics card
//! draw depths, normals and velocities; here the triangle stands for its normal and velocity). A point is looked up in
//! the map of its own side, and the skin nearest to it is looked for in the pixels around.
//!
//! ```text
//!        viewer of the front map          A map knows the skin that its viewer sees, and nothing else. It is sure of
//!          |     |     |     |            the nearest place of a point if the disc of pixels around it that the place
//!          v     v  p  v     v            must be in has
//!                 .-'-.      |              no pixel without skin,
//!        ___.----'     '-.___v__            none where skin is seen almost edge-on, between whose samples there is
//!       /      |         |      \           more of it than between others, and
//!      | arm   |  torso  |  arm  |          no skin in front of the point.
//!                                         Then nothing is hidden that is nearer: it would be hidden behind skin that
//!                                         is nearer still.
//! ```
//!
//! Where a map is not sure it says why, and a tree is asked: within the body and between layers (between an arm and the
//! torso), beside its outline, where skin is steep. Not promised: skin thinner than a pixel; and where two places are
//! almost equally near, which of them is found: it may be farther than the other by up to [`Maps::tolerance`].

use super::broad_phase::enclosing;
use crate::geometry::Vector3;
use crate::geometry::coverage::{Budget, Corner, Coverage, Rect};

/// Edge of a pixel, m: about the clearance of the cloth, so that a disc has a few pixels, and a small part of a
/// triangle of skin. Half of it takes four times the memory and was no surer.
const PIXEL: f64 = 2e-3;
/// The most pixels of a map; of what is larger than a crowd they are coarser. 8 bytes each.
const MOST_PIXELS: f64 = 4e6;
/// Skin whose normal has a smaller cosine with the direction of the view is seen almost edge-on.
const STEEPEST: f64 = 0.3;
/// Points farther in front of the skin than this, m, are not looked up: a disc grows with its square, and what is so far
/// is not in contact.
const FARTHEST: f64 = 0.012;
/// From anywhere in a pixel to its middle, pixels, at most.
const HALF_DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Why a map does not know the nearest place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsure {
    /// No skin is straight before or behind the point, or the outline is near.
    Beside,
    /// Skin is seen almost edge-on.
    Steep,
    /// In the body, deeper than the skin rises within a pixel, or between two layers of it.
    Between,
    /// Other skin is in front of the point.
    Hidden,
    /// In front of the skin, but not near it.
    Far,
}

impl Unsure {
    pub const ALL: [(&'static str, Unsure); 5] = [
        ("beside", Unsure::Beside),
        ("steep", Unsure::Steep),
        ("between", Unsure::Between),
        ("hidden", Unsure::Hidden),
        ("far", Unsure::Far),
    ];
}

/// A front and a back map.
pub struct Maps {
    /// Middle of the body, m, world: depths are counted from there.
    middle: Vector3,
    /// Place of the middle on the map, pixels.
    center: [f64; 2],
    size: [usize; 2],
    /// m.
    pixel: f64,
    /// Pixels at the rim that have no skin, so that no disc reaches beyond the map.
    border: usize,
    /// Toward +z, and toward -z.
    sides: [Vec<Texel>; 2],
}

#[derive(Clone, Copy)]
struct Texel {
    /// How far the skin is toward the viewer, pixels; [`NO_SKIN`], [`EDGE_ON`].
    depth: f32,
    triangle: u32,
}

const NO_SKIN: f32 = f32::NEG_INFINITY;
const EDGE_ON: f32 = f32::INFINITY;

impl Maps {
    /// None for a body that cannot be drawn: without extent, or with triangles that overlap by the hundred.
    pub fn draw(positions: &[Vector3], triangles: &[[u32; 3]]) -> Option<Self> {
        let (low, high) = enclosing(positions.iter().copied());
        let extent = high - low;
        let pixel = PIXEL.max((extent.x * extent.y / MOST_PIXELS).sqrt());
        let border = (FARTHEST / pixel).ceil() as usize + 2;
        let size = [extent.x, extent.y].map(|length| (length / pixel).ceil() as usize + 2 * border);
        // Infinite, no numbers, or a line.
        let drawable = extent.norm().is_finite() && size[0].saturating_mul(size[1]) < 2 * MOST_PIXELS as usize;
        if !drawable {
            return None;
        }
        let nothing = Texel { depth: NO_SKIN, triangle: u32::MAX };
        let mut maps = Self {
            middle: (low + high) * 0.5,
            center: size.map(|pixels| 0.5 * pixels as f64),
            size,
            pixel,
            border,
            sides: [0; 2].map(|_| vec![nothing; size[0] * size[1]]),
        };
        maps.fill(positions, triangles)?;
        Some(maps)
    }

    fn fill(&mut self, positions: &[Vector3], triangles: &[[u32; 3]]) -> Option<()> {
        let corner = |&p: &Vector3| {
            let [x, y, z] = self.place(p);
            Corner::new(x, y, z)
        };
        let corners: Vec<Corner> = positions.iter().map(corner).collect();
        let clip = Rect { x0: 0, y0: 0, x1: self.size[0] as i64, y1: self.size[1] as i64 };
        let mut budget = Budget::new(clip);
        for (triangle, vertices) in (0..).zip(triangles) {
            let Some(coverage) = Coverage::of_middles(&vertices.map(|v| corners[v as usize])) else { continue };
            if !budget.spend(coverage.bounds.intersection(clip)) {
                return None;
            }
            for (side, sign) in self.sides.iter_mut().zip([1.0, -1.0]) {
                coverage.for_each_pixel(clip, |x, y| {
                    let texel = &mut side[y as usize * self.size[0] + x as usize];
                    let depth = (sign * coverage.depth(x as f64 + 0.5, y as f64 + 0.5)) as f32;
                    // At equal depth the first triangle stays.
                    if depth > texel.depth {
                        *texel = Texel { depth, triangle };
                    }
                });
            }
        }
        // Positive where a triangle faces the front.
        let cosine = |triangle: u32| {
            let [a, b, c] = triangles[triangle as usize].map(|v| positions[v as usize]);
            (b - a).cross(&(c - a)).try_normalize(0.0).map_or(0.0, |normal| normal.z)
        };
        let cosines: Vec<f64> = (0..triangles.len() as u32).map(cosine).collect();
        for (side, sign) in self.sides.iter_mut().zip([1.0, -1.0]) {
            for texel in side.iter_mut().filter(|texel| texel.depth != NO_SKIN) {
                if sign * cosines[texel.triangle as usize] < STEEPEST {
                    texel.depth = EDGE_ON;
                }
            }
        }
        Some(())
    }

    /// On the map, and toward the front, pixels.
    fn place(&self, point: Vector3) -> [f64; 3] {
        let from = (point - self.middle) / self.pixel;
        [self.center[0] + from.x, self.center[1] + from.y, from.z]
    }

    /// What a place that is found may be farther than the nearest, m, at most.
    pub fn tolerance(&self) -> f64 {
        HALF_DIAGONAL * self.pixel / STEEPEST
    }

    /// The triangle that is nearest to a point, or one next to it, if a map is sure. `squared_distance` tells how far a
    /// triangle is, m².
    pub fn nearest(&self, point: Vector3, squared_distance: impl Fn(u32) -> f64) -> Result<u32, Unsure> {
        let [x, y, z] = self.place(point);
        let [width, height] = self.size.map(|pixels| (pixels - self.border) as f64);
        let least = self.border as f64;
        let on_map = (least..width).contains(&x) && (least..height).contains(&y);
        if !on_map {
            return Err(Unsure::Beside);
        }
        let pixel = y as usize * self.size[0] + x as usize;
        let mut why = Unsure::Between;
        for (side, z) in self.sides.iter().zip([z, -z]) {
            let depth = side[pixel].depth;
            match depth {
                NO_SKIN => return Err(Unsure::Beside),
                EDGE_ON => why = Unsure::Steep,
                _ if z >= f64::from(depth) => return self.on_side(side, [x, y, z], squared_distance),
                _ => {}
            }
        }
        Err(why)
    }

    /// The same in front of skin that one map shows straight behind the point, at a place in pixels.
    fn on_side(
        &self,
        side: &[Texel],
        [x, y, z]: [f64; 3],
        squared_distance: impl Fn(u32) -> f64,
    ) -> Result<u32, Unsure> {
        let row_of = |row: i64| &side[row as usize * self.size[0]..][..self.size[0]];
        let middle = row_of(y as i64)[x as usize];
        let before = z - f64::from(middle.depth);
        if before * self.pixel > FARTHEST {
            return Err(Unsure::Far);
        }
        // Squared distances, pixels²: of the nearest sample; aside, of samples without skin, with skin that is seen
        // edge-on, and with skin in front.
        let mut nearest = (f64::INFINITY, middle.triangle);
        let [mut bare, mut steep, mut in_front] = [f64::INFINITY; 3];
        // The middle pixel's sample is no farther than this, and a pixel's skin may be nearer than its sample.
        let mut radius = (before * before + 0.5).sqrt() + HALF_DIAGONAL;
        for step in 0.. {
            // Rows from the middle outward.
            if f64::from(step) - 1.0 > radius {
                break;
            }
            for row in
                [y as i64 + i64::from(step), y as i64 - i64::from(step)].into_iter().take(1 + step.min(1) as usize)
            {
                let down = row as f64 + 0.5 - y;
                let half = (radius * radius - down * down).max(0.0).sqrt();
                let (first, last) = ((x - half) as usize, (x + half) as usize);
                for (texel, column) in row_of(row)[first..=last].iter().zip(first..) {
                    let right = column as f64 + 0.5 - x;
                    let aside = right * right + down * down;
                    match texel.depth {
                        NO_SKIN => bare = bare.min(aside),
                        EDGE_ON => steep = steep.min(aside),
                        depth => {
                            let behind = z - f64::from(depth);
                            if behind < 0.0 {
                                in_front = in_front.min(aside);
                            }
                            let squared = aside + behind * behind;
                            if squared < nearest.0 {
                                nearest = (squared, texel.triangle);
                            }
                        }
                    }
                }
                radius = radius.min(nearest.0.sqrt() + HALF_DIAGONAL);
            }
        }
        let distance = squared_distance(nearest.1).sqrt() / self.pixel;
        let disc = (distance + HALF_DIAGONAL).powi(2);
        match () {
            () if bare < disc => Err(Unsure::Beside),
            () if steep < disc => Err(Unsure::Steep),
            () if in_front < distance * distance => Err(Unsure::Hidden),
            () => Ok(nearest.1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shapes;
    use crate::dynamics::{BroadPhase, Surface};
    use crate::io::{body_obj, embedded};

    fn ball(center: Vector3, radius: f64) -> (Vec<Vector3>, Vec<[u32; 3]>) {
        shapes::sphere(center, radius, 24)
    }

    fn look(maps: &Maps, point: Vector3) -> Result<(), Unsure> {
        maps.nearest(point, |_| 0.0).map(|_| ())
    }

    /// Points near the skin: from each triangle some millimetres outward, and astray by as much.
    fn around(positions: &[Vector3], triangles: &[[u32; 3]]) -> Vec<Vector3> {
        let wave = |k: usize, step: f64| (k as f64 * step).sin();
        let point = |(k, t): (usize, &[u32; 3])| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let normal = (b - a).cross(&(c - a)).normalize();
            let astray = Vector3::new(wave(k, 12.9898), wave(k, 78.233), wave(k, 37.719));
            (a + b + c) / 3.0 + normal * (0.004 + 0.005 * wave(k, 3.7)) + astray * 0.003
        };
        triangles.iter().enumerate().map(point).collect()
    }

    /// What a map is sure of is true, of a ball and of a person; and it is sure of a good part.
    #[test]
    fn what_maps_are_sure_of_is_what_the_tree_finds() {
        let mannequin = body_obj::mesh(embedded::MANNEQUIN_OBJ).unwrap();
        for ((positions, triangles), least_share) in [(ball(Vector3::new(3.0, 1.0, -2.0), 0.3), 0.3), (mannequin, 0.25)]
        {
            let surface = |kind| Surface::new(&positions, &triangles, kind);
            let (tree, maps) = (surface(BroadPhase::Tree), surface(BroadPhase::Maps));
            let tolerance = Maps::draw(&positions, &triangles).unwrap().tolerance();
            let points = around(&positions, &triangles);
            let (mut sure, mut apart, mut outside) = (0, 0, 0);
            for &point in &points {
                let exact = tree.nearest(point, 0.05).unwrap();
                let found = maps.nearest(point, 0.05).unwrap();
                if maps.look(point, 0.05).unsure.is_some() {
                    assert_eq!(found.distance, exact.distance, "the tree was asked");
                    continue;
                }
                let more = found.distance.abs() - exact.distance.abs();
                assert!(more < tolerance, "{point}: {found:?} is not {exact:?}");
                assert!(exact.distance > -HALF_DIAGONAL * PIXEL, "within the body no map is sure: {point}");
                sure += 1;
                apart += usize::from(more > 1e-9);
            }
            outside += points.iter().filter(|p| tree.nearest(**p, 0.05).unwrap().distance > 0.0).count();
            assert!(sure as f64 > least_share * outside as f64, "sure of {sure} of {outside}");
            assert!(apart * 500 <= sure, "{apart} of {sure} are not the nearest");
        }
    }

    #[test]
    fn what_no_map_shows_is_not_claimed() {
        // Two balls, one behind the other.
        let (mut positions, mut triangles) = ball(Vector3::zeros(), 0.1);
        let (others, of_others) = ball(Vector3::new(0.0, 0.0, 0.3), 0.1);
        triangles.extend(of_others.iter().map(|t| t.map(|v| v + positions.len() as u32)));
        positions.extend(others);
        let maps = Maps::draw(&positions, &triangles).unwrap();
        let at = |x: f64, z: f64| look(&maps, Vector3::new(x, 0.0, z));
        assert_eq!(at(0.0, 0.403), Ok(()));
        assert_eq!(at(0.0, -0.103), Ok(()));
        assert_eq!(at(0.0, 0.0), Err(Unsure::Between));
        assert_eq!(at(0.0, 0.15), Err(Unsure::Between));
        assert_eq!(at(0.0, 0.45), Err(Unsure::Far));
        assert_eq!(at(0.103, 0.3), Err(Unsure::Beside));
        assert_eq!(at(0.099, 0.33), Err(Unsure::Steep));
        assert_eq!(at(5.0, 0.0), Err(Unsure::Beside));
        assert_eq!(at(f64::NAN, 0.0), Err(Unsure::Beside));
        assert_eq!(at(0.0, f64::INFINITY), Err(Unsure::Far));
    }

    /// A low and a high box, side by side: in front of the low one, at the wall of the high one, which no viewer sees.
    #[test]
    fn beside_a_wall_no_map_is_sure() {
        let corner = |k: usize| {
            let side = |bit: usize, size: f64| if k >> bit & 1 == 1 { size } else { 0.0 };
            Vector3::new(side(0, 0.1), side(1, 0.1), side(2, 0.05))
        };
        let mut positions: Vec<Vector3> = (0..8).map(corner).collect();
        positions.extend((0..8).map(|k| {
            let p = corner(k);
            Vector3::new(p.x + 0.1, p.y, p.z * 2.0)
        }));
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let all = quads.iter().chain(&quads).enumerate();
        let triangles: Vec<[u32; 3]> = all
            .flat_map(|(k, quad)| {
                let [a, b, c, d] = quad.map(|v| v + if k < 6 { 0 } else { 8 });
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let maps = Maps::draw(&positions, &triangles).unwrap();
        let at = |x: f64| look(&maps, Vector3::new(x, 0.05, 0.058));
        assert_eq!(at(0.05), Ok(()));
        let point = Vector3::new(0.094, 0.05, 0.058);
        let exact = |t: u32| {
            let [a, b, c] = triangles[t as usize].map(|v| positions[v as usize]);
            let [u, v, w] = crate::geometry::closest_on_triangle(point, [a, b, c]);
            (a * u + b * v + c * w - point).norm_squared()
        };
        assert_eq!(maps.nearest(point, exact), Err(Unsure::Hidden));
    }

    #[test]
    fn what_cannot_be_drawn_is_not() {
        assert!(Maps::draw(&[], &[]).is_none());
        let far = |x: f64| [Vector3::zeros(), Vector3::new(x, 0.0, 0.0), Vector3::new(0.0, 1e-3, 0.0)];
        assert!(Maps::draw(&far(f64::INFINITY), &[[0, 1, 2]]).is_none());
        assert!(Maps::draw(&far(1e6), &[[0, 1, 2]]).is_none());
        assert!(Maps::draw(&far(1.0), &[[0, 1, 2]]).is_some());
        // A kilometre of skin has coarser pixels.
        let wide = [Vector3::zeros(), Vector3::new(1e3, 0.0, 0.0), Vector3::new(0.0, 1e3, 0.0)];
        assert!(Maps::draw(&wide, &[[0, 1, 2]]).unwrap().pixel > 0.4);
    }
}
