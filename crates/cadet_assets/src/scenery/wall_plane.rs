//! A wall as a plane to draw on.

use cadet_base::geometry::MeshBuilder;
use cadet_base::math::Vec3;

/// The plane of a wall: `u` runs to the right seen from outside, z goes up, `u` x z points outside.
#[derive(Debug, Clone, Copy)]
pub(super) struct WallPlane {
    pub origin: Vec3,
    pub u: Vec3,
}

impl WallPlane {
    /// The point at (u, v) on the wall, `depth_m` behind its face.
    pub(super) fn at(&self, u: f32, v: f32, depth_m: f32) -> Vec3 {
        self.origin + self.u * u + Vec3::Z * v - self.u.cross(Vec3::Z) * depth_m
    }

    /// Away from the wall.
    pub(super) fn out(&self) -> Vec3 {
        self.u.cross(Vec3::Z)
    }

    /// A rectangle that faces outside.
    pub(super) fn rect(&self, b: &mut MeshBuilder, [u0, u1, v0, v1]: [f32; 4], depth_m: f32, slot: u8) {
        if u1 > u0 && v1 > v0 {
            b.quad(
                self.at(u0, v0, depth_m),
                self.at(u1, v0, depth_m),
                self.at(u1, v1, depth_m),
                self.at(u0, v1, depth_m),
                slot,
            );
        }
    }

    /// The four sides of a rectangular hole, seen from within it, from depth `d0_m` to `d1_m`.
    pub(super) fn reveal(&self, b: &mut MeshBuilder, [u0, u1, v0, v1]: [f32; 4], d0_m: f32, d1_m: f32, slot: u8) {
        let corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)];
        for i in 0..4 {
            let ((ua, va), (ub, vb)) = (corners[i], corners[(i + 1) % 4]);
            b.quad(self.at(ua, va, d0_m), self.at(ub, vb, d0_m), self.at(ub, vb, d1_m), self.at(ua, va, d1_m), slot);
        }
    }

    /// A box on the wall, from depth `back_m` (positive inside) to `front_m` (negative outside).
    pub(super) fn block(&self, b: &mut MeshBuilder, [u0, u1, v0, v1]: [f32; 4], front_m: f32, back_m: f32, slot: u8) {
        self.rect(b, [u0, u1, v0, v1], front_m, slot);
        self.ring(b, [u0, u1, v0, v1], front_m, back_m, slot);
    }

    /// The four sides of a box, without its front.
    pub(super) fn ring(&self, b: &mut MeshBuilder, [u0, u1, v0, v1]: [f32; 4], front_m: f32, back_m: f32, slot: u8) {
        let corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)];
        for i in 0..4 {
            let ((ua, va), (ub, vb)) = (corners[i], corners[(i + 1) % 4]);
            b.quad(
                self.at(ua, va, back_m),
                self.at(ub, vb, back_m),
                self.at(ub, vb, front_m),
                self.at(ua, va, front_m),
                slot,
            );
        }
    }
}
