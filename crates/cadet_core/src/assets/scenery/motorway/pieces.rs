//! Pieces of barriers and noise walls along +x, their front toward -y.

use super::super::draw::CREASE_RAD;
use super::super::{Detail, Mesh};
use super::{MOTORWAY_PIECE_M, MotorwayKind, slot};
use crate::geometry::MeshBuilder;
use crate::math::Vec3;

const LENGTH: f32 = MOTORWAY_PIECE_M as f32;
/// Half of a step barrier's section: half width and height.
const CONCRETE: [(f32, f32); 5] = [(0.34, -0.3), (0.34, 0.08), (0.22, 0.30), (0.13, 0.86), (0.11, 0.90)];
/// A sheet of two waves, and its height over the ground.
const SHEET: [(f32, f32); 7] =
    [(0.0, 0.0), (-0.08, 0.04), (-0.08, 0.12), (-0.01, 0.155), (-0.08, 0.19), (-0.08, 0.27), (0.0, 0.31)];
const SHEET_LOW: f32 = 0.44;
const POST_EVERY: f32 = 2.0;
/// Heights of noise walls, and between their posts.
const WALLS: [f32; 6] = [2.8, 2.4, 3.6, 4.0, 3.2, 2.6];
const BAY: f32 = LENGTH / 2.0;

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

pub(super) fn mesh(kind: MotorwayKind, variant: usize, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    match kind {
        MotorwayKind::ConcreteBarrier => concrete(&mut b),
        MotorwayKind::NoiseWall => noise_wall(&mut b, variant, detail),
        MotorwayKind::DoubleRail => {
            sheet(&mut b, 1.0, -0.06, detail);
            sheet(&mut b, -1.0, 0.06, detail);
            posts(&mut b, (-0.05, 0.05), detail);
        }
        _ => {
            sheet(&mut b, 1.0, 0.0, detail);
            posts(&mut b, (0.012, 0.09), detail);
        }
    }
    b.build(kind.name(), CREASE_RAD)
}

fn along(b: &mut MeshBuilder, outline: &[(f32, f32)], slot: u8) {
    let rings = [0.0, LENGTH].map(|x| outline.iter().map(|(y, z)| v(x, *y, *z)).collect::<Vec<_>>());
    b.loft(&rings, slot, true);
}

fn concrete(b: &mut MeshBuilder) {
    let right = CONCRETE.iter().map(|(y, z)| (*y, *z));
    let left = CONCRETE.iter().rev().map(|(y, z)| (-*y, *z));
    along(b, &right.chain(left).collect::<Vec<_>>(), slot::CONCRETE);
}

/// A beam that faces -y for `side` 1, +y for -1, its back at `y`.
fn sheet(b: &mut MeshBuilder, side: f32, y: f32, detail: Detail) {
    let section: Vec<(f32, f32)> = match detail {
        Detail::Far => [(-0.07, 0.0), (0.01, 0.0), (0.01, 0.31), (-0.07, 0.31)].to_vec(),
        _ => SHEET.iter().copied().chain([(0.012, 0.31), (0.012, 0.0)]).rev().collect(),
    };
    let mut outline: Vec<(f32, f32)> = section.iter().map(|(d, z)| (y + side * d, SHEET_LOW + z)).collect();
    if side < 0.0 {
        outline.reverse();
    }
    along(b, &outline, slot::STEEL);
}

fn posts(b: &mut MeshBuilder, (y0, y1): (f32, f32), detail: Detail) {
    let count = detail.pick(LENGTH / POST_EVERY, LENGTH / POST_EVERY, 1.0) as usize;
    for k in 0..count.max(1) {
        let x = LENGTH * (k as f32 + 0.5) / count.max(1) as f32;
        b.cuboid(v(x - 0.05, y0, -0.4), v(x + 0.05, y1, SHEET_LOW + 0.29), slot::STEEL);
    }
}

fn noise_wall(b: &mut MeshBuilder, variant: usize, detail: Detail) {
    let top = WALLS[variant % WALLS.len()];
    for bay in 0..2 {
        let x = BAY * bay as f32;
        b.cuboid(v(x - 0.09, -0.1, -0.6), v(x + 0.09, 0.1, top + 0.04), slot::STEEL);
        // A plinth of concrete, and panels half a meter high with joints between.
        b.cuboid(v(x + 0.09, -0.09, -0.6), v(x + BAY - 0.09, 0.09, 0.4), slot::CONCRETE);
        let rows = if detail == Detail::Far { 1 } else { ((top - 0.4) / 0.5).round() as usize };
        let height = (top - 0.4) / rows as f32;
        for row in 0..rows {
            let z = 0.4 + height * row as f32;
            let recess = if detail == Detail::Near { 0.02 } else { 0.006 };
            b.cuboid(v(x + 0.09, -0.06, z), v(x + BAY - 0.09, 0.06, z + height - recess), slot::PANEL);
        }
    }
}
