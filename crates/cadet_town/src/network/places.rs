//! Places beside the roads: where vehicles may be parked, and where people walk.

use cadet_base::math::{DPose3, DVec2, DVec3};
use cadet_base::plane::OrientedRect;

/// How cars stand in a parking place, and who fills it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpotKind {
    /// Along the curb, at it or in a bay.
    Parallel,
    /// In a bay at an angle to the curb, up to a right one.
    Angled,
    /// In the drive of a house.
    Drive,
    /// In a row of a lot beside the street.
    Lot,
    /// In the yard of works: for trucks, vans, and trailers.
    Yard,
}

/// A place where a vehicle may be parked.
#[derive(Debug, Clone)]
pub struct ParkingSpot {
    /// How cars stand in it.
    pub kind: SpotKind,
    /// Middle of the spot on the ground, x along the parked vehicle's heading.
    pub world_from_spot: DPose3,
    /// Room along x.
    pub length_m: f64,
    /// Room along y.
    pub width_m: f64,
}

impl ParkingSpot {
    /// The ground that it takes.
    #[must_use]
    pub fn rect(&self) -> OrientedRect {
        let axis = (self.world_from_spot.rotation * DVec3::X).truncate().normalize_or(DVec2::X);
        let half = DVec2::new(self.length_m, self.width_m) / 2.0;
        OrientedRect { center: self.world_from_spot.translation.truncate(), axis, half }
    }
}

/// A line that people walk along, on a sidewalk.
#[derive(Debug, Clone)]
pub struct Walkway {
    /// Points at most 2 m apart, on the ground.
    pub center: Vec<DVec3>,
    /// Usable width.
    pub width_m: f64,
}
