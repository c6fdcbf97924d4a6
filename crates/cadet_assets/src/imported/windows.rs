//! Windows for a mesh that names none: the shell is cut where vehicles usually have windows, and seats stand behind them.

use cadet_base::actor::ObjectClass;
use cadet_base::geometry::{Bounds, MeshBuilder};
use cadet_base::math::Vec3;

/// Windows lie between these shares of the vehicle's height: roof and belt line of most cars.
const CAR_BAND: (f32, f32) = (0.66, 0.91);
/// The cab of a truck or bus.
const CAB_BAND: (f32, f32) = (0.45, 0.75);
/// Behind the cab a truck may be a box.
const CAB_LENGTH_M: f32 = 1.8;
/// What stays of the shell at the ends of a row of windows, and between its two, meters.
const PILLAR_M: f32 = 0.09;
/// The roof's normal is steeper than this; windscreens lie at 20 degrees and more.
const MAX_UP: f32 = 0.94;
/// Mirrors stick out from the shell by more than this, meters.
const STICKS_OUT_M: f32 = 0.02;
/// Smaller windows than this altogether are none, square meters.
const MIN_AREA_M2: f32 = 0.3;

/// Triangle and slot, in the box frame.
pub(super) type Face = ([Vec3; 3], usize);

/// Where windows are assumed in a shell.
pub(super) struct Windows {
    z: (f32, f32),
    /// Side windows, from the rear to the front: from and to.
    side: [(f32, f32); 2],
    /// Windscreen and rear window reach this far from the middle.
    half_width: f32,
    /// The shell's own half width, without mirrors.
    outside: f32,
    /// Nothing behind this is a window.
    from_x: f32,
}

impl Windows {
    /// Finds where the windows of a shell are; `None` where nothing is steep at that height.
    pub(super) fn find(faces: &[Face], class: ObjectClass, size: Vec3) -> Option<Self> {
        let is_truck = class == ObjectClass::Truck;
        let (low, high) = if is_truck { CAB_BAND } else { CAR_BAND };
        let (z, middle) = ((low * size.z, high * size.z), 0.5 * (low + high) * size.z);
        let from_x = if is_truck { 0.5 * size.x - CAB_LENGTH_M } else { f32::NEG_INFINITY };
        let corners = |from: f32, to: f32| {
            faces.iter().flat_map(move |(f, _)| cut_band(f, from, to)).flatten().filter(move |p| p.x >= from_x - 1e-3)
        };
        let below = corners(0.0, 0.55 * size.z).map(|p| p.y.abs()).fold(0.0, f32::max);
        let outside = if below > 0.0 { below } else { 0.5 * size.y };
        let shell: Vec<Vec3> = corners(middle, z.1).filter(|p| p.y.abs() <= outside + STICKS_OUT_M).collect();
        let bounds = Bounds::of(shell.iter().copied());
        // At the top the shell is narrowest, at the middle shortest enough to leave the pillars.
        let top = shell.iter().filter(|p| p.z > z.1 - 1e-3).map(|p| p.y.abs()).fold(0.0, f32::max);
        let (rear, front) = (bounds.min.x.max(from_x) + PILLAR_M, bounds.max.x - PILLAR_M);
        let half_width = top - PILLAR_M;
        if shell.is_empty() || front - rear < 0.5 || half_width < 0.2 {
            return None;
        }
        let post = if is_truck { rear } else { 0.5 * (rear + front) };
        let side = [(rear, post - PILLAR_M / 2.0), (post + PILLAR_M / 2.0, front)];
        Some(Self { z, side, half_width, outside: outside + STICKS_OUT_M, from_x })
    }

