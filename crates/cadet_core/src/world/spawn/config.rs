//! How much traffic there is, and of which classes.

use crate::actor::ObjectClass;
use crate::error::{Error, Result};

/// Shares of the classes among driven vehicles.
pub(super) const DRIVEN_MIX: [(ObjectClass, f64); 2] = [(ObjectClass::Car, 0.91), (ObjectClass::Van, 0.09)];
/// The same among a user's own: trucks have no shape in code.
pub(super) const DRIVEN_USER_MIX: [(ObjectClass, f64); 3] =
    [(ObjectClass::Car, 0.87), (ObjectClass::Van, 0.09), (ObjectClass::Truck, 0.04)];
/// Shares of the classes among parked vehicles.
pub(super) const PARKED_MIX: [(ObjectClass, f64); 2] = [(ObjectClass::Car, 0.92), (ObjectClass::Van, 0.08)];

/// How much traffic there is.
#[derive(Debug, Clone, PartialEq)]
pub struct TrafficConfig {
    /// Driven cars kept around the ego.
    pub num_cars: usize,
    /// People kept around the ego.
    pub num_pedestrians: usize,
    /// Mean fraction of the parking places along the ego's way that are taken, in [0, 1]; it varies from street to
    /// street, and side streets and drives are fuller: its power of 0.35.
    pub parking_occupancy: f64,
    /// Driven cars start within this distance of the ego, meters.
    pub car_radius_m: f64,
    /// People start within this distance of the ego, meters.
    pub pedestrian_radius_m: f64,
    /// Distance from the ego within which parking places are filled, meters.
    pub parking_radius_m: f64,
    /// Classes of the vehicles that drive and park, cars among them; the shares of those left out go to the others.
    pub vehicle_classes: Vec<ObjectClass>,
}

impl Default for TrafficConfig {
    fn default() -> Self {
        Self {
            num_cars: 14,
            num_pedestrians: 24,
            parking_occupancy: 0.6,
            car_radius_m: 110.0,
            pedestrian_radius_m: 80.0,
            parking_radius_m: 280.0,
            vehicle_classes: vec![ObjectClass::Car, ObjectClass::Van, ObjectClass::Truck],
        }
    }
}

impl TrafficConfig {
    /// # Errors
    /// [`Error::OutOfRange`] for a number that makes no sense.
    pub(super) fn check(&self) -> Result<()> {
        let bad =
            |what, value: String, expected: &str| Err(Error::OutOfRange { what, value, expected: expected.to_owned() });
        if !(0.0..=1.0).contains(&self.parking_occupancy) {
            return bad("parking occupancy", self.parking_occupancy.to_string(), "0 to 1");
        }
        for (what, radius) in [
            ("car radius", self.car_radius_m),
            ("pedestrian radius", self.pedestrian_radius_m),
            ("parking radius", self.parking_radius_m),
        ] {
            if !(radius.is_finite() && radius > 0.0) {
                return bad(what, radius.to_string(), "a positive number of meters");
            }
        }
        for (what, count, most) in
            [("number of cars", self.num_cars, 500), ("number of pedestrians", self.num_pedestrians, 500)]
        {
            if count > most {
                return bad(what, count.to_string(), "at most 500");
            }
        }
        if !self.vehicle_classes.contains(&ObjectClass::Car) {
            return bad("vehicle classes", format!("{:?}", self.vehicle_classes), "cars among them");
        }
        Ok(())
    }

    /// The shares of a mix, 0 for classes that are left out.
    pub(super) fn among_classes<const N: usize>(&self, mix: &[(ObjectClass, f64); N]) -> [(ObjectClass, f64); N] {
        mix.map(|(class, share)| (class, if self.vehicle_classes.contains(&class) { share } else { 0.0 }))
    }
}
