//! What kind of suburb is made.

use crate::error::{Error, Result};

/// What kind of suburb to make.
#[derive(Debug, Clone, PartialEq)]
pub struct SuburbConfig {
    /// Number of blocks from side to side, in two directions: 2 to 12.
    pub blocks: (usize, usize),
    /// Shortest and longest block, 60 to 250 m.
    pub block_m: (f64, f64),
    /// Share of kerbs with parking bays on streets wide enough for them, 0 to 1.
    pub parking_share: f64,
    /// Share of the streets with bays where cars stand at an angle or across in some of them, 0 to 1.
    pub angled_share: f64,
    /// Share of suburbs with hill streets, 0 to 1.
    pub hilly_share: f64,
    /// Steepest slope of a hilly suburb, 0 to 0.1.
    pub max_slope: f64,
}

impl Default for SuburbConfig {
    fn default() -> Self {
        Self {
            blocks: (4, 4),
            block_m: (72.0, 112.0),
            parking_share: 0.55,
            angled_share: 0.3,
            hilly_share: 0.2,
            max_slope: 0.065,
        }
    }
}

impl SuburbConfig {
    pub(super) fn check(&self) -> Result<()> {
        let out_of_range = |what: &'static str, value: String, expected: &str| {
            Err(Error::OutOfRange { what, value, expected: expected.to_owned() })
        };
        if !(2..=12).contains(&self.blocks.0) || !(2..=12).contains(&self.blocks.1) {
            return out_of_range("suburb blocks", format!("{:?}", self.blocks), "2 to 12 in each direction");
        }
        if !(60.0 <= self.block_m.0 && self.block_m.0 <= self.block_m.1 && self.block_m.1 <= 250.0) {
            return out_of_range("suburb block_m", format!("{:?}", self.block_m), "60 <= shortest <= longest <= 250");
        }
        for (what, value, most) in [
            ("suburb parking_share", self.parking_share, 1.0),
            ("suburb angled_share", self.angled_share, 1.0),
            ("suburb hilly_share", self.hilly_share, 1.0),
            ("suburb max_slope", self.max_slope, 0.1),
        ] {
            if !(0.0..=most).contains(&value) {
                return out_of_range(what, value.to_string(), &format!("0 to {most}"));
            }
        }
        Ok(())
    }
}
