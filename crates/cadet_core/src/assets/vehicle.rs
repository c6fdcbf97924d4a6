//! Vehicles.

use std::sync::Arc;

use crate::actor::ObjectClass;
use crate::geometry::LodSet;
use crate::material::Palette;
use crate::math::{DVec3, Vec3};

/// A vehicle's shape, in its box frame: x forward, y left, z up, origin at the box's bottom centre.
#[derive(Debug, Clone)]
pub struct VehicleModel {
    /// For example `"compact/12345"`.
    pub name: String,
    /// KITTI's class.
    pub class: ObjectClass,
    /// Length, width, height of the label's box; the body fills it, mirrors and aerials stick out.
    pub size_lwh: DVec3,
    /// Everything but the wheels.
    pub body: Arc<LodSet>,
    /// A wheel about its own centre, axle along y, outer face towards +y (the left side).
    pub wheel: Arc<LodSet>,
    /// Wheel centres in the box frame: front left, front right, rear left, rear right.
    pub wheel_centers: [Vec3; 4],
    /// Tyre radius: also the height of the wheel centres.
    pub wheel_radius_m: f64,
    /// The materials of body and wheels.
    pub palette: Arc<Palette>,
}

impl VehicleModel {
    /// The vehicle of a class and a seed.
    #[must_use]
    pub fn generate(class: ObjectClass, model_seed: u64) -> Self {
        let _ = model_seed;
        let mut body = crate::geometry::MeshBuilder::new();
        body.cuboid(Vec3::new(-2.0, -0.8, 0.2), Vec3::new(2.0, 0.8, 1.5), 0);
        let mut wheel = crate::geometry::MeshBuilder::new();
        wheel.cuboid(Vec3::new(-0.2, -0.1, -0.2), Vec3::new(0.2, 0.1, 0.2), 0);
        let paint = crate::material::Material::matt(
            crate::material::Semantic::Car,
            [0.4; 3],
            crate::material::Pattern::Plain,
            0.3,
        );
        let at = |x: f32, y: f32| Vec3::new(x, y, 0.3);
        Self {
            name: "box".to_owned(),
            class,
            size_lwh: DVec3::new(4.0, 1.6, 1.5),
            body: Arc::new(LodSet::single(body.build("box", 0.5))),
            wheel: Arc::new(LodSet::single(wheel.build("wheel", 0.5))),
            wheel_centers: [at(1.3, 0.7), at(1.3, -0.7), at(-1.3, 0.7), at(-1.3, -0.7)],
            wheel_radius_m: 0.3,
            palette: Arc::new(Palette(vec![paint])),
        }
    }
}
