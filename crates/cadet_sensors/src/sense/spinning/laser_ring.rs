//! One laser of a spinning LIDAR.

use cadet_base::math::{self, DVec3};

/// One laser of a spinning LIDAR.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaserRing {
    /// Elevation of the beam over the horizon.
    pub elevation_rad: f64,
    /// Height of the laser's origin over the sensor's frame.
    pub height_m: f64,
    /// How far to the left of the axis the laser sits, as it looks: its beams pass the axis at this distance.
    pub left_m: f64,
}

impl LaserRing {
    /// A laser on the axis.
    #[must_use]
    pub fn on_axis(elevation_rad: f64, height_m: f64) -> Self {
        Self { elevation_rad, height_m, left_m: 0.0 }
    }

    /// The unit vectors along its beams in the sensor's frame, by their headings (cosine and sine of the azimuth).
    pub fn directions_velo(&self) -> impl Fn([f64; 2]) -> DVec3 + use<> {
        let (level, up) = (math::cos(self.elevation_rad), math::sin(self.elevation_rad));
        move |[cos, sin]| DVec3::new(level * cos, level * sin, up)
    }

    /// Where a beam with this heading (cosine and sine of its azimuth) starts, in the sensor's frame.
    #[must_use]
    pub fn origin_velo(&self, [cos, sin]: [f64; 2]) -> DVec3 {
        DVec3::new(-self.left_m * sin, self.left_m * cos, self.height_m)
    }
}
