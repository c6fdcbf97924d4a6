//! How a town is dressed.

use crate::error::{Error, Result};

/// How to dress a town.
#[derive(Debug, Clone, PartialEq)]
pub struct DressingConfig {
    /// Weights of the house kinds, in the order of [`crate::assets::scenery::HouseKind::ALL`].
    pub house_shares: [f64; 6],
    /// How green it is: 1 is a common suburb, 0 has no trees; at most 2.
    pub greenery: f64,
    /// Depth of the belt of trees behind the outermost plots, 0 to 120 m.
    pub belt_m: f64,
}

impl Default for DressingConfig {
    fn default() -> Self {
        Self { house_shares: [0.35, 0.15, 0.15, 0.15, 0.08, 0.12], greenery: 1.0, belt_m: 40.0 }
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
        if !(0.0..=120.0).contains(&self.belt_m) {
            return out_of_range("dressing belt_m", self.belt_m.to_string(), "0 to 120 m");
        }
        Ok(())
    }
}
