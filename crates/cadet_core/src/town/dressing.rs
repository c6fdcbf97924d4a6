//! Dresses a network: houses, gardens, hedges, trees, lamps and signs; a function of network and seed.

use super::frontage::frontages;
use super::occupancy::{Occupancy, Site};
use super::placer::{Placer, Standing};
use super::street_style::StreetStyle;
use super::{Ground, ParkingSpot, RoadNetwork, belt, garden, plots, streetside};
use crate::error::{Error, Result};
use crate::instance::Instance;
use crate::rng::StreamKey;

/// How to dress a town.
#[derive(Debug, Clone, PartialEq)]
pub struct DressingConfig {
    /// Weights of the house kinds, in the order of [`crate::assets::scenery::HouseKind::ALL`].
    pub house_shares: [f64; 6],
    /// How green it is: 1 is a common suburb, 0 has no trees; at most 2.
    pub greenery: f64,
    /// Depth of the belt of trees about the outermost streets, 0 to 150 m.
    pub belt_m: f64,
}

impl Default for DressingConfig {
    fn default() -> Self {
        Self { house_shares: [0.35, 0.15, 0.15, 0.15, 0.08, 0.12], greenery: 1.0, belt_m: 48.0 }
    }
}

impl DressingConfig {
    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], naming the value and its limits.
    pub fn check(&self) -> Result<()> {
        let out_of_range = |what: &'static str, value: String, expected: &str| {
            Err(Error::OutOfRange { what, value, expected: expected.to_owned() })
        };
        let total: f64 = self.house_shares.iter().sum();
        if self.house_shares.iter().any(|w| !w.is_finite() || *w < 0.0) || total <= 0.0 {
            let value = format!("{:?}", self.house_shares);
            return out_of_range("dressing house_shares", value, "weights of at least 0, not all 0");
        }
        if !(0.0..=2.0).contains(&self.greenery) {
            return out_of_range("dressing greenery", self.greenery.to_string(), "0 to 2");
        }
        if !(0.0..=150.0).contains(&self.belt_m) {
            return out_of_range("dressing belt_m", self.belt_m.to_string(), "0 to 150 m");
        }
        Ok(())
    }
}

/// What dressing adds to a town.
#[derive(Debug)]
pub(super) struct Dressing {
    /// Everything that stands.
    pub instances: Vec<Instance>,
    /// Drives of garages, where a car may stand.
    pub drives: Vec<ParkingSpot>,
    /// What stands where.
    #[cfg_attr(not(test), allow(dead_code))]
    pub standing: Vec<Standing>,
}

/// Dresses a network.
pub(super) fn dress(key: &StreamKey, network: &RoadNetwork, ground: &Ground, config: &DressingConfig) -> Dressing {
    let site = Site::new(ground);
    let mut taken = Occupancy::default();
    let mut placer = Placer::new(&site);
    let mut drives = Vec::new();
    let frontages = frontages(network, &site);
    let styles: Vec<StreetStyle> =
        frontages.iter().map(|f| StreetStyle::draw(key, f.road, f.speed_limit_mps, config)).collect();
    let stream = |name: &str, index: usize| key.indexed(name, index as u64);
    for (i, (frontage, style)) in frontages.iter().zip(&styles).enumerate() {
        let plots = plots::lay_out(frontage, style, &site, &mut taken, &mut stream("plots", i));
        let mut s = stream("gardens", i);
        for plot in &plots {
            garden::fill(plot, style, &mut s, &mut placer, &mut drives);
        }
        streetside::furnish(frontage, style, &mut stream("streetside", i), &mut placer);
    }
    belt::plant(&mut key.stream("belt"), config.greenery, config.belt_m, &taken, &mut placer);
    Dressing { instances: placer.instances, drives, standing: placer.standing }
}
