//! A shape placed in the world.

use std::sync::Arc;

use crate::geometry::{LodSet, Mesh};
use crate::material::Palette;
use crate::math::{DPose3, DQuat, DVec3};

/// A shape with its materials and its pose. Shapes and palettes are shared, so an instance is cheap to copy.
#[derive(Debug, Clone)]
pub struct Instance {
    /// The shape.
    pub shape: Arc<LodSet>,
    /// Its materials: the mesh's slots index it.
    pub palette: Arc<Palette>,
    /// Its pose.
    pub world_from_local: DPose3,
    /// 0 for the static world, at least 1 for actors. All parts of an actor share its id.
    pub actor_id: i32,
    /// Whether it is an actor's body, which hides the sky from the ground under and beside it: not its wheels, nor who sits in
    /// it.
    pub is_body: bool,
    /// Whether snow does not stay on it, as on what drives; it lies on what stands.
    pub sheds_snow: bool,
}

impl Instance {
    /// What stands in the static world (`actor_id` 0), or an actor's body on which snow stays.
    #[must_use]
    pub fn new(shape: Arc<LodSet>, palette: Arc<Palette>, world_from_local: DPose3, actor_id: i32) -> Self {
        Self { shape, palette, world_from_local, actor_id, is_body: actor_id > 0, sheds_snow: false }
    }

    /// A mesh that stands in the static world, its axes along the world's.
    #[must_use]
    pub fn standing(mesh: Mesh, palette: Arc<Palette>, origin: DVec3) -> Self {
        let world_from_local = DPose3 { rotation: DQuat::IDENTITY, translation: origin };
        Self::new(Arc::new(LodSet::single(mesh)), palette, world_from_local, 0)
    }

    /// Returns this instance in the palette that it wears at night.
    #[must_use]
    pub fn at_night(&self) -> Self {
        let palette = self.palette.at_night().unwrap_or(&self.palette);
        Self { palette: Arc::clone(palette), ..self.clone() }
    }
}
