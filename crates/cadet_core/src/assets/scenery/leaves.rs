//! Leaf cards: many small leaves about a crown, shaded as if the crown were soft.

use super::draw::direction;
use super::materials::plant_slot as slot;
use super::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::Vec3;
use crate::rng::Stream;

/// A mesh of wood and leaf cards in the making.
#[derive(Debug)]
pub(super) struct Leaves {
    /// Cards are kites of two triangles; else they are single triangles.
    are_kites: bool,
    vertices: Vec<Vec3>,
    normals: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
    slots: Vec<u8>,
}

impl Leaves {
    /// For a level of detail: near by leaves are kites, folded along their longer diagonals; farther off nobody tells them
    /// from triangles.
    pub fn new(detail: Detail) -> Self {
        let are_kites = detail == Detail::Near;
        Self { are_kites, vertices: Vec::new(), normals: Vec::new(), faces: Vec::new(), slots: Vec::new() }
    }

    /// Adds a card about `middle` that faces about `facing`, its area about `size`^2; its shading normal is bent to
    /// `outward`.
    pub fn card(&mut self, s: &mut Stream, middle: Vec3, facing: Vec3, outward: Vec3, size: f32) {
        self.card_within(s, middle, facing, outward, size, (middle, f32::INFINITY));
    }

    /// Adds a card whose corners keep within a ball (center, radius): large ones do not widen the crown.
    pub fn card_within(
        &mut self,
        s: &mut Stream,
        middle: Vec3,
        facing: Vec3,
        outward: Vec3,
        size: f32,
        (center, radius): (Vec3, f32),
    ) {
        let side = direction(s).cross(facing).normalize_or(Vec3::X);
        let up = facing.cross(side);
        // From squat to slender at the same area.
        let stretch = s.range(0.85, 1.35) as f32;
        let (skew, fold) = (s.range(-0.5, 0.5) as f32, s.range(-0.8, 0.8) as f32);
        let corners = if self.are_kites {
            kite(side, up, facing * fold, [size / stretch, size * stretch], skew)
        } else {
            triangle(side, up, [size / stretch, size * stretch], skew)
        };
        let corners = corners.map(|from_middle| {
            let p = middle + from_middle;
            if radius.is_finite() { center + (p - center).clamp_length_max(radius) } else { p }
        });
        let normal = (outward + direction(s) * 0.45).normalize_or(Vec3::Z);
        // Counter-clockwise towards the shading normal: a card has two sides, this one counts as its front.
        let flip = (corners[2] - corners[0]).cross(corners[3] - corners[1]).dot(normal) < 0.0;
        let base = self.vertices.len() as u32;
        let fan: [[u32; 3]; 2] = if flip { [[0, 2, 1], [0, 3, 2]] } else { [[0, 1, 2], [0, 2, 3]] };
        let slot = match s.weighted(&[0.55, 0.25, 0.20]) {
            0 => slot::LEAF,
            1 => slot::LIGHT_LEAF,
            _ => slot::DARK_LEAF,
        };
        // The first and the last corner of a triangle are one.
        let (corners, fan) = if self.are_kites { (&corners[..], &fan[..]) } else { (&corners[..3], &fan[..1]) };
        self.faces.extend(fan.iter().map(|f| f.map(|i| base + i)));
        self.vertices.extend(corners);
        self.normals.extend(corners.iter().map(|_| normal));
        self.slots.extend(fan.iter().map(|_| slot));
    }

    /// Joins the cards with what a builder holds (wood, a hedge's core), if it holds anything.
    pub fn build(self, name: &str, wood: &MeshBuilder) -> Mesh {
        let Self { mut vertices, mut normals, mut faces, mut slots, .. } = self;
        if wood.num_faces() > 0 {
            let core = wood.build(name, 1.2);
            let base = vertices.len() as u32;
            vertices.extend(core.vertices);
            normals.extend(core.normals);
            slots.extend(core.slots);
            faces.extend(core.faces.iter().map(|f| f.map(|i| i + base)));
        }
        Mesh::new(name, vertices, normals, faces, slots).expect("an asset's mesh is valid").in_cluster_order()
    }
}

/// The corners of a leaf of two triangles about its middle, folded along its longer diagonal. `size`: along `side` and
/// `up`; their product is the leaf's area.
fn kite(side: Vec3, up: Vec3, fold: Vec3, [across, along]: [f32; 2], skew: f32) -> [Vec3; 4] {
    let (w, h) = (across * std::f32::consts::FRAC_1_SQRT_2, along * std::f32::consts::FRAC_1_SQRT_2);
    let bent = fold * w;
    [-up * h, side * w + up * (h * skew) + bent, up * h, bent - side * w - up * (h * skew)]
}

/// The corners of a leaf of one triangle about its middle, as of a [`kite`]; the last is the first.
fn triangle(side: Vec3, up: Vec3, [across, along]: [f32; 2], skew: f32) -> [Vec3; 4] {
    // Of an equilateral one: 3 sqrt(3) / 4 r^2 is its area, r is from its middle to its corners.
    const CORNER: f32 = 0.877_383;
    const HALF_SIDE: f32 = 0.759_836;
    let foot = -up * (0.5 * CORNER * along);
    let (to_side, tip) = (side * (HALF_SIDE * across), up * (CORNER * along) + side * (0.5 * skew * across));
    [foot - to_side, foot + to_side, tip, foot - to_side]
}
