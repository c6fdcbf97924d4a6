//! Which level of detail is drawn: by the size of a pixel and of the step from beam to beam, and by nothing else.

use cadet_base::instance::Instance;
use cadet_base::math::DVec3;

/// The finest angle between neighboring samples of the sensors that look at a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    finest_rad: f32,
}

impl Resolution {
    /// A pixel of KITTI's camera, 1.39 mrad: the limits of levels ([`cadet_base::geometry::LodSet::levels`]) are given for it.
    /// The beams of its LIDAR are 3.0 mrad apart.
    pub const KITTI: Self = Self { finest_rad: 1.0 / FOCAL_LENGTH_PX };
    /// Of a camera with a focal length in pixels and a LIDAR with so many beams a turn.
    #[must_use]
    pub fn of(focal_length_px: f64, beams_per_turn: usize) -> Self {
        let (pixel_rad, beam_rad) = (1.0 / focal_length_px, std::f64::consts::TAU / beams_per_turn.max(1) as f64);
        Self { finest_rad: pixel_rad.min(beam_rad) as f32 }
    }

    /// How much further than for KITTI's camera each level reaches: so far that its parts look as many pixels large there.
    #[must_use]
    pub fn reach_factor(self) -> f32 {
        Self::KITTI.finest_rad / self.finest_rad
    }
}

/// Of KITTI's rectified images.
const FOCAL_LENGTH_PX: f32 = 721.537_7;

/// How far an instance is from the viewer, meters: from the sphere around the bounds of its shape, so that the choice of a
/// level does not depend on the choice.
pub(super) fn distance_m(instance: &Instance, viewer_world: DVec3) -> f32 {
    let bounds = &instance.shape.bounds;
    let middle = instance.world_from_local.transform_point(bounds.center().as_dvec3());
    ((middle - viewer_world).length() - f64::from(bounds.size().length()) / 2.0).max(0.0) as f32
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::sense::PosedScene;
    use cadet_base::frames::upright;
    use cadet_base::geometry::{LazyMesh, LodSet, Mesh, MeshBuilder};
    use cadet_base::material::Palette;
    use cadet_base::math::Vec3;

    /// Cubes side by side, 12 triangles each.
    fn cubes(count: usize) -> Mesh {
        let mut b = MeshBuilder::new();
        for i in 0..count {
            let at = Vec3::new(i as f32 * 1e-3, 0.0, 0.0);
            b.cuboid(at, at + Vec3::splat(5e-4), 0);
        }
        b.build("cubes", 0.5)
    }

    /// Shapes of 2,400 triangles up to 20 m, 1,200 up to 40 m, 120 up to 90 m and none beyond that, at some distances.
    fn trees(at_m: impl Iterator<Item = f64>) -> Vec<Instance> {
        let coarser = [(40.0, 100), (90.0, 10)].map(|(to_m, n)| (to_m, LazyMesh::new(move || cubes(n))));
        let shape = Arc::new(LodSet::new((20.0, cubes(200)), coarser));
        let palette = Arc::new(Palette::default());
        at_m.map(|x| Instance::new(Arc::clone(&shape), Arc::clone(&palette), upright(DVec3::new(x, 0.0, 0.0), 0.0), 0))
            .collect()
    }

    fn faces(instances: &[Instance], resolution: Resolution) -> Vec<usize> {
        let scene = PosedScene::for_resolution(instances, DVec3::ZERO, resolution);
        scene.instances.iter().map(|i| i.mesh.num_faces()).collect()
    }

    #[test]
    fn a_level_reaches_as_many_pixels_whatever_the_camera() {
        let at_m = [11.0, 19.0, 21.0, 39.0, 41.0, 79.0, 89.0];
        let (fine, mid, far) = (2400, 1200, 120);
        let of = |resolution| faces(&trees(at_m.into_iter()), resolution);
        assert_eq!(of(Resolution::KITTI), [fine, fine, mid, mid, far, far, far]);
        // Twice the pixels, or twice the beams: twice as far. Half of both: half as far. What matters is the finer of both.
        let twice = [fine, fine, fine, fine, mid, mid, far];
        assert_eq!(of(Resolution::of(2.0 * 721.5377, 4000)), twice);
        assert_eq!(of(Resolution::of(300.0, 9068)), twice);
        assert_eq!(of(Resolution::of(0.5 * 721.5377, 2000)), [mid, mid, far, far, far, far, far]);
    }

    #[test]
    fn coarse_sensors_still_see_what_stands_far_away_and_fine_ones_see_further() {
        let far = |resolution| faces(&trees([85.0, 170.0, 190.0].into_iter()), resolution);
        assert_eq!(far(Resolution::of(100.0, 360)), [120]);
        assert_eq!(far(Resolution::KITTI), [120]);
        assert_eq!(far(Resolution::of(2.0 * 721.5377, 4000)), [120, 120]);
    }

    #[test]
    fn a_level_does_not_depend_on_what_else_stands_about() {
        let few = faces(&trees([15.0, 30.0].into_iter()), Resolution::KITTI);
        let many = trees([15.0, 30.0].into_iter().chain((0..400).map(|i| 10.0 + 0.1 * f64::from(i))));
        assert_eq!(faces(&many, Resolution::KITTI)[..2], few);
    }
}
