//! Wheels: tire, rim with spokes, dark hub behind.

use super::paint::slot;
use super::surface::{Outward, Surface, grid, mirrored, turns_rad};
use cadet_base::math::{Mat3, Vec3, cosf, sinf};
use std::f32::consts::TAU;

/// The rim's look.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rim {
    /// Number of spokes.
    pub spokes: usize,
    /// Share of the angle between spokes that a spoke fills at its foot.
    pub spoke_share: f32,
}

/// Adds a wheel of an axle and, turned round, the one on the other side.
pub(super) fn add_pair(surface: &mut Surface, wheel: &Surface, center: Vec3) {
    let turn = Mat3::from_diagonal(Vec3::new(-1.0, -1.0, 1.0));
    surface.builder.append(&wheel.builder, Mat3::IDENTITY, center);
    surface.builder.append(&wheel.builder, turn, mirrored(center));
}

/// A wheel about its own center: axle along y, outer face toward +y.
pub(super) fn wheel(radius_m: f32, tyre_width_m: f32, rim: Rim, level: usize) -> Surface {
    let mut surface = Surface::default();
    let sides = [26, 14, 8, 6][level];
    let (r, half) = (radius_m, tyre_width_m / 2.0);
    let rim_r = r - 0.10 * r / 0.31;
    let at = |radius: f32, a: f32, y: f32| Vec3::new(radius * cosf(a), y, radius * sinf(a));
    // A sheet of rings by their radii and y.
    let tube = |rings: &[(f32, f32)]| {
        let around = turns_rad(sides).chain([0.0]).map(|a| a - TAU / 4.0);
        grid(rings, around, |(radius, y), a| at(*radius, a, *y))
    };
    let tyre: Vec<(f32, f32)> = match level {
        0 => vec![
            (rim_r, -half + 0.005),
            (r - 0.03, -half - 0.002),
            (r - 0.008, -half + 0.008),
            (r, -half + 0.025),
            (r, half - 0.025),
            (r - 0.008, half - 0.008),
            (r - 0.03, half + 0.002),
            (rim_r, half - 0.005),
        ],
        1 => vec![(r - 0.006, -half), (r, -0.5 * half), (r, 0.5 * half), (r - 0.02, half), (rim_r, half - 0.005)],
        2 => vec![(r, -half), (r, half), (rim_r, half)],
        _ => vec![(r, -half), (r, half)],
    };
    surface.panel(&tube(&tyre), Outward::From(Vec3::ZERO), slot::TYRE);
    if level == 3 {
        for (radius_m, y, slot) in [(r, half, slot::TYRE), (rim_r, half + 0.004, slot::RIM)] {
            surface.panel(&tube(&[(radius_m, y), (0.0, y)]), Outward::Along(Vec3::Y), slot);
        }
        return surface;
    }
    // Rim lip, barrel, and the brake's darkness behind the spokes.
    let face_y = half - 0.012;
    let well_y = half - 0.09;
    let outer = Outward::Along(Vec3::Y);
    let lip = 0.020;
    surface.panel(&tube(&[(rim_r, half - 0.005), (rim_r - lip, face_y)]), outer, slot::RIM);
    if level == 2 {
        surface.panel(&tube(&[(rim_r - lip, face_y), (0.0, face_y)]), outer, slot::RIM);
        return surface;
    }
    let barrel = tube(&[(rim_r - lip, face_y), (rim_r - lip - 0.006, well_y)]);
    surface.panel(&barrel, Outward::Towards(Vec3::ZERO), slot::LINER);
    if level == 0 {
        let back = tube(&[(rim_r, -half + 0.005), (0.0, -half + 0.03)]);
        surface.panel(&back, Outward::Along(Vec3::NEG_Y), slot::LINER);
    }
    surface.panel(&tube(&[(rim_r - lip, well_y), (0.0, well_y)]), outer, slot::LINER);
    let hub_r = 0.24 * rim_r;
    let step = TAU / rim.spokes as f32;
    let tip = rim_r - 0.5 * lip;
    for k in 0..rim.spokes {
        let a = k as f32 * step + 0.4;
        let (w0, w1) = (0.5 * step * rim.spoke_share.max(0.75), 0.5 * step * rim.spoke_share);
        // At the hub and at the tip: radius, half angle, y of the edges and of the ridge between them.
        let (edges, across): (_, &[f32]) = if level == 0 {
            ([(hub_r, w0, face_y - 0.002, face_y + 0.004), (tip, w1, face_y - 0.006, face_y)], &[-1.0, 0.0, 1.0])
        } else {
            ([(hub_r, w0, face_y, face_y), (tip, w1, face_y - 0.004, face_y)], &[-1.0, 1.0])
        };
        let front = grid(edges, across, |(radius, wide, edge_y, ridge_y), side| {
            at(radius, a + side * wide, if *side == 0.0 { ridge_y } else { edge_y })
        });
        surface.panel(&front, outer, slot::RIM);
        if level == 0 {
            for (side, w0, w1) in [(-1.0, -w0, -w1), (1.0, w0, w1)] {
                let edge = [
                    [at(hub_r, a + w0, face_y - 0.002), at(tip, a + w1, face_y - 0.006)],
                    [at(hub_r, a + w0, face_y - 0.03), at(tip, a + w1, face_y - 0.03)],
                ];
                let away = at(1.0, a + side * TAU / 4.0, 0.0);
                surface.panel(&edge, Outward::Along(away), slot::RIM);
            }
        }
    }
    surface.panel(&tube(&[(hub_r, face_y - 0.002), (0.0, face_y + 0.008)]), outer, slot::RIM);
    surface
}
