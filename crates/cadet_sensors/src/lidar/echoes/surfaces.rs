//! The second step of a scan: the surface behind a hit.
//!
//! What casting knew of it comes with the hit; its normal is computed where more than its angle to the beam counts.

use super::echo::HitSurface;
use crate::lidar::casting::{BeamHit, Casting};
use crate::lidar::reflectance::ground_texture;
use crate::surface_cover::snow_share;
use cadet_base::math::DVec3;

/// Looks surfaces up.
pub(crate) struct SurfaceLookup<'a, C> {
    casting: &'a C,
    /// Share of level surfaces under snow.
    snow_cover: f64,
    /// Whether anyone asks for normals.
    records_surfaces: bool,
}

impl<'a, C: Casting> SurfaceLookup<'a, C> {
    pub(crate) fn new(casting: &'a C, snow_cover: f64, records_surfaces: bool) -> Self {
        Self { casting, snow_cover, records_surfaces }
    }

    /// The surface that a beam of a column met in a direction.
    #[inline]
    pub(crate) fn at(
        &self,
        hit: BeamHit,
        column: usize,
        origin_velo: DVec3,
        direction_velo: DVec3,
    ) -> Option<HitSurface<'a>> {
        if !hit.is_hit() {
            return None;
        }
        let (instance, face) = (hit.instance, hit.face);
        let posed = &self.casting.scene().instances[instance as usize];
        let range_m = f64::from(hit.range_m);
        let material = posed.material(face);
        let texture = if ground_texture::is_varied(material) {
            let place = self.casting.place_world(column, origin_velo + direction_velo * range_m);
            ground_texture::paved(place.truncate())
        } else {
            1.0
        };
        // Of the side that is seen.
        let normal_world = || {
            let normal_world = posed.normal_world(face);
            let direction_world = self.casting.direction_world(column, instance, direction_velo);
            if normal_world.dot(direction_world) > 0.0 { -normal_world } else { normal_world }
        };
        let snow = if self.snow_cover == 0.0 || material.semantic.is_ground() || posed.is_without_snow(material) {
            0.0
        } else {
            self.snow_cover * f64::from(snow_share(normal_world().z as f32))
        };
        let normal_velo = if self.records_surfaces {
            let normal_world = normal_world();
            let along = |axis| normal_world.dot(self.casting.direction_world(column, instance, axis)) as f32;
            [DVec3::X, DVec3::Y, DVec3::Z].map(along)
        } else {
            [0.0; 3]
        };
        Some(HitSurface {
            range_m,
            normal_velo,
            cos_incidence: f64::from(hit.cos_incidence).min(1.0),
            material,
            texture_factor: texture,
            snow_cover: snow,
            actor_id: posed.actor_id,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use crate::lidar::{LidarSpec, scan};
    use crate::sense::PosedScene;
    use crate::weather::Weather;
    use cadet_base::frames::mounted;
    use cadet_base::geometry::{LodSet, MeshBuilder};
    use cadet_base::instance::Instance;
    use cadet_base::material::{Material, Palette, Pattern, Semantic};
    use cadet_base::math::{DPose3, DVec3, Vec3};
    use cadet_base::rng::Stream;

    /// Of the beams that meet a pane before a wall, the share that the pane returns; it rises by `rise_m` over 3 m ahead.
    fn share_of_pane(rise_m: f32, sheds_snow: bool) -> f64 {
        let mut glass = Material::matt(Semantic::Car, [0.1; 3], Pattern::Plain, 0.04);
        (glass.transmission, glass.lidar.transmission) = (0.8, 0.8);
        let wall = Material::matt(Semantic::Building, [0.5; 3], Pattern::Plain, 0.5);
        let instance = |corners: [Vec3; 4], material, actor_id| {
            let mut b = MeshBuilder::new();
            let [p, q, r, s] = corners;
            b.quad(p, q, r, s, 0);
            let shape = Arc::new(LodSet::single(b.build("quad", 0.5)));
            Instance::new(shape, Arc::new(Palette::new(vec![material])), DPose3::IDENTITY, actor_id)
        };
        let (near, far, low) = (8.0, 11.0, -2.0);
        let pane = [
            Vec3::new(near, -2.0, low),
            Vec3::new(near, 2.0, low),
            Vec3::new(far, 2.0, low + rise_m),
            Vec3::new(far, -2.0, low + rise_m),
        ];
        let behind = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(y, z)| Vec3::new(11.1, y, z));
        let pane = Instance { sheds_snow, ..instance(pane, glass, 1) };
        let posed = PosedScene::new(&[pane, instance(behind, wall, 2)], DVec3::ZERO);
        // Snow has fallen; hardly a flake is in the air.
        let weather = Weather { snow_mm_per_h: 1e-3, ..Weather::preset("snow").unwrap() };
        let spec = LidarSpec::hdl64e_kitti();
        let pose = mounted(DVec3::ZERO, 0.0, 0.0, 0.0);
        let returned = scan(&posed, &pose, &spec, &weather, &mut Stream::from_seed("scan", 1)).unwrap();
        // Beams to the pane: between its sides, and below its far rim.
        let slope = (low + rise_m) / far;
        let ahead = returned.points_velo.iter().zip(&returned.actor_id);
        let (mut of_pane, mut count) = (0, 0);
        for ([x, y, z, _], actor_id) in ahead {
            if *x > 0.0 && (y / x).abs() < 0.15 && z / x < slope - 0.01 && z / x > low / near + 0.01 {
                count += 1;
                of_pane += usize::from(*actor_id == 1);
            }
        }
        assert!(count > 200, "{count}");
        of_pane as f64 / count as f64
    }

    #[test]
    fn panes_return_the_snow_that_lies_on_what_stands() {
        // A slope of 18 degrees, whose normal rises by 0.95: 0.75 of it is white, 0.08 of it dirty.
        let [standing, driving] = [false, true].map(|sheds_snow| share_of_pane(1.0, sheds_snow));
        assert!(standing > 0.75, "{standing}");
        assert!((0.02..0.4).contains(&driving), "{driving}");
    }

    #[test]
    fn steep_panes_hold_no_snow() {
        // 70 degrees over so short a way that the normal rises by 0.34.
        let [standing, driving] = [false, true].map(|sheds_snow| share_of_pane(8.2, sheds_snow));
        assert!((standing - driving).abs() < 1e-9, "{standing} {driving}");
    }
}
