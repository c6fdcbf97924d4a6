//! Leaf cards: many small flat leaves about a crown, shaded as if the crown were soft.

use super::Mesh;
use super::draw::direction;
use super::materials::plant_slot as slot;
use cadet_base::geometry::{IndexedFaces, MeshBuilder};
use cadet_base::math::Vec3;
use cadet_base::rng::Stream;

/// A card is moved inwards until so much of its half diagonal lies within its ball whichever way it is turned; what still
/// reaches beyond is shrunk. So crowns keep their leaf area.
const KEPT_WITHIN: f32 = 0.7;

/// Neither deep in a crown nor at its top.
const MIDDLING: f32 = 0.5;

/// A mesh of wood and leaf cards in the making.
#[derive(Debug, Default)]
pub(crate) struct Leaves(IndexedFaces);

impl Leaves {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.faces.is_empty()
    }

    /// Adds a card: a flat kite about `middle`, its area about `size_m`^2, that faces `facing`; its shading normal is bent
    /// to `outward`.
    pub fn card(&mut self, s: &mut Stream, middle: Vec3, facing: Vec3, outward: Vec3, size_m: f32) {
        self.card_within(s, middle, facing, outward, size_m, (middle, f32::INFINITY), MIDDLING);
    }

    /// Adds a card that keeps within a ball (center, radius), moved inwards and shrunk: large ones do not widen the crown.
    /// `openness_share` from 0, deep in the crown, to 1, at its top: leaves in the shade of others are darker, and so is
    /// what they let through.
    pub fn card_within(
        &mut self,
        s: &mut Stream,
        middle: Vec3,
        facing: Vec3,
        outward: Vec3,
        size_m: f32,
        (center, radius): (Vec3, f32),
        openness_share: f32,
    ) {
        let side = direction(s).cross(facing).normalize_or(Vec3::X);
        let up = facing.cross(side);
        // From squat to slender at the same area.
        let stretch = s.range(0.85, 1.35) as f32 * std::f32::consts::FRAC_1_SQRT_2;
        let (w, h) = (0.5 * size_m / stretch, size_m * stretch);
        let skew = s.range(-0.5, 0.5) as f32;
        let to_corners = [up * -h, side * w + up * (h * skew), up * h, side * -w - up * (h * skew)];
        let from_center = (middle - center).clamp_length_max((radius - KEPT_WITHIN * w.max(h)).max(0.0));
        let scale = to_corners.into_iter().map(|p| share_within(from_center, p, radius)).fold(1.0, f32::min);
        let corners = to_corners.map(|p| center + from_center + p * scale);
        let normal = (outward + direction(s) * 0.45).normalize_or(Vec3::Z);
        // Counter-clockwise toward the shading normal: a card has two sides, this one counts as its front.
        let flip = (corners[2] - corners[0]).cross(corners[3] - corners[1]).dot(normal) < 0.0;
        let base = self.0.vertices.len() as u32;
        self.0
            .faces
            .extend(if flip { [[0, 2, 1], [0, 3, 2]] } else { [[0, 1, 2], [0, 2, 3]] }.map(|f| f.map(|i| base + i)));
        self.0.vertices.extend(corners);
        self.0.normals.extend([normal; 4]);
        let (light, dark) =
            (f64::from(0.5 * openness_share), f64::from(0.8 * (1.0 - openness_share) * (1.0 - openness_share)));
        let slot = match s.weighted(&[1.0 - light - dark, light, dark]) {
            0 => slot::LEAF,
            1 => slot::LIGHT_LEAF,
            _ => slot::DARK_LEAF,
        };
        self.0.slots.extend([slot; 2]);
    }

    /// Adds a blade: a slender triangle from its foot to its tip, `width_m` wide at the foot, with the normal `outward`.
    pub fn blade(&mut self, s: &mut Stream, foot: Vec3, tip: Vec3, width_m: f32, outward: Vec3) {
        let side = (tip - foot).cross(direction(s)).normalize_or(Vec3::X) * (width_m / 2.0);
        let corners = [foot - side, foot + side, tip];
        let normal = outward.normalize_or(Vec3::Z);
        let is_front = (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(normal) >= 0.0;
        let base = self.0.vertices.len() as u32;
        self.0.faces.push(if is_front { [0, 1, 2] } else { [0, 2, 1] }.map(|i| base + i));
        self.0.vertices.extend(corners);
        self.0.normals.extend([normal; 3]);
        self.0.slots.push([slot::LEAF, slot::LIGHT_LEAF, slot::DARK_LEAF][s.weighted(&[0.5, 0.3, 0.2])]);
    }

    /// Joins the cards with what a builder holds (wood, a hedge's core), if it holds anything.
    pub fn build(self, name: &str, wood: &MeshBuilder) -> Mesh {
        let mut all = self.0;
        if wood.num_faces() > 0 {
            all.extend(wood.indexed(1.2));
        }
        Mesh::new(name, &all).expect("an asset's mesh is valid")
    }
}

/// The share of a way that leads from a point in a ball about the origin to its surface, at most 1.
fn share_within(from: Vec3, way: Vec3, radius: f32) -> f32 {
    let (along, length2) = (from.dot(way), way.length_squared());
    let beyond = (from + way).length_squared() - radius * radius;
    if beyond <= 0.0 {
        return 1.0;
    }
    // |from + share * way| = radius
    let inside = (radius * radius - from.length_squared()).max(0.0);
    ((along * along + length2 * inside).sqrt() - along) / length2
}
