//! What a tram's car has besides its shell: bellows, bogies, roof boxes, lamps, coupling, mirrors, and the pantograph.

use super::super::interior::limb;
use super::super::paint::{slot, work_slot};
use super::super::surface::{Grid, Outward, Surface, grid};
use super::plan::{CarPlan, End};
use super::shell::{BELLOWS_M, ROOF_BOX_M, roof};
use super::{HALF_TRACK_M, WHEEL_RADIUS_M};
use crate::scenery::WIRE_HEIGHT_M;
use cadet_base::math::{Mat3, Vec3};

/// How far bellows reach into the shell.
const INTO_SHELL_M: f32 = 0.15;

/// +1 for the front, -1 for the rear, with what is there.
fn ends(p: &CarPlan) -> [(f32, End); 2] {
    [(1.0, p.ends[0]), (-1.0, p.ends[1])]
}

/// Half of the bellows at each joint, folded.
pub(super) fn add_bellows(surface: &mut Surface, p: &CarPlan, level: usize) {
    let folds = [5, 4, 2, 1][level];
    let (low, high) = (p.floor_z.min(0.5), roof(p) - 0.12);
    for (sign, _) in ends(p).into_iter().filter(|(_, end)| *end == End::Joint) {
        // From inside of the shell, which draws in toward the roof.
        let from = p.length_m / 2.0 - BELLOWS_M - INTO_SHELL_M;
        let ring = |t: f32, inset: f32| {
            let (x, y) = (sign * (from + (BELLOWS_M + INTO_SHELL_M) * t), p.width_m / 2.0 - 0.10 - inset);
            let corner = 0.16;
            let points =
                [(y, low), (y, high - corner), (y - corner, high), (corner - y, high), (-y, high - corner), (-y, low)];
            let ring = points.map(|(y, z)| Vec3::new(x, y, z));
            if sign > 0.0 { ring.to_vec() } else { ring.into_iter().rev().collect() }
        };
        let rings: Grid =
            (0..=2 * folds).map(|k| ring(k as f32 / (2 * folds) as f32, if k % 2 == 1 { 0.07 } else { 0.0 })).collect();
        surface.builder.loft(&rings, slot::GRILLE, true);
    }
}

/// The boxes on the roof, up to the height of the label.
pub(super) fn add_roof_boxes(surface: &mut Surface, p: &CarPlan, level: usize) {
    let (base, half) = (roof(p) - 0.03, p.length_m / 2.0);
    let w = 0.62 * p.width_m / 2.0;
    let count = if p.length_m < 5.0 { 1 } else { 2 + usize::from(p.length_m > 14.0 && !p.has_pantograph) };
    let room = p.length_m - 3.6;
    for k in 0..count {
        let at = if count == 1 { 0.0 } else { half - 1.8 - room * (k as f32 + 0.5) / count as f32 };
        let long = if count == 1 { 1.1 } else { (0.26 + 0.1 * p.detail[k]) * room / count as f32 * 1.6 };
        let top = if k == 0 { p.height_m } else { p.height_m - 0.05 * p.detail[2] };
        surface.cuboid([at - long, at + long], [-w, w], [base, top], work_slot::LOAD);
        if level < 2 {
            // Slots for air in the flanks.
            let x = [at - 0.7 * long, at + 0.7 * long];
            surface.cuboid_pair(x, [w - 0.01, w + 0.004], [base + 0.10, top - 0.05], slot::GRILLE);
        }
    }
}

/// Frames and wheels, seen below the skirt and between.
pub(super) fn add_bogies(surface: &mut Surface, p: &CarPlan, level: usize) {
    let half = p.length_m / 2.0;
    let [front, rear] = p.ends.map(|e| half - if e == End::Cab { 0.9 } else { 0.4 });
    let (half_y, top) = (0.44 * p.width_m, 0.52_f32.min(p.floor_z - 0.02).max(0.36));
    surface.cuboid([-rear, front], [-half_y, half_y], [0.34, top], slot::LINER);
    for x in &p.bogies {
        surface.cuboid([x - 1.25, x + 1.25], [-0.52, 0.52], [0.22, 0.45], slot::LINER);
        if level == 3 {
            continue;
        }
        let sides = [14, 9, 6][level];
        for axle in [-0.9, 0.9] {
            for side in [-1.0, 1.0] {
                let y = side * HALF_TRACK_M;
                let [a, b] = [y - 0.06, y + 0.06].map(|y| Vec3::new(x + axle, y, WHEEL_RADIUS_M));
                limb(surface, a, b, WHEEL_RADIUS_M, WHEEL_RADIUS_M, sides, slot::RIM);
            }
        }
    }
}

