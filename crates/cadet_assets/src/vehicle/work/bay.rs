//! The room behind a cab.

use super::super::surface::Surface;
use cadet_base::math::Vec3;

/// The room that a load takes.
#[derive(Clone, Copy)]
pub(super) struct Room {
    pub front_x: f32,
    pub rear_x: f32,
    pub half_y: f32,
    pub floor_z: f32,
    pub top_z: f32,
}

/// A block between two x, as wide as the room less an inset.
pub(super) fn block(surface: &mut Surface, r: &Room, x: (f32, f32), inset_m: f32, z: (f32, f32), slot: u8) {
    let w = r.half_y - inset_m;
    surface.builder.cuboid(Vec3::new(x.0, -w, z.0), Vec3::new(x.1, w, z.1), slot);
}
