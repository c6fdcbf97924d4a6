//! The second step of a scan: the surface behind a hit.

use super::casting::Casting;
use super::divergence::SubBeam;
use super::ground_texture;
use super::returns::Surface;
use crate::math::DVec3;
use crate::sense::NO_HIT;

/// Looks surfaces up. Neighbors often meet the same face, so the last one is remembered.
pub(super) struct Surfaces<'a, C> {
    casting: &'a C,
    last: (u32, u32),
    normal_world: DVec3,
}

impl<'a, C: Casting> Surfaces<'a, C> {
    pub(super) fn new(casting: &'a C) -> Self {
        Self { casting, last: (NO_HIT, NO_HIT), normal_world: DVec3::ZERO }
    }

    /// The surface that a beam of a column met in a direction.
    #[inline]
    pub(super) fn at(
        &mut self,
        hit: SubBeam,
        column: usize,
        origin_velo: DVec3,
        direction_velo: DVec3,
    ) -> Option<Surface<'a>> {
        if !hit.is_hit() {
            return None;
        }
        let (instance, face) = (hit.instance, hit.face);
        let posed = &self.casting.scene().instances[instance as usize];
        if self.last != (instance, face) {
            let [a, b, c] = posed.mesh.faces[face as usize];
            let corner = |i: u32| posed.mesh.vertices[i as usize].as_dvec3();
            let a = corner(a);
            let normal_local = (corner(b) - a).cross(corner(c) - a).normalize_or_zero();
            self.normal_world = posed.placement.rotation * normal_local;
            self.last = (instance, face);
        }
        let direction_world = self.casting.direction_world(column, instance, direction_velo);
        let range_m = f64::from(hit.range_m);
        let material = posed.material(face);
        let texture = if ground_texture::is_varied(material) {
            let place = self.casting.place_world(column, origin_velo + direction_velo * range_m);
            ground_texture::paved(place.truncate())
        } else {
            1.0
        };
        Some(Surface {
            range_m,
            cos_incidence: self.normal_world.dot(direction_world).abs().min(1.0),
            material,
            texture,
            actor_id: posed.actor_id,
        })
    }
}
