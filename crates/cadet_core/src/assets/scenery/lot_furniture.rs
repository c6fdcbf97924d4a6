//! What stands on lots: curbed islands, shelters for trolleys, tall lamps, pylons, containers, goods.

use std::sync::Arc;

use super::draw::{CREASE_RAD, block, tube};
use super::materials::furniture_palette;
use super::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::material::{Material, Palette, Pattern, Semantic};
use crate::math::Vec3;
use crate::rng::Stream;

/// Slots after those of furniture: soil or grass, and galvanized wire.
const SOIL: u8 = 7;
const BODY: u8 = super::materials::furniture_slot::BODY;
const ACCENT: u8 = super::materials::furniture_slot::ACCENT;
const DARK: u8 = super::materials::furniture_slot::DARK;
const BACK: u8 = super::materials::furniture_slot::BACK;

/// What it is; it looks along +x.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LotFurniture {
    /// A bed between two bays, edged with curb stones: as long as a bay along x.
    Island,
    /// A roofed rack of shopping trolleys in a bay, open toward +x.
    TrolleyShelter,
    /// A mast of 9 m with two heads along x.
    TallLamp,
    /// A company's tall sign.
    Pylon,
    /// A shipping container of 20 feet, its doors at +x.
    Container,
    /// Crates on pallets, wrapped or not.
    Crates,
    /// Steel profiles on a rack, along y.
    Profiles,
}

impl LotFurniture {
    /// Every kind.
    pub const ALL: [Self; 7] = [
        Self::Island,
        Self::TrolleyShelter,
        Self::TallLamp,
        Self::Pylon,
        Self::Container,
        Self::Crates,
        Self::Profiles,
    ];

    /// A short name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Island => "island",
            Self::TrolleyShelter => "trolley-shelter",
            Self::TallLamp => "tall-lamp",
            Self::Pylon => "pylon",
            Self::Container => "container",
            Self::Crates => "crates",
            Self::Profiles => "profiles",
        }
    }

    /// Where its levels of detail end, meters from the ego.
    pub(super) fn limits_m(self) -> [f32; 3] {
        match self {
            Self::TallLamp | Self::Pylon | Self::Container => [30.0, 70.0, 260.0],
            _ => [22.0, 50.0, 160.0],
        }
    }

    /// Draws it.
    pub(super) fn mesh(self, detail: Detail) -> Mesh {
        let mut b = MeshBuilder::new();
        match self {
            Self::Island => island(&mut b),
            Self::TrolleyShelter => trolley_shelter(&mut b, detail),
            Self::TallLamp => tall_lamp(&mut b, detail),
            Self::Pylon => pylon(&mut b, detail),
            Self::Container => container(&mut b, detail),
            Self::Crates => crates(&mut b, detail),
            Self::Profiles => profiles(&mut b, detail),
        }
        b.build(self.name(), CREASE_RAD)
    }
}

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

fn island(b: &mut MeshBuilder) {
    let (x, y) = (2.35, 1.05);
    b.cuboid(v(-x, -y, -0.5), v(x, y, 0.11), BACK);
    b.cuboid(v(-x + 0.13, -y + 0.13, -0.1), v(x - 0.13, y - 0.13, 0.125), SOIL);
}

fn trolley_shelter(b: &mut MeshBuilder, detail: Detail) {
    for (x, y) in [(-2.2, -1.0), (-2.2, 1.0), (2.2, -1.0), (2.2, 1.0)] {
        tube(b, (v(x, y, -0.3), 0.04), (v(x, y, 2.3), 0.04), detail.pick(8, 5, 4), BODY);
    }
    block(b, v(0.0, 0.0, 2.36), v(4.9, 2.4, 0.12), BODY);
    block(b, v(-2.2, 0.0, 1.2), v(0.03, 2.0, 1.7), BACK);
    if detail == Detail::Far {
        return block(b, v(-0.4, 0.0, 0.6), v(3.4, 1.3, 0.9), BACK);
    }
    for side in [-1.0_f32, 1.0] {
        block(b, v(0.0, side * 0.95, 0.75), v(4.2, 0.04, 0.06), BODY);
        // A row of trolleys pushed into each other: baskets, handles, wheels.
        let y = side * 0.45;
        for k in 0..9 {
            let x = -1.7 + 0.34 * k as f32;
            block(b, v(x, y, 0.78), v(0.03, 0.5, 0.42), BACK);
            block(b, v(x + 0.3, y, 1.02), v(0.05, 0.54, 0.05), ACCENT);
            block(b, v(x + 0.15, y - 0.24, 0.3), v(0.05, 0.03, 0.6), BACK);
            block(b, v(x + 0.15, y + 0.24, 0.3), v(0.05, 0.03, 0.6), BACK);
        }
        block(b, v(-0.3, y, 0.58), v(2.9, 0.44, 0.03), BACK);
    }
}