    /// Cuts the faces that `may_be` windows and gives those parts the slot of glass; `None` where hardly any is left.
    pub(super) fn glaze(&self, faces: &[Face], may_be: impl Fn(usize) -> bool, glass_slot: usize) -> Option<Vec<Face>> {
        let mut cut = Vec::with_capacity(2 * faces.len());
        let mut area_m2 = 0.0;
        for (corners, slot) in faces {
            if !may_be(*slot) || !self.touches(corners) {
                cut.push((*corners, *slot));
                continue;
            }
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero().abs();
            let mut parts = vec![*corners];
            for (axis, at) in self.planes(normal) {
                parts = parts.iter().flat_map(|t| split(t, axis, at)).flatten().collect();
            }
            for part in parts {
                let is_window = self.is_window((part[0] + part[1] + part[2]) / 3.0, normal);
                if is_window {
                    area_m2 += (part[1] - part[0]).cross(part[2] - part[0]).length() / 2.0;
                }
                cut.push((part, if is_window { glass_slot } else { *slot }));
            }
        }
        (area_m2 >= MIN_AREA_M2).then_some(cut)
    }

    /// Adds two rows of seats behind the windows, the front one alone in a cab.
    pub(super) fn add_seats(&self, builder: &mut MeshBuilder, slot: u8) {
        let half_width = self.half_width.min(0.68);
        let (top, foot) = (0.5 * (self.z.0 + self.z.1), self.z.0 - 0.45);
        let [(rear, _), (post, front)] = self.side;
        let rows = if self.from_x.is_finite() { vec![0.5 * (post + front)] } else { vec![0.5 * (rear + post), post] };
        for x in rows {
            for side in [-0.55, 0.55] {
                let (y, half) = (side * half_width, 0.38 * half_width);
                builder.cuboid(Vec3::new(x - 0.12, y - half, foot), Vec3::new(x, y + half, top), slot);
            }
        }
    }

    fn touches(&self, corners: &[Vec3; 3]) -> bool {
        corners.iter().any(|p| p.z > self.z.0) && corners.iter().any(|p| p.z < self.z.1)
    }

    /// The planes that bound windows on a face: the axis and where.
    fn planes(&self, normal: Vec3) -> Vec<(usize, f32)> {
        let mut planes = vec![(2, self.z.0), (2, self.z.1)];
        if is_side(normal) {
            planes.extend(self.side.iter().flat_map(|(from, to)| [(0, *from), (0, *to)]));
        } else {
            planes.extend([(1, -self.half_width), (1, self.half_width)]);
        }
        planes
    }

    fn is_window(&self, p: Vec3, normal: Vec3) -> bool {
        let within = p.z > self.z.0 && p.z < self.z.1 && p.y.abs() <= self.outside && p.x >= self.from_x;
        let open = if is_side(normal) {
            self.side.iter().any(|(from, to)| p.x > *from && p.x < *to)
        } else {
            p.y.abs() < self.half_width
        };
        within && open && normal.z < MAX_UP
    }
}

fn is_side(normal: Vec3) -> bool {
    normal.y > normal.x
}

/// The part of a triangle between two heights.
fn cut_band(corners: &[Vec3; 3], from: f32, to: f32) -> Vec<[Vec3; 3]> {
    let [_, above] = split(corners, 2, from);
    above.iter().flat_map(|t| split(t, 2, to)[0].clone()).collect()
}

/// The triangles below and above a plane across an axis, turned as the whole is.
fn split(corners: &[Vec3; 3], axis: usize, at: f32) -> [Vec<[Vec3; 3]>; 2] {
    let side = |p: &Vec3| p[axis] - at;
    let mut halves = [Vec::new(), Vec::new()];
    for (sign, half) in [-1.0, 1.0].into_iter().zip(&mut halves) {
        let mut ring: Vec<Vec3> = Vec::with_capacity(4);
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            if sign * side(&a) >= 0.0 {
                ring.push(a);
            }
            if side(&a) * side(&b) < 0.0 {
                // From the lower to the higher corner, so that neighbors meet in the same point.
                let (lo, hi) = if a[axis] < b[axis] { (a, b) } else { (b, a) };
                let mut p = lo + (hi - lo) * (-side(&lo) / (side(&hi) - side(&lo)));
                p[axis] = at;
                ring.push(p);
            }
        }
        for i in 2..ring.len() {
            if (ring[i - 1] - ring[0]).cross(ring[i] - ring[0]).length_squared() > 1e-15 {
                half.push([ring[0], ring[i - 1], ring[i]]);
            }
        }
    }
    halves
}
