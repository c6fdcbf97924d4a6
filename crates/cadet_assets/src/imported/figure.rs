//! People and riders made of somebody else's meshes.

use std::sync::Arc;

use super::asset::{MeshAsset, Placed};
use super::materials::material;
use super::vehicle::CREASE_RAD;
use crate::annotation;
use cadet_base::actor::{AnnotatedBox, ObjectClass};
use cadet_base::error::{Error, Result};
use cadet_base::geometry::{LodSet, MeshBuilder};
use cadet_base::material::Palette;
use cadet_base::math::DVec3;
use cadet_base::rng::Stream;

/// The axles of bicycles are this far apart, by their length.
const WHEELBASE_SHARE: f64 = 0.6;

/// A person or a rider with the bicycle: rigid, in the box frame: x forward, y left, z up, origin at the box's bottom
/// center.
#[derive(Debug, Clone)]
pub struct FigureModel {
    /// The user's name for it.
    pub name: String,
    /// KITTI's class: `Pedestrian`, `Person_sitting` or `Cyclist`.
    pub class: ObjectClass,
    /// Length, width, height of the mesh's bounds.
    pub size_lwh: DVec3,
    /// That box, and from how far an annotator would draw it.
    pub annotated: AnnotatedBox,
    /// All of it.
    pub body: Arc<LodSet>,
    /// The materials.
    pub palette: Arc<Palette>,
}

impl FigureModel {
    /// The figure of a user's mesh: one level of detail, and the mesh's bounds its box; a line each of what was assumed.
    ///
    /// # Errors
    /// [`Error::Mesh`], naming the file: no face with an area, a coordinate that is not finite, a rule that fits
    /// nothing, or a size that nobody has. [`Error::Scene`] for a class of vehicles.
    pub fn with_assumptions(asset: &MeshAsset) -> Result<(Self, Vec<String>)> {
        if !asset.class.is_human() {
            let name = asset.class.kitti_name();
            let reason = format!("nobody is of class {name}: Pedestrian, Person_sitting or Cyclist");
            return Err(Error::Scene { reason });
        }
        let Placed { faces, size, assumed } = asset.placed(0)?;
        let mut builder = MeshBuilder::new();
        for ([a, b, c], slot) in &faces {
            builder.triangle(*a, *b, *c, *slot as u8);
        }
        let (semantic, materials) = (asset.class.semantic(), &asset.source.materials);
        let roles = asset.rules.roles_of_figure(asset.class, materials);
        let palette = materials.iter().zip(roles).map(|(m, role)| material(Some(m), role, semantic)).collect();
        let model = Self {
            name: asset.name.clone(),
            class: asset.class,
            size_lwh: size,
            annotated: AnnotatedBox::exact(size),
            body: Arc::new(LodSet::single(builder.build(&asset.file, CREASE_RAD))),
            palette: Arc::new(Palette::new(palette)),
        };
        Ok((model, assumed))
    }

    /// Returns this figure as another annotator would label it: as far away, and from as few returns.
    #[must_use]
    pub fn annotated_by(self, annotator_seed: u64) -> Self {
        let stream = &mut Stream::from_seed("annotated box", annotator_seed);
        Self { annotated: annotation::box_of_figure(self.class, self.size_lwh, stream), ..self }
    }

    /// Distance between the axles of a rider's bicycle.
    #[must_use]
    pub fn wheelbase_m(&self) -> f64 {
        WHEELBASE_SHARE * self.size_lwh.x
    }
}
