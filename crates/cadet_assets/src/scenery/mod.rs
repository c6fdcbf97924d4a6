//! Houses, plants, lights, and bridges: shared prototypes, each a pure function of its kind and variant.
//!
//! Every model stands upright in its own frame: z up, z = 0 at the ground, x toward whoever looks at it (the street
//! for houses, the driver for signs), or along the piece for fences and hedges. Foundations and trunks go on below
//! z = 0, so that nothing floats on a slope.

mod building;
mod city;
mod crops;
mod draw;
mod facade;
mod garage;
pub(super) mod greens;
mod hall;
mod hedge;
mod house;
pub(super) mod leaves;
pub(super) mod letters;
mod library;
pub mod materials;
mod motorway;
mod overhead;
mod roof;
mod street_light;
mod traffic_light;
mod tree;
mod tree_levels;
mod wall_plane;

use std::sync::Arc;

pub use building::House;
pub use city::{CityCorner, CityKind, NUM_CITY_HOUSES, SPAN_LENS_M, city_palette, span_lamp};
pub use crops::{CROP_VARIANTS, HERBS_M, MAIZE_M, herbs, maize};
pub use hall::{HALL_VARIANTS, HallKind, hall_palette};
pub use hedge::NARROW_HEDGES;
pub use house::HouseKind;
pub use library::{OVERHEAD_M, PIECE_LENGTHS_M, city_house, garage, hall, hedge, house, num_variants, tree};
pub use motorway::{BRIDGE_DECK_M, MOTORWAY_PIECE_M, RAMP_M, gantry, overpass};
pub use overhead::{WIRE_HEIGHT_M, contact_wire, span_wire, tram_mast};
pub use street_light::{Head, StreetLight};
pub use traffic_light::{
    HEAD_OFF_POST_M, HeadKind, MAST_ARMS_M, MAST_HEAD_M, POST_HEAD_M, SignalPost, WALK_HEAD_M, signal_head, signal_post,
};
pub use tree::TreeKind;

use cadet_base::geometry::{LazyMesh, LodSet, Mesh};
use cadet_base::instance::Instance;
use cadet_base::material::Palette;
use cadet_base::math::{DPose3, DVec2};

/// A piece of scenery in its own frame (see the module's head).
#[derive(Debug, Clone)]
pub struct SceneryModel {
    /// For example `"detached/3"`.
    pub name: String,
    /// The shape.
    pub shape: Arc<LodSet>,
    /// The materials of the prototype; a placed instance may wear others with the same slots.
    pub palette: Arc<Palette>,
    /// What it stands on, overhangs left out: smallest corner, x and y.
    pub footprint_min: DVec2,
    /// What it stands on: largest corner, x and y.
    pub footprint_max: DVec2,
    /// Height above z = 0.
    pub height_m: f64,
}

impl SceneryModel {
    /// A model that stands on a rectangle about the origin.
    fn about_origin(name: String, shape: Arc<LodSet>, palette: Arc<Palette>, half: DVec2, height_m: f64) -> Self {
        Self { name, shape, palette, footprint_min: -half, footprint_max: half, height_m }
    }

    /// A piece of a length along +x, as deep to both sides of y = 0.
    fn along_x(
        name: String,
        shape: Arc<LodSet>,
        palette: Arc<Palette>,
        (length_m, half_m): (f64, f64),
        height_m: f64,
    ) -> Self {
        let (footprint_min, footprint_max) = (DVec2::new(0.0, -half_m), DVec2::new(length_m, half_m));
        Self { name, shape, palette, footprint_min, footprint_max, height_m }
    }
    /// The model placed in the world, in its own colors.
    #[must_use]
    pub fn at(&self, world_from_local: DPose3) -> Instance {
        self.with_palette(Arc::clone(&self.palette), world_from_local)
    }

    /// The model placed in the world, in other colors: `palette` has the prototype's slots.
    #[must_use]
    pub fn with_palette(&self, palette: Arc<Palette>, world_from_local: DPose3) -> Instance {
        debug_assert_eq!(palette.materials().len(), self.palette.materials().len());
        Instance::new(Arc::clone(&self.shape), palette, world_from_local, 0)
    }

    /// Extent of the footprint along x and y.
    #[must_use]
    pub fn footprint_size(&self) -> DVec2 {
        self.footprint_max - self.footprint_min
    }
}

/// How much a prototype shows: one mesh is made for each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Detail {
    Near,
    Mid,
    Far,
}

impl Detail {
    /// Levels of detail that change at the given distances from the ego, the coarser ones made when they are needed;
    /// beyond the last one nothing is seen.
    pub(super) fn levels(
        [near, mid, far]: [f32; 3],
        mesh: impl Fn(Self) -> Mesh + Send + Sync + 'static,
    ) -> Arc<LodSet> {
        let mesh = Arc::new(mesh);
        let finest = (near, mesh(Self::Near));
        let coarser = [(mid, Self::Mid), (far, Self::Far)].map(|(limit, detail)| {
            let mesh = Arc::clone(&mesh);
            (limit, LazyMesh::new(move || mesh(detail)))
        });
        Arc::new(LodSet::new(finest, coarser))
    }

    /// The value for this level.
    pub(super) fn pick<T>(self, near: T, mid: T, far: T) -> T {
        match self {
            Self::Near => near,
            Self::Mid => mid,
            Self::Far => far,
        }
    }
}

#[cfg(test)]
mod tests;
