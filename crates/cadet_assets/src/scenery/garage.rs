//! Garages: one or two doors under a flat roof.

use super::draw::CREASE_RAD;
use super::facade::{Filling, Opening, WallShape, wall};
use super::materials::house_slot as slot;
use super::wall_plane::WallPlane;
use super::{Detail, Mesh, roof};
use cadet_base::geometry::MeshBuilder;

/// Depth along x.
pub(super) const DEPTH_M: f32 = 6.0;
/// Width of one bay along y.
pub(super) const BAY_M: f32 = 3.0;
/// Height without the roof's edge.
pub(super) const HEIGHT_M: f32 = 2.45;

/// Draws a garage of `bays` bays; the doors face +x.
pub(super) fn mesh(bays: usize, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let width_m = BAY_M * bays as f32;
    let doors: Vec<Opening> = (0..bays)
        .map(|k| BAY_M * (k as f32 + 0.5))
        .map(|u| Opening { rect: [u - 1.2, u + 1.2, 0.02, 2.12], filling: Filling::GarageDoor })
        .collect();
    for ((plane, length_m), openings) in WallPlane::around(DEPTH_M, width_m).iter().zip([&doors[..], &[], &[], &[]]) {
        wall(&mut b, plane, &WallShape::level(*length_m, -1.0, HEIGHT_M, slot::WALL), openings, detail);
    }
    roof::flat(&mut b, DEPTH_M / 2.0, width_m / 2.0, HEIGHT_M - 0.12);
    b.build("garage", CREASE_RAD)
}