fn tall_lamp(b: &mut MeshBuilder, detail: Detail) {
    let (sides, least) = (detail.pick(12, 7, 6), detail.pick(0.0, 0.0, 0.05_f32));
    tube(b, (v(0.0, 0.0, -0.5), 0.11), (v(0.0, 0.0, 9.0), least.max(0.06)), sides, BODY);
    for side in [-1.0_f32, 1.0] {
        block(b, v(side * 0.55, 0.0, 9.02), v(1.0, 0.07, 0.07), BODY);
        block(b, v(side * 1.15, 0.0, 9.0), v(0.6, 0.3, 0.12), ACCENT);
    }
}

fn pylon(b: &mut MeshBuilder, detail: Detail) {
    for y in [-0.75_f32, 0.75] {
        block(b, v(0.0, y, 2.4), v(0.16, 0.16, 5.8), BACK);
    }
    for (k, (z, h)) in [(4.6, 1.5), (3.3, 0.8), (2.4, 0.8)].into_iter().enumerate() {
        block(b, v(0.0, 0.0, z), v(0.24, 2.3, h), if k == 0 { ACCENT } else { BACK });
        if detail != Detail::Far {
            for x in [-0.13_f32, 0.13] {
                let size = v(0.012, 2.1 - 0.5 * k as f32, h * 0.4);
                block(b, v(x, 0.1 * k as f32, z), size, if k == 0 { BACK } else { DARK });
            }
        }
    }
}

fn container(b: &mut MeshBuilder, detail: Detail) {
    let (x, y, h) = (3.03, 1.22, 2.59);
    b.cuboid(v(-x + 0.05, -y + 0.05, 0.02), v(x - 0.05, y - 0.05, h - 0.03), BODY);
    for (z, t) in [(0.08, 0.16), (h - 0.06, 0.12)] {
        block(b, v(0.0, 0.0, z), v(2.0 * x, 2.0 * y, t), BODY);
    }
    for (sx, sy) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        block(b, v(sx * (x - 0.07), sy * (y - 0.07), h / 2.0), v(0.14, 0.14, h), BODY);
    }
    if detail == Detail::Near {
        let count = 20;
        for k in 0..count {
            let at = (2.0 * x - 0.3) * ((k as f32 + 0.5) / count as f32 - 0.5);
            for side in [-1.0_f32, 1.0] {
                block(b, v(at, side * (y - 0.05), h / 2.0), v(0.15, 0.05, h - 0.3), BODY);
            }
        }
    }
    if detail != Detail::Far {
        for at in [-0.8_f32, -0.35, 0.35, 0.8] {
            block(b, v(x - 0.03, at, h / 2.0), v(0.05, 0.04, h - 0.3), BACK);
        }
        block(b, v(x - 0.045, 0.0, h / 2.0), v(0.02, 0.03, h - 0.3), DARK);
    }
}

fn crates(b: &mut MeshBuilder, detail: Detail) {
    let heights = [1.9, 1.3, 0.75, 1.5, 0.95, 1.7];
    for (k, h) in heights.into_iter().enumerate() {
        let (x, y) = (0.95 * (k % 2) as f32 - 0.475, 1.3 * ((k / 2) as f32 - 1.0));
        block(b, v(x, y, 0.075), v(0.8, 1.2, 0.15), SOIL);
        let color = [ACCENT, BACK, BODY][k % 3];
        block(b, v(x, y, 0.15 + h / 2.0), v(0.76, 1.14, h), color);
        if detail == Detail::Near {
            block(b, v(x, y, 0.15 + h * 0.45), v(0.775, 1.155, 0.04), DARK);
        }
    }
}

