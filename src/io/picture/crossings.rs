//! `crossings.png`: where cloth crosses cloth or the body, in red.

use super::color::{Color, color_from_srgb};
use super::preview;
use super::subject::{BodyView, GarmentView};

/// sRGB: what crosses, and the rest of the garment, pale so that the red is seen through nothing else.
const CROSSING: u32 = 0xd02020;
const SOUND: u32 = 0xa9bccb;
/// Rings of triangles around a crossing that are colored with it: two triangles of 5 mm are a pixel each.
const RINGS: usize = 2;

/// The garment like in the preview, with the triangles named in `crossing` and those around them in red, as a PNG file.
pub fn crossings(garment: &GarmentView, body: &BodyView, crossing: &[u32]) -> Vec<u8> {
    let colors = colors(garment, crossing);
    preview(&GarmentView { colors: &colors, ..*garment }, body)
}

fn colors(garment: &GarmentView, crossing: &[u32]) -> Vec<Color> {
    let mut marked = vec![false; garment.triangles.len()];
    crossing.iter().filter(|&&t| (t as usize) < garment.triangles.len()).for_each(|&t| marked[t as usize] = true);
    let mut touched = vec![false; garment.positions.len()];
    for _ in 0..RINGS {
        let of_marked = garment.triangles.iter().zip(&marked).filter(|(_, mark)| **mark);
        of_marked.flat_map(|(t, _)| t).for_each(|&p| touched[p as usize] = true);
        for (triangle, mark) in garment.triangles.iter().zip(&mut marked) {
            *mark |= triangle.iter().any(|&p| touched[p as usize]);
        }
    }
    let [red, pale] = [CROSSING, SOUND].map(color_from_srgb);
    marked.into_iter().map(|mark| if mark { red } else { pale }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn a_crossing_is_red_with_two_rings_around_it_and_the_rest_is_pale() {
        // A strip of triangles, each sharing an edge with the next.
        let positions: Vec<Point3<f64>> = (0..12).map(|k| Point3::new(k as f64, (k % 2) as f64, 0.0)).collect();
        let triangles: Vec<[u32; 3]> = (0..10).map(|k| [k, k + 1, k + 2]).collect();
        let garment = GarmentView { positions: &positions, triangles: &triangles, ..GarmentView::default() };
        let found = colors(&garment, &[0]);
        let red = color_from_srgb(CROSSING);
        assert_eq!(found.iter().filter(|&&color| color == red).count(), 5);
        assert!(found[..5].iter().all(|&color| color == red));
        assert!(colors(&garment, &[99]).iter().all(|&color| color != red), "a triangle that is not there");
    }
}
