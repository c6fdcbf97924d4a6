//! How much traffic there is, and of which classes.

use cadet_base::actor::ObjectClass;
use cadet_base::error::{Error, Result};
use cadet_base::rng::Stream;
use cadet_base::settings;

/// Shares of cars and vans among driven vehicles that are no trucks.
pub(super) const DRIVEN_MIX: [(ObjectClass, f64); 2] = [(ObjectClass::Car, 0.89), (ObjectClass::Van, 0.11)];
/// Share of trucks among driven vehicles where the streets have room for them.
pub(super) const DRIVEN_TRUCKS_SHARE: f64 = 0.17;
/// Share of trucks among driven vehicles on motorways.
pub(super) const MOTORWAY_TRUCKS_SHARE: f64 = 0.24;
/// Shares of all classes among a user's own.
pub(super) const DRIVEN_USER_MIX: [(ObjectClass, f64); 3] =
    [(ObjectClass::Car, 0.87), (ObjectClass::Van, 0.09), (ObjectClass::Truck, 0.04)];
/// Shares of trucks and of trailers and motorbikes among what is parked, where they fit.
pub(super) const PARKED_RARE: [(ObjectClass, f64); 2] = [(ObjectClass::Truck, 0.02), (ObjectClass::Misc, 0.05)];
/// Shares of trucks and of trailers and motorbikes among what is parked in the yards of works, where they fit, and the
/// share of vans among the others there.
pub(super) const YARD_RARE: [(ObjectClass, f64); 2] = [(ObjectClass::Truck, 0.5), (ObjectClass::Misc, 0.15)];
pub(super) const YARD_VANS_SHARE: f64 = 0.7;
/// Shares of cars and vans among the other parked vehicles.
pub(super) const PARKED_MIX: [(ObjectClass, f64); 2] = [(ObjectClass::Car, 0.90), (ObjectClass::Van, 0.10)];

settings! {
    /// How much traffic there is.
    TrafficConfig;
    others {
        /// Weights of the classes of vehicles that drive and park; classes left out have none. Empty for KITTI's shares,
        /// which depend on the street. Trailers and motorbikes (Misc) only park.
        vehicle_shares: Vec<(ObjectClass, f64)> = Vec::new();
    }
    numbers {
        /// Driven cars kept around the ego.
        num_cars: usize = 14, 0 to 500;
        /// People kept around the ego.
        num_pedestrians: usize = 24, 0 to 500;
        /// Cyclists kept around the ego.
        num_cyclists: usize = 0, 0 to 200;
        /// Trams kept around the ego, where there are tracks.
        num_trams: usize = 0, 0 to 20;
        /// Mean fraction of the parking places along the ego's way that are taken; it varies from street to street, and
        /// side streets and drives are fuller: its power of 0.35.
        parking_occupancy: f64 = 0.6, 0 to 1;
        /// Mean fraction of the seats (benches, chairs of cafes, bus stops) that are taken.
        seat_occupancy: f64 = 0.1, 0 to 1;
        /// Driven cars start within this distance of the ego, meters.
        car_radius_m: f64 = 110.0, 1 to 1000;
        /// People start within this distance of the ego, meters.
        pedestrian_radius_m: f64 = 80.0, 1 to 1000;
        /// Cyclists start within this distance of the ego, meters.
        cyclist_radius_m: f64 = 70.0, 1 to 1000;
        /// Distance from the ego within which parking places and seats are filled, meters.
        parking_radius_m: f64 = 280.0, 1 to 1000;
    }
}

impl TrafficConfig {
    /// The classes of vehicles that may drive and park.
    pub const VEHICLE_CLASSES: [ObjectClass; 4] =
        [ObjectClass::Car, ObjectClass::Van, ObjectClass::Truck, ObjectClass::Misc];

    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a number that makes no sense.
    pub fn check(&self) -> Result<()> {
        self.check_settings()?;
        let is_weight = |(class, weight): &(ObjectClass, f64)| {
            Self::VEHICLE_CLASSES.contains(class) && weight.is_finite() && *weight >= 0.0
        };
        // Trucks and trailers do not fit everywhere.
        let fits = self.weight(ObjectClass::Car) + self.weight(ObjectClass::Van) > 0.0;
        if !self.vehicle_shares.iter().all(is_weight) || !(self.vehicle_shares.is_empty() || fits) {
            return Err(Error::OutOfRange {
                what: "vehicle shares",
                value: format!("{:?}", self.vehicle_shares),
                expected: "weights of vehicle classes, that of cars or vans above 0".to_owned(),
            });
        }
        Ok(())
    }

    fn weight(&self, class: ObjectClass) -> f64 {
        self.vehicle_shares.iter().filter(|(other, _)| *other == class).map(|(_, weight)| weight).sum()
    }

    /// The class of a rare vehicle, drawn from a seed alone: the others' draws don't depend on it.
    pub(super) fn rare<const N: usize>(&self, usual: &[(ObjectClass, f64); N], seed: u64) -> Option<ObjectClass> {
        let at = Stream::from_seed("rare vehicle", seed).unit();
        let mut sum = 0.0;
        let shares = self.shares(usual, &[ObjectClass::Car, ObjectClass::Van]);
        let (class, _) = shares.iter().find(|(_, share)| {
            sum += share;
            at < sum
        })?;
        Some(*class)
    }

    /// The shares of classes among these and `others`: the stated ones, or the usual ones if none are stated.
    pub(super) fn shares<const N: usize>(
        &self,
        usual: &[(ObjectClass, f64); N],
        others: &[ObjectClass],
    ) -> [(ObjectClass, f64); N] {
        if self.vehicle_shares.is_empty() {
            return *usual;
        }
        let sum: f64 = usual.iter().map(|(class, _)| class).chain(others).map(|class| self.weight(*class)).sum();
        usual.map(|(class, _)| (class, self.weight(class) / sum))
    }
}