/// Lamps, the letters of the destination, the coupling's flap and the bumper at each cab.
pub(super) fn add_ends(surface: &mut Surface, p: &CarPlan, level: usize) {
    let (half, w) = (p.length_m / 2.0, p.width_m / 2.0);
    for (sign, _) in ends(p).into_iter().filter(|(_, end)| *end == End::Cab) {
        let span = |x0: f32, x1: f32| if sign > 0.0 { [x0, x1] } else { [-x1, -x0] };
        // The nose is bowed, the tail less: what sits beside the middle reaches less far.
        let (lamp, amber) = if sign > 0.0 { (0.07, 0.115) } else { (0.012, 0.035) };
        let front_lamp = if sign > 0.0 { slot::LAMP } else { slot::TAIL_LAMP };
        surface.cuboid_pair(span(half - 0.40, half - lamp), [0.48 * w, 0.64 * w], [0.74, 0.88], front_lamp);
        surface.cuboid_pair(span(half - 0.46, half - amber), [0.66 * w, 0.74 * w], [0.74, 0.88], slot::LEFT_SIGNAL);
        if level < 3 {
            surface.cuboid_pair(span(half - 0.12, half - 0.002), [0.0, 0.34 * w], [0.40, 0.62], slot::PLASTIC);
        }
        if level < 2 {
            // Over the screen it leans back.
            let lean = if sign > 0.0 { p.lean_tangent } else { 0.8 * p.lean_tangent };
            let x = half - lean * (p.header_z + 0.14 - p.sill_z + 0.25);
            let letters = 7 + (4.0 * p.detail[3]) as usize;
            for k in 0..letters {
                let y = (k as f32 - letters as f32 / 2.0) * 0.085;
                let tall = 0.06 + 0.02 * ((k * 7) % 3) as f32 / 2.0;
                let middle_z = p.header_z + 0.14;
                let z = [middle_z - tall, middle_z + tall];
                surface.cuboid(span(x - 0.14, x - 0.045), [y, y + 0.055], z, work_slot::AMBER);
            }
        }
    }
}

/// Mirrors and the pantograph, beyond the label's box.
pub(super) fn add_what_sticks_out(surface: &mut Surface, p: &CarPlan, level: usize) {
    let (half, w) = (p.length_m / 2.0, p.width_m / 2.0);
    if p.ends[0] == End::Cab && level < 3 {
        let at = Vec3::new(half - 0.75, w + 0.10, p.header_z - 0.35);
        surface.block_pair(at, Vec3::new(0.05, 0.09, 0.17), Mat3::IDENTITY, [8, 6, 4][level], slot::PLASTIC);
    }
    if !p.has_pantograph {
        return;
    }
    let (top, wire) = (roof(p), WIRE_HEIGHT_M as f32);
    let x = if p.ends[0] == End::Cab { -0.9 } else { 0.9 };
    let thin = [0.025, 0.03, 0.045, 0.06][level];
    let base = top + ROOF_BOX_M + 0.02;
    surface.cuboid([x - 0.75, x + 0.75], [-0.55, 0.55], [top - 0.02, base - 0.08], work_slot::FRAME);
    // One arm: the lower leads back to the knee, the upper forward to the head.
    let foot = Vec3::new(x + 0.55, 0.0, base - 0.06);
    let knee = Vec3::new(x - 1.05, 0.0, base + 0.48 * (wire - base));
    let head = Vec3::new(x + 0.30, 0.0, wire - 0.06);
    let sides = [8, 6, 4, 4][level];
    let mut rod = |from: Vec3, to: Vec3, [r0, r1]: [f32; 2], sides: usize| {
        limb(surface, from, to, r0 * thin, r1 * thin, sides, work_slot::FRAME);
    };
    rod(foot, knee, [1.6, 1.3], sides);
    if level < 2 {
        rod(foot + Vec3::new(-0.25, 0.12, 0.0), knee + Vec3::new(0.1, 0.06, -0.08), [0.6, 0.6], 5);
    }
    for y in [-0.38, 0.38] {
        rod(knee + Vec3::new(0.0, 0.2 * y, 0.0), head + Vec3::new(0.0, y, 0.0), [1.0, 0.8], sides);
    }
    for dx in [-0.16, 0.16] {
        let bar = [(-0.82, -0.16), (-0.55, 0.035), (0.55, 0.035), (0.82, -0.16)];
        let rows = grid([-0.03, 0.03], bar, |e, (y, z)| Vec3::new(head.x + dx + e, y, wire - 0.04 + z));
        surface.panel(&rows, Outward::Along(Vec3::Z), work_slot::FRAME);
        surface.panel(&rows, Outward::Along(Vec3::NEG_Z), work_slot::FRAME);
    }
}
