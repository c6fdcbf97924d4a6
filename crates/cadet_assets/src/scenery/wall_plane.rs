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
    /// The walls of a box about the origin, counter-clockwise from the front at +x, and their lengths.
    pub(super) fn around(depth_m: f32, width_m: f32) -> [(Self, f32); 4] {
        let (x, y) = (depth_m / 2.0, width_m / 2.0);
        let wall = |x: f32, y: f32, u: Vec3, length_m: f32| (Self { origin: Vec3::new(x, y, 0.0), u }, length_m);
        [
            wall(x, -y, Vec3::Y, width_m),
            wall(x, y, -Vec3::X, depth_m),
            wall(-x, y, -Vec3::Y, width_m),
            wall(-x, -y, Vec3::X, depth_m),
        ]
    }
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
            let [p, q, r, s] = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)].map(|(u, v)| self.at(u, v, depth_m));
            b.quad(p, q, r, s, slot);
        }
    }

    /// The four sides of a rectangular hole, seen from within it, from depth `d0_m` to `d1_m`; of a box, seen from
    /// outside, where that is less.
    pub(super) fn sides(&self, b: &mut MeshBuilder, [u0, u1, v0, v1]: [f32; 4], d0_m: f32, d1_m: f32, slot: u8) {
        let corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)];
        for i in 0..4 {
            let ((ua, va), (ub, vb)) = (corners[i], corners[(i + 1) % 4]);
            b.quad(self.at(ua, va, d0_m), self.at(ub, vb, d0_m), self.at(ub, vb, d1_m), self.at(ua, va, d1_m), slot);
        }
    }

    /// A box on the wall, from depth `back_m` (positive inside) to `front_m` (negative outside).
    pub(super) fn block(&self, b: &mut MeshBuilder, rect: [f32; 4], front_m: f32, back_m: f32, slot: u8) {
        self.rect(b, rect, front_m, slot);
        self.sides(b, rect, back_m, front_m, slot);
    }
}
