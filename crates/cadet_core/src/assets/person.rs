//! People on foot.

use std::sync::Arc;

use crate::geometry::LodSet;
use crate::material::Palette;
use crate::math::{DVec3, Vec3};

/// A person's shape, in the box frame: x forward, y left, z up, origin on the ground.
#[derive(Debug, Clone)]
pub struct PersonModel {
    /// For example `"woman/12345"`.
    pub name: String,
    /// Length, width, height of the label's box: the largest over the gait cycle for a walker.
    pub size_lwh: DVec3,
    /// Walking speed that the stride fits, m/s; 0 for a person who stands.
    pub walking_speed_mps: f64,
    /// Length of a full gait cycle (two steps) on the ground, metres.
    pub cycle_length_m: f64,
    /// The materials.
    pub palette: Arc<Palette>,
}

impl PersonModel {
    /// The person of a seed; one in four stands.
    #[must_use]
    pub fn generate(model_seed: u64) -> Self {
        let _ = model_seed;
        let cloth = crate::material::Material::matt(
            crate::material::Semantic::Person,
            [0.2; 3],
            crate::material::Pattern::Cloth,
            0.4,
        );
        Self {
            name: "person".to_owned(),
            size_lwh: DVec3::new(0.9, 0.6, 1.75),
            walking_speed_mps: 1.34,
            cycle_length_m: 1.44,
            palette: Arc::new(Palette(vec![cloth])),
        }
    }

    /// The shape at a phase of the gait cycle in [0, 1).
    #[must_use]
    pub fn pose(&self, phase: f64) -> LodSet {
        let _ = phase;
        let mut b = crate::geometry::MeshBuilder::new();
        b.cuboid(Vec3::new(-0.2, -0.3, 0.0), Vec3::new(0.2, 0.3, 1.75), 0);
        LodSet::single(b.build("person", 0.5))
    }
}
