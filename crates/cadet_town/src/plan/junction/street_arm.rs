//! The arms of a junction: the ends of the streets that meet there.

use crate::plan::{LineStyle, PlanPose, WhichEnd};
use cadet_base::math::DVec2;
use cadet_base::plane::unit;

/// One end of a street.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct StreetEnd {
    pub street: usize,
    pub end: WhichEnd,
}

/// A street's arm at a junction.
pub(crate) struct StreetArm {
    pub from: StreetEnd,
    /// The middle of the junction.
    pub center: DVec2,
    /// Out of the junction.
    pub heading_rad: f64,
    pub style: LineStyle,
    /// How far from the middle of the junction the street ends.
    pub cut_m: f64,
}

impl StreetArm {
    /// Where the middle of the street ends, looking out of the junction.
    pub fn pose(&self) -> PlanPose {
        PlanPose::new(self.center + unit(self.heading_rad) * self.cut_m, self.heading_rad)
    }
}
