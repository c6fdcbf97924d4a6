//! Parts mounted on large buildings: docks, vents, skylights.

use super::super::city::city_slot;
use super::super::draw::range;
use super::super::materials::house_slot as slot;
use super::super::wall_plane::WallPlane;
use super::HallDesign;
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::Vec3;
use cadet_base::rng::Stream;

/// The bumpers and the rain shield about a dock's gate [u0, u1, v0, v1].
pub(super) fn dock(b: &mut MeshBuilder, plane: &WallPlane, [u0, u1, v0, v1]: [f32; 4]) {
    for u in [u0 - 0.1, u1 - 0.2] {
        plane.block(b, [u, u + 0.3, v0 - 0.75, v0 - 0.1], -0.22, 0.0, city_slot::LETTER);
    }
    for [a, z] in [[u0 - 0.45, u0 - 0.05], [u1 + 0.05, u1 + 0.45]] {
        plane.block(b, [a, z, v0, v1 + 0.1], -0.55, 0.0, city_slot::BASE);
    }
    plane.block(b, [u0 - 0.45, u1 + 0.45, v1 + 0.12, v1 + 0.5], -0.6, 0.0, city_slot::BASE);
}

/// Vents and skylights.
pub(super) fn on_roof(b: &mut MeshBuilder, d: &HallDesign) {
    if d.has_gables {
        return;
    }
    let s = &mut Stream::from_seed("hall roof", d.seed);
    for _ in 0..2 + s.below(4) {
        let size = Vec3::new(range(s, 1.0, 2.6), range(s, 1.0, 3.2), range(s, 0.7, 1.8));
        let (x, y) = (0.32 * d.depth_m, 0.4 * d.width_m);
        let middle = Vec3::new(range(s, -x, x), range(s, -y, y), d.eaves_m + size.z / 2.0);
        b.block(middle, size, slot::METAL);
    }
}
