//! Lamps and traffic signs.

use super::draw::{CREASE_RAD, block, disc, path_tube, tube};
use super::materials::furniture_slot as slot;
use super::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::{PI, Vec3};

/// What stands at the sidewalk's edge. Signs face +x, lamp arms reach out to +x.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PoleKind {
    /// A residential lamp: a straight pole with its head on top.
    Lamp,
    /// A tall lamp with an arm over the road.
    ArmLamp,
    /// A round prohibition sign.
    RoundSign,
    /// Give way.
    TriangleSign,
    /// The priority road's diamond.
    DiamondSign,
    /// The square sign of a 30 km/h zone.
    ZoneSign,
    /// The blue parking sign.
    ParkingSign,
    /// Street names.
    NameSign,
    /// A bollard.
    Bollard,
    /// A white post with a black band at the edge of a main road.
    Delineator,
    /// Give way, and the blue disc of a roundabout below it.
    RoundaboutSign,
    /// A low board of red and white arrowheads that point to the driver's right.
    ArrowBoard,
}

impl PoleKind {
    /// Every kind.
    pub const ALL: [Self; 12] = [
        Self::Lamp,
        Self::ArmLamp,
        Self::RoundSign,
        Self::TriangleSign,
        Self::DiamondSign,
        Self::ZoneSign,
        Self::ParkingSign,
        Self::NameSign,
        Self::Bollard,
        Self::Delineator,
        Self::RoundaboutSign,
        Self::ArrowBoard,
    ];

    /// A short name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lamp => "lamp",
            Self::ArmLamp => "arm-lamp",
            Self::RoundSign => "round-sign",
            Self::TriangleSign => "triangle-sign",
            Self::DiamondSign => "diamond-sign",
            Self::ZoneSign => "zone-sign",
            Self::ParkingSign => "parking-sign",
            Self::NameSign => "name-sign",
            Self::Bollard => "bollard",
            Self::Delineator => "delineator",
            Self::RoundaboutSign => "roundabout-sign",
            Self::ArrowBoard => "arrow-board",
        }
    }
}

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A post from below the ground to `top`.
fn post(b: &mut MeshBuilder, radii: (f32, f32), top: f32, detail: Detail) {
    // Half a pixel wide as far as 100 m, lest it breaks into dashes.
    let least = detail.pick(0.0, 0.0, 0.04);
    let (low, high) = (radii.0.max(least), radii.1.max(least));
    tube(b, (v(0.0, 0.0, -0.4), low), (v(0.0, 0.0, top), high), detail.pick(12, 7, 6), slot::BODY);
}

/// A regular plate about (0.04, 0, z): a back of bare metal and layers of color on the front.
fn plate(b: &mut MeshBuilder, z: f32, sides: usize, turn_rad: f32, layers: &[(f32, u8)]) {
    let Some((radius, _)) = layers.first() else { return };
    let ring = |x: f32| -> Vec<Vec3> {
        (0..sides)
            .map(|i| turn_rad + std::f32::consts::TAU * i as f32 / sides as f32)
            .map(|a| v(x, radius * crate::math::cosf(a), z + radius * crate::math::sinf(a)))
            .collect()
    };
    b.loft(&[ring(0.035), ring(0.045)], slot::BACK, true);
    for (k, (r, s)) in layers.iter().enumerate() {
        disc(b, v(0.048 + 0.002 * k as f32, 0.0, z), *r, sides, turn_rad, *s);
    }
}

/// Strokes of the digits of "30", as (y, z, width, height) in units of the digit's height.
const THIRTY: [[f32; 4]; 8] = [
    [-0.45, 0.45, 0.55, 0.13],
    [-0.45, 0.0, 0.45, 0.13],
    [-0.45, -0.45, 0.55, 0.13],
    [-0.22, 0.0, 0.13, 1.0],
    [0.45, 0.45, 0.55, 0.13],
    [0.45, -0.45, 0.55, 0.13],
    [0.23, 0.0, 0.13, 1.0],
    [0.67, 0.0, 0.13, 1.0],
];

fn thirty(b: &mut MeshBuilder, z: f32, height: f32) {
    for [y, up, w, h] in THIRTY {
        // Seen from +x, y runs to the right.
        let middle = v(0.056, (y - 0.11) * height, z + up * height * 0.9);
        block(b, middle, v(0.002, w * height, h * height), slot::INK);
    }
}

