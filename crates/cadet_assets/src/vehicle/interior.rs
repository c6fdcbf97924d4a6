//! The interior as seen through the panes: dashboard, seats, steering wheel, and the driver.

use super::archetypes::Windows;
use super::glasshouse::Glasshouse;
use super::outline::Outline;
use super::paint::slot;
use super::surface::{Grid, Outward, Surface, grid, mirrored, turns_rad, upright};
use cadet_base::math::{Mat3, Quat, Vec3, cosf, sinf};

/// Rings of torso, neck, face, and hair: how far forward and up the leaning spine, and half extents forward and aside.
type Rings = &'static [(f32, f32, f32, f32)];
const TORSO: Rings = &[
    (0.0, 0.0, 0.12, 0.17),
    (0.0, 0.18, 0.11, 0.155),
    (0.0, 0.36, 0.12, 0.185),
    (0.0, 0.46, 0.10, 0.20),
    (0.0, 0.52, 0.06, 0.10),
];
const NECK: Rings = &[(0.02, 0.50, 0.055, 0.055), (0.02, 0.60, 0.055, 0.055)];
const FACE: Rings =
    &[(0.04, 0.57, 0.05, 0.045), (0.04, 0.61, 0.085, 0.066), (0.04, 0.68, 0.098, 0.075), (0.04, 0.73, 0.098, 0.077)];
const HAIR: Rings = &[
    (0.015, 0.66, 0.085, 0.082),
    (0.032, 0.73, 0.102, 0.083),
    (0.032, 0.77, 0.095, 0.078),
    (0.032, 0.805, 0.06, 0.05),
];
/// With their materials; the neck's ends are inside of torso and face.
const SITTER: [(Rings, u8, bool); 4] =
    [(TORSO, slot::SHIRT, true), (NECK, slot::SKIN, false), (FACE, slot::SKIN, true), (HAIR, slot::HAIR, true)];

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
            let cushion = rear + Vec3::new(0.12, 0.0, -0.09);
            surface.block(cushion, Vec3::new(0.25, half_width, 0.08), leaning(0.1), sides, slot::CLOTH);
            let head = center + leaning(0.45) * Vec3::new(0.0, 0.24 * d.width_m, 0.35 * seats.scale);
            surface.block_pair(head, Vec3::new(0.04, 0.12, 0.07), leaning(0.3), sides, slot::CLOTH);
        }
    }
    if level < 2 {
        let (center, axes) = steering_wheel(o, seats);
        add_wheel(surface, center, axes, 0.178, level);
    }
    if d.windows == Windows::PanelVan {
        let x = house.b_pillar_x - 0.12;
        let p = o.glass_foot(x);
        let top = house.cant(x);
        let edges = [(p.y, seats.floor_z), (p.y, p.z), (top.y, top.z)];
        let wall = edges.map(|(y, z)| [Vec3::new(x, 0.0, z), Vec3::new(x, y - 0.03, z)]);
        surface.panel_pair(&wall, Outward::Along(Vec3::X), slot::DARK);
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
    let section = |x: f32| {
        let p = o.glass_foot(x);
        // Wheel houses stand in the cabin.
        let is_house = level < 2 && d.axles_x.iter().any(|a| (x - a).abs() < near + 1e-4);
        let low_y = if is_house { d.width_m / 2.0 - 0.33 } else { p.y - 0.07 };
        let shelf_z = arch_top.min(p.z - 0.05);
        let edges = [(p.y - 0.012, p.z), (p.y - 0.05, p.z - 0.03), (p.y - 0.07, shelf_z)];
        edges
            .into_iter()
            .chain([(low_y, shelf_z), (low_y, floor), (0.0, floor)])
            .map(move |(y, z)| Vec3::new(p.x, y, z))
    };
    let wall: Grid = stations.into_iter().map(|x| section(x).collect()).collect();
    surface.panel_pair(&wall, Outward::Along(Vec3::new(0.0, -1.0, 0.3)), slot::DARK);
    // The dashboard is a wedge under the windscreen.
    let dash_x = front - if d.is_van { 0.22 } else { 0.30 };
    let dash = [0.0, 0.55, 0.96].map(|t| {
        let y = t * o.glass_foot(front).y;
        let bow = (o.d.cowl_x - front) * (1.0 - t * t);
        let top = o.deck_z(front + bow, y) - 0.012;
        [
            Vec3::new(front + bow, y, top - 0.01),
            Vec3::new(0.5 * (front + dash_x), y, top + 0.012),
            Vec3::new(dash_x + 0.02, y, top),
            Vec3::new(dash_x, y, top - 0.04),
            Vec3::new(dash_x + 0.12, y, floor.max(top - 0.55)),
        ]
    });
    surface.panel_pair(&dash, Outward::Along(Vec3::new(-0.6, 0.0, 1.0)), slot::DARK);
    // Bulkhead and tailgate lining close the ends.
    for (x, inside) in [(front - 0.02, -1.0), (rear + 0.03, 1.0)] {
        let p = o.glass_foot(x);
        let end = upright(x, [0.0, p.y - 0.03], [floor, p.z - 0.02]);
        surface.panel_pair(&end, Outward::Along(Vec3::new(inside, 0.0, 0.0)), slot::DARK);
    }
    if let Some(hip) = seats.rear_hip {
        let (from, to) = (hip.x - 0.30, rear + 0.02);
        if from > to + 0.08 {
            let z = o.top_z(to) - 0.03;
            let shelf = [from, to].map(|x| [Vec3::new(x, 0.0, z), Vec3::new(x, o.glass_foot(x).y - 0.04, z)]);
            surface.panel_pair(&shelf, Outward::Along(Vec3::Z), slot::DARK);
        }
    }
}

