//! The interior as seen through the panes: dashboard, seats, steering wheel, and the driver.

use super::archetypes::Windows;
use super::glasshouse::Glasshouse;
use super::outline::Outline;
use super::paint::slot;
use super::surface::{Outward, Surface};
use cadet_base::math::{Mat3, Quat, Vec3, cosf, sinf};

/// Backrests lean 22 degrees.
const RECLINE_RAD: f32 = 0.384;

/// Where the seats stand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seats {
    /// Hip point of the driver, who sits on the left.
    pub hip: Vec3,
    /// Hip height and x of the rear bench, if there is one.
    pub rear_hip: Option<Vec3>,
    floor_z: f32,
    scale: f32,
}

impl Seats {
    /// The seats of a vehicle.
    pub fn new(o: &Outline, house: &Glasshouse) -> Self {
        let d = &o.d;
        let floor_z = if d.is_van { d.clearance_m + 0.25 } else { d.clearance_m + 0.10 };
        // Heads stay under the roof in low cars.
        let headroom = (d.height_m - 0.10 - floor_z - 0.30).min(0.92);
        let hip_x = if d.windows == Windows::ThreeDoor { house.b_pillar_x + 0.42 } else { house.b_pillar_x + 0.27 };
        let hip_x = if d.is_van { hip_x.max(o.screen_foot_x - 1.25) } else { hip_x };
        let hip = Vec3::new(hip_x, 0.22 * d.width_m, floor_z + 0.30 + 0.03);
        let rear_x = hip_x - 0.82;
        let has_bench = d.windows != Windows::PanelVan && rear_x > o.backlight_foot_x + 0.25;
        Self { hip, rear_hip: has_bench.then(|| Vec3::new(rear_x, 0.0, hip.z + 0.02)), floor_z, scale: headroom / 0.92 }
    }
}

fn leaning(angle: f32) -> Mat3 {
    Mat3::from_quat(Quat::from_rotation_y(-angle))
}

/// Adds what every vehicle has inside.
pub(super) fn add_interior(surface: &mut Surface, o: &Outline, house: &Glasshouse, seats: &Seats, level: usize) {
    let d = &o.d;
    add_tub(surface, o, seats, level);
    let back_half = Vec3::new(0.055, 0.23, 0.30 * seats.scale);
    let lean = leaning(RECLINE_RAD);
    let sides = [8, 4, 4][level];
    let back_center = |hip: Vec3| hip + Vec3::new(-0.16, 0.0, 0.0) + lean * Vec3::new(0.0, 0.0, 0.26 * seats.scale);
    surface.block_pair(back_center(seats.hip), back_half, lean, sides, slot::CLOTH);
    if level < 2 {
        let cushion = seats.hip + Vec3::new(0.10, 0.0, -0.09);
        surface.block_pair(cushion, Vec3::new(0.26, 0.24, 0.08), leaning(0.12), sides, slot::CLOTH);
    }
    let head = seats.hip + Vec3::new(-0.16, 0.0, 0.0) + lean * Vec3::new(0.01, 0.0, 0.66 * seats.scale);
    surface.block_pair(head, Vec3::new(0.045, 0.125, 0.085), lean, sides, slot::CLOTH);
    if let Some(rear) = seats.rear_hip {
        let half_width = 0.39 * d.width_m;
        let center = rear + Vec3::new(-0.14, 0.0, 0.24 * seats.scale);
        surface.block(center, Vec3::new(0.06, half_width, 0.29 * seats.scale), leaning(0.45), sides, slot::CLOTH);
        if level == 0 {
            surface.block(
                rear + Vec3::new(0.12, 0.0, -0.09),
                Vec3::new(0.25, half_width, 0.08),
                leaning(0.1),
                sides,
                slot::CLOTH,
            );
            let head = center + leaning(0.45) * Vec3::new(0.0, 0.24 * d.width_m, 0.35 * seats.scale);
            surface.block_pair(head, Vec3::new(0.04, 0.12, 0.07), leaning(0.3), sides, slot::CLOTH);
        }
    }
    if level < 2 {
        add_steering_wheel(surface, o, seats, level);
    }
    if d.windows == Windows::PanelVan {
        let x = house.b_pillar_x - 0.12;
        let p = o.glass_foot(x);
        let top = house.cant(x);
        let wall = [
            vec![Vec3::new(x, 0.0, seats.floor_z), Vec3::new(x, p.y - 0.03, seats.floor_z)],
            vec![Vec3::new(x, 0.0, p.z), Vec3::new(x, p.y - 0.03, p.z)],
            vec![Vec3::new(x, 0.0, top.z), Vec3::new(x, top.y - 0.03, top.z)],
        ];
        surface.pair(&wall, Outward::Along(Vec3::X), |_, _| Some(slot::DARK));
    }
}

