//! Garages: one or two doors under a flat roof.

use super::draw::CREASE_RAD;
use super::facade::{Filling, Opening, WallShape, wall};
use super::materials::house_slot as slot;
use super::wall_plane::WallPlane;
use super::{Detail, Mesh, roof};
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::Vec3;

/// Depth along x.
pub(super) const DEPTH_M: f32 = 6.0;
/// Width of one bay along y.
pub(super) const BAY_M: f32 = 3.0;
/// Height without the roof's edge.
pub(super) const HEIGHT_M: f32 = 2.45;

/// Draws a garage of `bays` bays; the doors face +x.
pub(super) fn mesh(bays: usize, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let (x, y) = (DEPTH_M / 2.0, BAY_M * bays as f32 / 2.0);
    let doors: Vec<Opening> = (0..bays)
        .map(|k| BAY_M * (k as f32 + 0.5))
        .map(|u| Opening { rect: [u - 1.2, u + 1.2, 0.02, 2.12], filling: Filling::GarageDoor })
        .collect();
    let sides = [
        (Vec3::new(x, -y, 0.0), Vec3::Y, 2.0 * y, doors.as_slice()),
        (Vec3::new(x, y, 0.0), -Vec3::X, DEPTH_M, &[]),
        (Vec3::new(-x, y, 0.0), -Vec3::Y, 2.0 * y, &[]),
        (Vec3::new(-x, -y, 0.0), Vec3::X, DEPTH_M, &[]),
    ];
    for (origin, u, width_m, openings) in sides {
        let shape = WallShape { width_m, bottom_m: -1.0, eaves_m: HEIGHT_M, apex_m: HEIGHT_M, face: slot::WALL };
        wall(&mut b, &WallPlane { origin, u }, &shape, openings, detail);
    }
    roof::flat(&mut b, x, y, HEIGHT_M - 0.12);
    b.build("garage", CREASE_RAD)
}
