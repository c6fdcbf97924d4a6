//! Settings of what is placed along the streets of a town.

use cadet_assets::props::OwnProps;
use cadet_base::error::{Error, Result};
use cadet_base::settings;

settings! {
    /// Houses, gardens, and trees along the streets of a town.
    PropConfig;
    others {
        /// A user's own props, placed as the crate's are.
        own: OwnProps = OwnProps::default();
    }
    numbers {
        /// Weights of the house kinds, in the order of [`cadet_assets::scenery::HouseKind`]; not all 0.
        house_shares: [f64; 6] = [0.35, 0.15, 0.15, 0.15, 0.08, 0.12], 0 to 1e6;
        /// How green it is: 1 is a common suburb, 0 has no trees.
        greenery: f64 = 1.0, 0 to 2;
        /// Depth of the belt of trees behind the outermost plots, meters.
        belt_m: f64 = 40.0, 0 to 120;
        /// How much stands about in the streets, on vacant plots and in gardens (bins, containers, bicycles, benches): 1 is
        /// a common suburb, 0 has none of it.
        clutter: f64 = 1.0, 0 to 3;
        /// Share of the streets lined by closed rows of tall houses at the sidewalk, with shops.
        city_share: f64 = 0.0, 0 to 1;
        /// Share of the streets beside which there are car parks, some with a market.
        car_park_share: f64 = 0.0, 0 to 1;
        /// Share of the other streets lined by works and offices with their yards.
        industrial_share: f64 = 0.0, 0 to 1;
        /// Share of the other streets lined by institutes behind lawns.
        campus_share: f64 = 0.0, 0 to 1;
    }
}

impl PropConfig {
    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], naming the value and its limits.
    pub fn check(&self) -> Result<()> {
        self.check_settings()?;
        if self.house_shares.iter().sum::<f64>() <= 0.0 {
            let value = format!("{:?}", self.house_shares);
            return Err(Error::OutOfRange { what: "house_shares", value, expected: "a weight above 0".to_owned() });
        }
        Ok(())
    }
}