/// Dashboard, floor, door cards, parcel shelf and the bulkheads.
fn add_tub(surface: &mut Surface, o: &Outline, seats: &Seats, level: usize) {
    let d = &o.d;
    let (front, rear) = (o.screen_foot_x, o.backlight_foot_x);
    let arch_top = d.wheel_radius_m + d.arch_radius_m + 0.03;
    let floor = if level < 2 { seats.floor_z } else { arch_top.max(d.belt_z - 0.38) };
    let (near, past) = (d.arch_radius_m + 0.03, d.arch_radius_m + 0.10);
    let mut stations = vec![front, 0.5 * (front + rear), rear];
    if level < 2 {
        let edges = d.axles_x.iter().flat_map(|a| [a - past, a - near, a + near, a + past]);
        stations.extend(edges.filter(|x| *x < front && *x > rear));
    }
    stations.sort_by(|a, b| b.total_cmp(a));
    let wall: Vec<Vec<Vec3>> = stations
        .iter()
        .map(|x| {
            let p = o.glass_foot(*x);
            // Wheel houses stand in the cabin.
            let is_house = level < 2 && d.axles_x.iter().any(|a| (x - a).abs() < near + 1e-4);
            let low_y = if is_house { d.width_m / 2.0 - 0.33 } else { p.y - 0.07 };
            let shelf_z = arch_top.min(p.z - 0.05);
            vec![
                p - Vec3::new(0.0, 0.012, 0.0),
                p - Vec3::new(0.0, 0.05, 0.03),
                Vec3::new(p.x, p.y - 0.07, shelf_z),
                Vec3::new(p.x, low_y, shelf_z),
                Vec3::new(p.x, low_y, floor),
                Vec3::new(p.x, 0.0, floor),
            ]
        })
        .collect();
    surface.pair(&wall, Outward::Along(Vec3::new(0.0, -1.0, 0.3)), |_, _| Some(slot::DARK));
    // The dashboard is a wedge under the windscreen.
    let dash_x = front - if d.is_van { 0.22 } else { 0.30 };
    let dash: Vec<Vec<Vec3>> = [0.0, 0.55, 0.96]
        .iter()
        .map(|t| {
            let y = t * o.glass_foot(front).y;
            let bow = (o.d.cowl_x - front) * (1.0 - t * t);
            let top = o.deck_z(front + bow, y) - 0.012;
            vec![
                Vec3::new(front + bow, y, top - 0.01),
                Vec3::new(0.5 * (front + dash_x), y, top + 0.012),
                Vec3::new(dash_x + 0.02, y, top),
                Vec3::new(dash_x, y, top - 0.04),
                Vec3::new(dash_x + 0.12, y, floor.max(top - 0.55)),
            ]
        })
        .collect();
    surface.pair(&dash, Outward::Along(Vec3::new(-0.6, 0.0, 1.0)), |_, _| Some(slot::DARK));
    // Bulkhead and tailgate lining close the ends.
    for (x, inside) in [(front - 0.02, -1.0), (rear + 0.03, 1.0)] {
        let p = o.glass_foot(x);
        let end: Vec<Vec<Vec3>> =
            [floor, p.z - 0.02].iter().map(|z| vec![Vec3::new(x, 0.0, *z), Vec3::new(x, p.y - 0.03, *z)]).collect();
        surface.pair(&end, Outward::Along(Vec3::new(inside, 0.0, 0.0)), |_, _| Some(slot::DARK));
    }
    if let Some(hip) = seats.rear_hip {
        let (from, to) = (hip.x - 0.30, rear + 0.02);
        if from > to + 0.08 {
            let z = o.top_z(to) - 0.03;
            let shelf: Vec<Vec<Vec3>> = [from, to]
                .iter()
                .map(|x| vec![Vec3::new(*x, 0.0, z), Vec3::new(*x, o.glass_foot(*x).y - 0.04, z)])
                .collect();
            surface.pair(&shelf, Outward::Along(Vec3::Z), |_, _| Some(slot::DARK));
        }
    }
}