/// Three white arrows that follow each other round a disc, counter-clockwise as the driver sees them.
fn circling_arrows(b: &mut MeshBuilder, z: f32) {
    let third = std::f32::consts::TAU / 3.0;
    let at = |x: f32, angle: f32, radius: f32| {
        v(x, radius * crate::math::cosf(angle), z + radius * crate::math::sinf(angle))
    };
    for k in 0..3 {
        let from = third * k as f32;
        // Seen from +x, y runs to the right, so growing angles go round counter-clockwise.
        for piece in 0..3 {
            let [a, c] = [piece, piece + 1].map(|i| from + 0.2 * third * i as f32);
            b.quad(at(0.052, a, 0.14), at(0.052, a, 0.21), at(0.052, c, 0.21), at(0.052, c, 0.14), slot::WHITE);
        }
        let (base, tip) = (from + 0.6 * third, from + 0.9 * third);
        b.triangle(at(0.052, base, 0.1), at(0.052, base, 0.25), at(0.052, tip, 0.175), slot::WHITE);
    }
}

/// Length and height of the board, height of its lower edge, and how many arrowheads it has.
const BOARD_M: [f32; 3] = [1.6, 0.5, 0.45];
const ARROWHEADS: usize = 3;

fn arrow_board(b: &mut MeshBuilder, detail: Detail) {
    let [length, height, low] = BOARD_M;
    for y in [-0.5, 0.5] {
        tube(b, (v(0.0, y, -0.3), 0.03), (v(0.0, y, low + height), 0.03), detail.pick(10, 6, 4), slot::BODY);
    }
    block(b, v(0.04, 0.0, low + height / 2.0), v(0.02, length, height), slot::BACK);
    // The front is red, with white bands that come to a point toward +y, the driver's right.
    let x = 0.052;
    b.quad(
        v(x, -length / 2.0, low),
        v(x, length / 2.0, low),
        v(x, length / 2.0, low + height),
        v(x, -length / 2.0, low + height),
        slot::RED,
    );
    let step = length / ARROWHEADS as f32;
    let (x, middle) = (0.054, low + height / 2.0);
    for k in 0..ARROWHEADS {
        let y = -length / 2.0 + step * k as f32;
        let (tail, tip) = (0.08, step / 2.0);
        for end in [low, low + height] {
            let corners =
                [v(x, y + tail, end), v(x, y + tail + tip, end), v(x, y + step, middle), v(x, y + step - tip, middle)];
            // Both halves face the driver.
            let [p, q, r, s] = corners;
            if end < middle { b.quad(p, q, r, s, slot::WHITE) } else { b.quad(s, r, q, p, slot::WHITE) }
        }
    }
}

/// Height of a lamp's post.
fn lamp_top_m(kind: PoleKind, variant: usize) -> f32 {
    let third = variant as f32 % 3.0;
    if kind == PoleKind::ArmLamp { 7.0 + 0.5 * third } else { 4.2 + 0.6 * third }
}

/// Whether a residential lamp's head is a mushroom.
fn is_mushroom(variant: usize) -> bool {
    variant.is_multiple_of(2)
}

/// Where a lamp's light comes from, and whether it shines to all sides; `None` for what is no lamp.
pub(super) fn lamp_head(kind: PoleKind, variant: usize) -> Option<(Vec3, bool)> {
    let top = lamp_top_m(kind, variant);
    match kind {
        PoleKind::Lamp if is_mushroom(variant) => Some((v(0.0, 0.0, top + 0.2), true)),
        PoleKind::Lamp => Some((v(0.2, 0.0, top - 0.02), false)),
        PoleKind::ArmLamp => Some((v(1.75, 0.0, top + 0.18), false)),
        _ => None,
    }
}