/// Center and normal of the steering wheel.
fn steering_wheel(o: &Outline, seats: &Seats) -> (Vec3, Mat3) {
    let x = (seats.hip.x + 0.42).min(o.screen_foot_x - 0.33);
    let center = Vec3::new(x, seats.hip.y, (o.d.belt_z - 0.03).max(seats.hip.z + 0.27));
    (center, leaning(if o.d.is_van { 0.85 } else { 1.15 }))
}

/// A steering wheel.
pub(super) fn add_wheel(surface: &mut Surface, center: Vec3, axes: Mat3, radius_m: f32, level: usize) {
    let (around, tube) = if level == 0 { (14, 5) } else { (7, 3) };
    let closed = |count: usize| turns_rad(count).chain([0.0]);
    let rings = grid(closed(around), closed(tube), |a, b| {
        let r = radius_m + 0.015 * cosf(b);
        center + axes * Vec3::new(r * cosf(a), r * sinf(a), 0.015 * sinf(b))
    });
    surface.panel(&rings, Outward::From(center), slot::DARK);
    surface.block(center - axes * Vec3::Z * 0.01, Vec3::new(0.07, radius_m - 0.013, 0.012), axes, 6, slot::DARK);
}

/// A person in a seat: head, torso and, for the driver, arms on the wheel.
pub(super) fn add_occupant(surface: &mut Surface, hip: Vec3, scale: f32, hands: Option<[Vec3; 2]>, level: usize) {
    let lean = leaning(0.30);
    let n = [12, 7, 5][level];
    let at = |x: f32, z: f32| hip + Vec3::new(-0.03, 0.0, 0.0) + lean * Vec3::new(x, 0.0, z * scale);
    for (rings, slot, has_caps) in SITTER {
        let rings = grid(rings, turns_rad(n), |(x, z, half_x, half_y), a| {
            at(*x, *z) + lean * Vec3::new(half_x * cosf(a), half_y * sinf(a), 0.0)
        });
        surface.builder.loft(&rings, slot, has_caps);
    }
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

/// Adds who sits on the seats of [`add_seat_pairs`]: a share of them is taken, `phase_fraction` decides which.
pub(super) fn add_passengers(surface: &mut Surface, hips: Vec<Vec3>, phase_fraction: f32, share: f32) {
    for (k, hip) in hips.into_iter().enumerate() {
        for (m, y) in [hip.y + 0.2, hip.y - 0.2, -hip.y + 0.2, -hip.y - 0.2].into_iter().enumerate() {
            let t = phase_fraction * 17.0 + k as f32 * 0.617 + m as f32 * 0.381;
            if t - t.floor() < share {
                add_occupant(surface, hip.with_y(y), 0.9, None, 2);
            }
        }
    }
}

/// A tube from `a` to `b`.
pub(super) fn limb(surface: &mut Surface, a: Vec3, b: Vec3, r0_m: f32, r1_m: f32, n: usize, slot: u8) {
    let along = (b - a).normalize();
    let u = along.cross(if along.z.abs() < 0.9 { Vec3::Z } else { Vec3::X }).normalize();
    let v = along.cross(u);
    let rings = grid([(a, r0_m), (b, r1_m)], turns_rad(n), |(c, r), t| c + (u * cosf(t) + v * sinf(t)) * r);
    surface.builder.loft(&rings, slot, true);
}

/// A tube of constant width on the left side and its mirror image on the right.
pub(super) fn limb_pair(surface: &mut Surface, a: Vec3, b: Vec3, radius_m: f32, n: usize, slot: u8) {
    limb(surface, a, b, radius_m, radius_m, n, slot);
    limb(surface, mirrored(a), mirrored(b), radius_m, radius_m, n, slot);
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
