//! What the flat square looks like: a road of two lanes along x between lawns, all of it at z = 0.

use std::sync::Arc;

use crate::ground::{ASPHALT, Asphalt, MARKING, TERRAIN, palette};
use crate::paint::Wear;
use cadet_base::geometry::MeshBuilder;
use cadet_base::instance::Instance;
use cadet_base::math::{DVec3, Vec3};

/// Width of a lane; the origin lies in the middle of the right one.
const LANE_M: f32 = 3.5;
const LINE_M: f32 = 0.12;
/// Asphalt beyond the lines at the road's edges.
const SHOULDER_M: f32 = 0.5;
/// A dash of the line between the lanes and the gap after it.
const DASH_M: (f32, f32) = (3.0, 6.0);

/// The square from `-half_m` to `half_m`, cut into the cells of a grid: corners that all meet leave no gap.
pub(crate) fn tiles(half_m: f32) -> Vec<Instance> {
    let (right, middle, left) = (-0.5 * LANE_M, 0.5 * LANE_M, 1.5 * LANE_M);
    let line = |y: f32| [y - LINE_M / 2.0, y + LINE_M / 2.0];
    let ([a, b], [c, d], [e, f]) = (line(right), line(middle), line(left));
    let rows = [-half_m, right - SHOULDER_M, a, b, c, d, e, f, left + SHOULDER_M, half_m];
    let mut columns = vec![-half_m];
    while let Some(x) = columns.last().copied().filter(|x| *x < half_m) {
        let step = if columns.len() % 2 == 1 { DASH_M.1 } else { DASH_M.0 };
        columns.push((x + step).min(half_m));
    }
    let slot = |row: usize, column: usize| match row {
        0 | 8 => TERRAIN,
        2 | 6 => MARKING,
        4 if column % 2 == 1 => MARKING,
        _ => ASPHALT,
    };
    let mut builder = MeshBuilder::new();
    for (column, x) in columns.windows(2).enumerate() {
        for (row, y) in rows.windows(2).enumerate() {
            let [a, b, c, d] =
                [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])].map(|(x, y)| Vec3::new(x, y, 0.0));
            builder.triangle(a, b, c, slot(row, column));
            builder.triangle(a, c, d, slot(row, column));
        }
    }
    let palette = palette::palette(Asphalt::of_town(&Wear::default()));
    vec![Instance::standing(builder.build("flat road", 0.0), Arc::new(palette), DVec3::ZERO)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_road_covers_the_square_once_and_shows_two_lanes() {
        let tiles = tiles(200.0);
        let mesh = &tiles[0].shape.levels[0].1;
        assert!(mesh.places().all(|v| v.z == 0.0 && v.x.abs() <= 200.0 && v.y.abs() <= 200.0));
        let mut area_m2 = [0.0_f64; 5];
        for (corners, slot) in mesh.triangles() {
            let [a, b, c] = corners.map(|p| p.as_dvec3());
            let doubled = (b - a).cross(c - a).z;
            assert!(doubled > 0.0, "{corners:?} faces down");
            area_m2[usize::from(slot)] += doubled / 2.0;
        }
        assert!((area_m2.iter().sum::<f64>() - 400.0 * 400.0).abs() < 0.1, "{area_m2:?}");
        // Two lines along the whole of it, and one for 44 dashes of 3 m.
        assert!((area_m2[usize::from(MARKING)] - 0.12 * (2.0 * 400.0 + 44.0 * 3.0)).abs() < 0.1, "{area_m2:?}");
        assert!((area_m2[usize::from(TERRAIN)] - 400.0 * (400.0 - 8.0)).abs() < 0.1, "{area_m2:?}");
    }
}