/// Draws one; variants differ in height.
pub(super) fn mesh(kind: PoleKind, variant: usize, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let b_ = &mut b;
    let right_angle = (PI / 2.0) as f32;
    match kind {
        PoleKind::Lamp => {
            let top = lamp_top_m(kind, variant);
            tube(b_, (v(0.0, 0.0, -0.4), 0.075), (v(0.0, 0.0, 1.0), 0.07), detail.pick(12, 7, 6), slot::BODY);
            post(b_, (0.055, 0.035), top, detail);
            if is_mushroom(variant) {
                // A mushroom: a shallow cap over a glass body.
                let stations = [(top - 0.05, 0.09), (top + 0.3, 0.16), (top + 0.32, 0.3), (top + 0.45, 0.1)];
                let stations = stations.map(|(z, r)| (v(0.0, 0.0, z), r));
                path_tube(b_, &stations, detail.pick(14, 8, 5), slot::ACCENT);
            } else {
                block(b_, v(0.2, 0.0, top + 0.06), v(0.62, 0.24, 0.12), slot::ACCENT);
            }
        }
        PoleKind::ArmLamp => {
            let top = lamp_top_m(kind, variant);
            let sides = detail.pick(12, 7, 6);
            tube(b_, (v(0.0, 0.0, -0.4), 0.11), (v(0.0, 0.0, 1.2), 0.1), sides, slot::BODY);
            post(b_, (0.08, 0.045), top, detail);
            path_tube(b_, &[(v(0.0, 0.0, top - 0.05), 0.04), (v(1.5, 0.0, top + 0.25), 0.03)], 6, slot::BODY);
            block(b_, v(1.75, 0.0, top + 0.26), v(0.7, 0.28, 0.13), slot::ACCENT);
        }
        PoleKind::RoundSign => {
            post(b_, (0.03, 0.03), 2.7, detail);
            plate(b_, 2.4, detail.pick(24, 14, 8), 0.0, &[(0.3, slot::RED), (0.235, slot::WHITE)]);
            if variant.is_multiple_of(2) && detail != Detail::Far {
                thirty(b_, 2.4, 0.24);
            }
        }
        PoleKind::TriangleSign => {
            post(b_, (0.03, 0.03), 2.75, detail);
            // Give way stands on its tip.
            plate(b_, 2.45, 3, -right_angle, &[(0.46, slot::RED), (0.3, slot::WHITE)]);
        }
        PoleKind::DiamondSign => {
            post(b_, (0.03, 0.03), 2.75, detail);
            plate(b_, 2.4, 4, 0.0, &[(0.42, slot::WHITE), (0.3, slot::ACCENT)]);
        }
        PoleKind::ZoneSign => {
            post(b_, (0.03, 0.03), 2.95, detail);
            plate(b_, 2.5, 4, right_angle / 2.0, &[(0.594, slot::WHITE)]);
            let z = 2.56;
            disc(b_, v(0.052, 0.0, z), 0.27, detail.pick(24, 14, 8), 0.0, slot::RED);
            disc(b_, v(0.054, 0.0, z), 0.21, detail.pick(24, 14, 8), 0.0, slot::WHITE);
            if detail != Detail::Far {
                thirty(b_, z, 0.2);
                block(b_, v(0.052, 0.0, 2.16), v(0.002, 0.5, 0.1), slot::INK);
            }
        }
        PoleKind::ParkingSign => {
            post(b_, (0.03, 0.03), 2.7, detail);
            plate(b_, 2.4, 4, right_angle / 2.0, &[(0.42, slot::WHITE), (0.39, slot::INK)]);
            if detail != Detail::Far {
                block(b_, v(0.054, -0.1, 2.4), v(0.002, 0.07, 0.4), slot::WHITE);
                block(b_, v(0.054, 0.02, 2.56), v(0.002, 0.22, 0.07), slot::WHITE);
                block(b_, v(0.054, 0.02, 2.39), v(0.002, 0.22, 0.07), slot::WHITE);
                block(b_, v(0.054, 0.12, 2.475), v(0.002, 0.07, 0.2), slot::WHITE);
            }
        }
        PoleKind::NameSign => {
            post(b_, (0.03, 0.03), 2.75, detail);
            block(b_, v(0.04, 0.42, 2.62), v(0.02, 0.8, 0.2), slot::INK);
            block(b_, v(0.42, 0.04, 2.4), v(0.8, 0.02, 0.2), slot::INK);
        }
        PoleKind::Delineator => {
            let ring = |z: f32| vec![v(-0.05, -0.06, z), v(0.05, -0.06, z), v(0.05, 0.06, z), v(-0.05, 0.06, z)];
            b.loft(&[ring(-0.3), ring(0.72)], slot::ACCENT, true);
            b.loft(&[ring(0.72), ring(0.97)], slot::DARK, true);
            b.loft(&[ring(0.97), ring(1.05)], slot::ACCENT, true);
            block(&mut b, v(0.051, 0.0, 0.85), v(0.006, 0.04, 0.18), slot::WHITE);
        }
        PoleKind::RoundaboutSign => {
            post(b_, (0.03, 0.03), 3.15, detail);
            plate(b_, 2.85, 3, -right_angle, &[(0.46, slot::RED), (0.3, slot::WHITE)]);
            plate(b_, 2.2, detail.pick(24, 14, 8), 0.0, &[(0.3, slot::INK)]);
            if detail != Detail::Far {
                circling_arrows(b_, 2.2);
            }
        }
        PoleKind::ArrowBoard => arrow_board(b_, detail),
        PoleKind::Bollard => {
            post(b_, (0.055, 0.055), 0.88, detail);
            tube(b_, (v(0.0, 0.0, 0.7), 0.058), (v(0.0, 0.0, 0.8), 0.058), detail.pick(12, 7, 4), slot::WHITE);
        }
    }
    b.build(kind.name(), CREASE_RAD)
}
