//! A town: a road network from OpenDRIVE, the ground under it, and the dressing that makes a street of it.

mod dressing;
mod face_index;
mod ground;
mod ground_mesh;
mod ground_palette;
mod ground_region;
mod height_field;
mod kerbside;
mod network;
mod opendrive;
mod plan_curve;
mod relief;
mod road_marking;
mod street_plan;
mod suburb;
mod walkway;
mod xodr_writer;

pub use ground::{Ground, GroundKind};
pub use kerbside::parking_spots;
pub use network::{Lane, LaneId, LaneKind, RoadNetwork};
pub use opendrive::load as load_map;
pub use suburb::{Suburb, SuburbConfig, generate as generate_suburb};
pub use walkway::walkways;

use crate::instance::Instance;
use crate::math::{DPose3, DVec3};

/// A place where a vehicle may be parked.
#[derive(Debug, Clone)]
pub struct ParkingSpot {
    /// Middle of the spot on the ground, x along the parked vehicle's heading.
    pub world_from_spot: DPose3,
    /// Room along x.
    pub length_m: f64,
    /// Room along y.
    pub width_m: f64,
}

/// A line that people walk along, on a pavement.
#[derive(Debug, Clone)]
pub struct Walkway {
    /// Points at most 2 m apart, on the ground.
    pub center: Vec<DVec3>,
    /// Usable width.
    pub width_m: f64,
}

/// Everything of a place that does not move.
#[derive(Debug, Clone)]
pub struct Town {
    /// The map's file name, or `suburb`.
    pub name: String,
    /// Lanes and how they follow each other.
    pub network: RoadNetwork,
    /// The surface that is driven and walked on.
    pub ground: Ground,
    /// Ground, houses, plants, furniture: all that stands still.
    pub scenery: Vec<Instance>,
    /// Where cars may be parked.
    pub parking: Vec<ParkingSpot>,
    /// Where people walk.
    pub walkways: Vec<Walkway>,
}