fn profiles(b: &mut MeshBuilder, detail: Detail) {
    for y in [-2.0_f32, 0.0, 2.0] {
        block(b, v(-0.6, y, 1.2), v(0.14, 0.14, 2.5), BODY);
        for z in [0.25_f32, 0.95, 1.65] {
            block(b, v(0.0, y, z), v(1.3, 0.1, 0.1), BODY);
        }
    }
    let count = detail.pick(5, 3, 1);
    for z in [0.3_f32, 1.0, 1.7] {
        for k in 0..count {
            let w = 1.0 / count as f32;
            let x = -0.45 + w * (k as f32 + 0.5);
            let size = v(0.7 * w, 5.6 - 0.3 * k as f32, 0.12);
            block(b, v(x, 0.0, z + 0.07), size, if k % 2 == 0 { BACK } else { ACCENT });
        }
    }
}

/// The colors of one piece.
#[must_use]
pub fn lot_furniture_palette(kind: LotFurniture, s: &mut Stream) -> Arc<Palette> {
    const PAINTS: [[f32; 3]; 6] = [
        [0.34, 0.08, 0.05],
        [0.04, 0.10, 0.26],
        [0.06, 0.17, 0.10],
        [0.42, 0.42, 0.40],
        [0.45, 0.26, 0.04],
        [0.24, 0.12, 0.07],
    ];
    let (semantic, body) = match kind {
        LotFurniture::Island => (Semantic::Sidewalk, [0.3; 3]),
        LotFurniture::TallLamp => (Semantic::Pole, [0.30, 0.31, 0.32]),
        LotFurniture::TrolleyShelter => (Semantic::Furniture, [0.16, 0.17, 0.18]),
        _ => (Semantic::Furniture, PAINTS[s.below(PAINTS.len())]),
    };
    let accent = if kind == LotFurniture::TallLamp { [0.46, 0.46, 0.45] } else { PAINTS[s.below(PAINTS.len())] };
    let mut materials = furniture_palette(s, semantic, body, accent).materials().to_vec();
    let soil = if kind == LotFurniture::Island {
        Material::matt(Semantic::Terrain, [0.075, 0.10, 0.042], Pattern::Grass, 0.42)
    } else {
        Material::matt(Semantic::Furniture, [0.22, 0.15, 0.09], Pattern::Wood, 0.45)
    };
    materials.push(soil);
    Arc::new(Palette::new(materials))
}

#[cfg(test)]
mod tests {
    use super::super::{OVERHEAD_M, lot_furniture};
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn pieces_are_closed_and_stand_in_the_ground_within_their_footprint() {
        for kind in LotFurniture::ALL {
            let model = lot_furniture(kind);
            for (_, mesh) in &model.shape.levels {
                let place = |i: u32| mesh.vertices[i as usize].to_array().map(|c| (c * 2e4).round() as i64);
                let mut passed: BTreeMap<([i64; 3], [i64; 3]), i32> = BTreeMap::new();
                for face in &mesh.faces {
                    for k in 0..3 {
                        let (p, q) = (place(face[k]), place(face[(k + 1) % 3]));
                        *passed.entry((p.min(q), p.max(q))).or_default() += if p < q { 1 } else { -1 };
                    }
                }
                assert!(passed.values().all(|n| *n == 0), "{}: open", model.name);
                assert!(mesh.bounds.min.z < 0.03, "{} floats at {}", model.name, mesh.bounds.min.z);
                for p in mesh.vertices.iter().filter(|p| f64::from(p.z) < OVERHEAD_M) {
                    let at = p.truncate().as_dvec2();
                    let over = (at - model.footprint_max).max(model.footprint_min - at).max_element();
                    assert!(over < 0.05, "{}: {p} reaches {over} m out", model.name);
                }
            }
        }
    }
}
