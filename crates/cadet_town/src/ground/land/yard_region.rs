//! Where yards lie in plan: what streets leave of them.

use strum::VariantArray;

use crate::ground::land::{YardSurface, Yards};
use crate::ground::region::{Contour, Frame, Ring, difference, grow, union};
use cadet_base::math::DVec2;

/// A strip so wide is left to grass between a yard and what is paved otherwise: outlines must not meet.
const APART_M: f64 = 0.05;

/// What sidewalks leave of the yards, by surface.
pub(crate) fn regions(yards: &Yards, sidewalk: &[Ring]) -> Vec<(YardSurface, Vec<Ring>)> {
    let Some((_, first)) = yards.outlines.first() else { return Vec::new() };
    let frame = Frame { origin: first[0].round() };
    let contour = |ring: &[DVec2]| -> Contour { ring.iter().map(|p| frame.point(*p)).collect() };
    let streets: Vec<Contour> = sidewalk.iter().map(|ring| contour(ring)).collect();
    let mut kept: Vec<Contour> = grow(&union(&streets), APART_M).into_iter().flatten().collect();
    let mut regions = Vec::new();
    for surface in YardSurface::VARIANTS.iter().copied() {
        let of_surface = yards.outlines.iter().filter(|(s, _)| *s == surface);
        let outlines: Vec<Contour> = of_surface.map(|(_, ring)| contour(ring)).collect();
        if outlines.is_empty() {
            continue;
        }
        let whole: Vec<Contour> = union(&outlines).into_iter().flatten().collect();
        // Shrunk and grown again: slivers vanish.
        let left = grow(&grow(&difference(&whole, &kept), -0.2), 0.2);
        kept.extend(grow(&left, APART_M).into_iter().flatten());
        regions.push((surface, frame.rings(&left)));
    }
    regions
}