/// Center and normal of the steering wheel.
fn steering_wheel(o: &Outline, seats: &Seats) -> (Vec3, Mat3) {
    let x = (seats.hip.x + 0.42).min(o.screen_foot_x - 0.33);
    let center = Vec3::new(x, seats.hip.y, (o.d.belt_z - 0.03).max(seats.hip.z + 0.27));
    (center, leaning(if o.d.is_van { 0.85 } else { 1.15 }))
}

fn add_steering_wheel(surface: &mut Surface, o: &Outline, seats: &Seats, level: usize) {
    let (center, axes) = steering_wheel(o, seats);
    add_wheel(surface, center, axes, 0.178, level);
}

/// A steering wheel.
pub(super) fn add_wheel(surface: &mut Surface, center: Vec3, axes: Mat3, radius_m: f32, level: usize) {
    let (around, tube) = if level == 0 { (14, 5) } else { (7, 3) };
    let rings: Vec<Vec<Vec3>> = (0..=around)
        .map(|i| {
            let a = (i % around) as f32 / around as f32 * std::f32::consts::TAU;
            (0..=tube)
                .map(|j| {
                    let b = (j % tube) as f32 / tube as f32 * std::f32::consts::TAU;
                    let r = radius_m + 0.015 * cosf(b);
                    center + axes * Vec3::new(r * cosf(a), r * sinf(a), 0.015 * sinf(b))
                })
                .collect()
        })
        .collect();
    surface.sheet(&rings, Outward::From(center), |_, _| Some(slot::DARK));
    surface.block(center - axes * Vec3::Z * 0.01, Vec3::new(0.07, radius_m - 0.013, 0.012), axes, 6, slot::DARK);
}

