//! Wheels: tire, rim with spokes, dark hub behind.

use super::paint::slot;
use super::surface::{Outward, Surface};
use cadet_base::math::{Vec3, cosf, sinf};
use std::f32::consts::TAU;

/// The rim's look.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rim {
    /// Number of spokes.
    pub spokes: usize,
    /// Share of the angle between spokes that a spoke fills at its foot.
    pub spoke_share: f32,
}

/// A wheel about its own center: axle along y, outer face toward +y.
pub(super) fn wheel(radius_m: f32, tyre_width_m: f32, rim: Rim, level: usize) -> Surface {
    let mut surface = Surface::default();
    let sides = [26, 14, 8, 6][level];
    let (r, half) = (radius_m, tyre_width_m / 2.0);
    let rim_r = r - 0.10 * r / 0.31;
    let ring = |radius: f32, y: f32| -> Vec<Vec3> {
        (0..=sides)
            .map(|k| (k % sides) as f32 / sides as f32 * TAU - TAU / 4.0)
            .map(|a| Vec3::new(radius * cosf(a), y, radius * sinf(a)))
            .collect()
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
    let grid: Vec<Vec<Vec3>> = tyre.iter().map(|(radius_m, y)| ring(*radius_m, *y)).collect();
    surface.sheet(&grid, Outward::From(Vec3::ZERO), |_, _| Some(slot::TYRE));
    if level == 3 {
        for (radius_m, y, slot) in [(r, half, slot::TYRE), (rim_r, half + 0.004, slot::RIM)] {
            surface.sheet(&[ring(radius_m, y), ring(0.0, y)], Outward::Along(Vec3::Y), |_, _| Some(slot));
        }
        return surface;
    }
    // Rim lip, barrel, and the brake's darkness behind the spokes.
    let face_y = half - 0.012;
    let well_y = half - 0.09;
    let outer = Outward::Along(Vec3::Y);
    let lip = 0.020;
    surface.sheet(&[ring(rim_r, half - 0.005), ring(rim_r - lip, face_y)], outer, |_, _| Some(slot::RIM));
    if level == 2 {
        surface.sheet(&[ring(rim_r - lip, face_y), ring(0.0, face_y)], outer, |_, _| Some(slot::RIM));
        return surface;
    }
    let barrel = [ring(rim_r - lip, face_y), ring(rim_r - lip - 0.006, well_y)];
    surface.sheet(&barrel, Outward::Towards(Vec3::ZERO), |_, _| Some(slot::LINER));
    if level == 0 {
        let back = [ring(rim_r, -half + 0.005), ring(0.0, -half + 0.03)];
        surface.sheet(&back, Outward::Along(Vec3::NEG_Y), |_, _| Some(slot::LINER));
    }
    surface.sheet(&[ring(rim_r - lip, well_y), ring(0.0, well_y)], outer, |_, _| Some(slot::LINER));
    let hub_r = 0.24 * rim_r;
    let step = TAU / rim.spokes as f32;
    let tip = rim_r - 0.5 * lip;
    let at = |radius: f32, a: f32, y: f32| Vec3::new(radius * cosf(a), y, radius * sinf(a));
    for k in 0..rim.spokes {
        let a = k as f32 * step + 0.4;
        let (w0, w1) = (0.5 * step * rim.spoke_share.max(0.75), 0.5 * step * rim.spoke_share);
        let front = if level == 0 {
            vec![
                vec![
                    at(hub_r, a - w0, face_y - 0.002),
                    at(hub_r, a, face_y + 0.004),
                    at(hub_r, a + w0, face_y - 0.002),
                ],
                vec![at(tip, a - w1, face_y - 0.006), at(tip, a, face_y), at(tip, a + w1, face_y - 0.006)],
            ]
        } else {
            vec![
                vec![at(hub_r, a - w0, face_y), at(hub_r, a + w0, face_y)],
                vec![at(tip, a - w1, face_y - 0.004), at(tip, a + w1, face_y - 0.004)],
            ]
        };
        surface.sheet(&front, outer, |_, _| Some(slot::RIM));
        if level == 0 {
            for (side, w0, w1) in [(-1.0, -w0, -w1), (1.0, w0, w1)] {
                let edge = vec![
                    vec![at(hub_r, a + w0, face_y - 0.002), at(tip, a + w1, face_y - 0.006)],
                    vec![at(hub_r, a + w0, face_y - 0.03), at(tip, a + w1, face_y - 0.03)],
                ];
                let away = at(1.0, a + side * TAU / 4.0, 0.0);
                surface.sheet(&edge, Outward::Along(away), |_, _| Some(slot::RIM));
            }
        }
    }
    {
        surface.sheet(&[ring(hub_r, face_y - 0.002), ring(0.0, face_y + 0.008)], outer, |_, _| Some(slot::RIM));
    }
    surface
}