/// A person in a seat: head, torso and, for the driver, arms on the wheel.
pub(super) fn add_occupant(surface: &mut Surface, hip: Vec3, scale: f32, hands: Option<[Vec3; 2]>, level: usize) {
    let lean = leaning(0.30);
    let n = [12, 7, 5][level];
    let ring = |center: Vec3, half_x: f32, half_y: f32| -> Vec<Vec3> {
        (0..n)
            .map(|k| k as f32 / n as f32 * std::f32::consts::TAU)
            .map(|a| center + lean * Vec3::new(half_x * cosf(a), half_y * sinf(a), 0.0))
            .collect()
    };
    let at = |x: f32, z: f32| hip + Vec3::new(-0.03, 0.0, 0.0) + lean * Vec3::new(x, 0.0, z * scale);
    let torso: Vec<Vec<Vec3>> =
        [(0.0, 0.12, 0.17), (0.18, 0.11, 0.155), (0.36, 0.12, 0.185), (0.46, 0.10, 0.20), (0.52, 0.06, 0.10)]
            .iter()
            .map(|(z, a, b)| ring(at(0.0, *z), *a, *b))
            .collect();
    surface.builder.loft(&torso, slot::SHIRT, true);
    let neck: Vec<Vec<Vec3>> = [0.50, 0.60].iter().map(|z| ring(at(0.02, *z), 0.055, 0.055)).collect();
    surface.builder.loft(&neck, slot::SKIN, false);
    let face: Vec<Vec<Vec3>> = [(0.57, 0.05, 0.045), (0.61, 0.085, 0.066), (0.68, 0.098, 0.075), (0.73, 0.098, 0.077)]
        .iter()
        .map(|(z, a, b)| ring(at(0.04, *z), *a, *b))
        .collect();
    surface.builder.loft(&face, slot::SKIN, true);
    let hair: Vec<Vec<Vec3>> = [(0.66, 0.085, 0.082), (0.73, 0.102, 0.083), (0.77, 0.095, 0.078), (0.805, 0.06, 0.05)]
        .iter()
        .map(|(z, a, b)| ring(at(if *z < 0.70 { 0.015 } else { 0.032 }, *z), *a, *b))
        .collect();
    surface.builder.loft(&hair, slot::HAIR, true);
    if level == 2 {
        return;
    }
    let m = if level == 0 { 8 } else { 4 };
    for (k, side) in [1.0_f32, -1.0].into_iter().enumerate() {
        let shoulder = at(0.0, 0.45) + Vec3::Y * (0.195 * side);
        let hand = hands.map_or(hip + Vec3::new(0.22, 0.12 * side, 0.06), |h| h[k]);
        let elbow = shoulder.lerp(hand, 0.5) + Vec3::new(-0.04, 0.06 * side, -0.10);
        for (a, b, r0, r1, s) in [(shoulder, elbow, 0.055, 0.045, slot::SHIRT), (elbow, hand, 0.043, 0.036, slot::SKIN)]
        {
            limb(surface, a, b, r0, r1, m, s);
        }
    }
}

/// Seats for two on both sides of an aisle, by the hips of who would sit there; far away every other one.
pub(super) fn add_seat_pairs(surface: &mut Surface, hips: Vec<Vec3>, level: usize) {
    let sides = if level == 0 { 6 } else { 4 };
    let seen = hips.into_iter().enumerate().filter(|(k, _)| level != 2 || k % 2 == 0);
    for (_, hip) in seen {
        let back = hip + Vec3::new(-0.2, 0.0, 0.28);
        surface.block_pair(back, Vec3::new(0.05, 0.40, 0.36), Mat3::IDENTITY, sides, slot::CLOTH);
        if level < 2 {
            let cushion = hip + Vec3::new(0.02, 0.0, -0.08);
            surface.block_pair(cushion, Vec3::new(0.22, 0.40, 0.06), Mat3::IDENTITY, 4, slot::CLOTH);
        }
    }
}

/// A tube from `a` to `b`.
pub(super) fn limb(surface: &mut Surface, a: Vec3, b: Vec3, r0_m: f32, r1_m: f32, n: usize, slot: u8) {
    let along = (b - a).normalize();
    let u = along.cross(if along.z.abs() < 0.9 { Vec3::Z } else { Vec3::X }).normalize();
    let v = along.cross(u);
    let rings: Vec<Vec<Vec3>> = [(a, r0_m), (b, r1_m)]
        .iter()
        .map(|(c, r)| {
            (0..n)
                .map(|k| k as f32 / n as f32 * std::f32::consts::TAU)
                .map(|t| *c + (u * cosf(t) + v * sinf(t)) * *r)
                .collect()
        })
        .collect();
    surface.builder.loft(&rings, slot, true);
}

/// The driver, with a passenger if asked for, in the vehicle's frame.
pub(super) fn occupants(o: &Outline, seats: &Seats, has_passenger: bool, level: usize) -> Surface {
    let mut surface = Surface::default();
    let (center, axes) = steering_wheel(o, seats);
    let hands = [0.165, -0.165].map(|y| center + axes * Vec3::new(0.05, y, 0.02));
    add_occupant(&mut surface, seats.hip, seats.scale, Some(hands), level);
    if has_passenger {
        let hip = Vec3::new(seats.hip.x, -seats.hip.y, seats.hip.z);
        add_occupant(&mut surface, hip, 0.95 * seats.scale, None, level);
    }
    surface
}
