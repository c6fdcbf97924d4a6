//! Sensors by their makers' data sheets; docs/lidars.md names the source of every number.
//!
//! Lasers that leave their lens at a radius n from the axis seem to leave the axis at -n tan(elevation): beams and axis
//! lie in one plane.

use super::firing::Firing;
use super::response::Receiver;
use super::spec::LidarSpec;
use crate::math::{self, TAU};
use crate::sense::LaserRing;

/// Turns a second of all of them.
const TURNS_PER_S: f64 = 10.0;

impl LidarSpec {
    /// Velodyne's HDL-32E at 10 turns a second: 32 lasers from +10.67 to -30.67 degrees, 2,170 columns.
    ///
    /// One laser fires each 1.152 microseconds and the whole set each 46.08, so that every ring stands at azimuths of
    /// its own. Heights are not documented: all lasers leave one point.
    #[must_use]
    pub fn hdl32e() -> Self {
        // The data sheet's table: two banks of 16, fired in turn, 4/3 of a degree apart, lowest first.
        let elevation_deg =
            |k: usize| if k.is_multiple_of(2) { -92.0 / 3.0 } else { -28.0 / 3.0 } + 4.0 / 3.0 * (k / 2) as f64;
        let ring = |k: usize| LaserRing::on_axis(elevation_deg(k).to_radians(), 0.0);
        let mut spec = staggered("hdl32e", (0..32).map(ring).collect(), 46.08e-6, 1.152e-6);
        (spec.min_range_m, spec.max_range_m) = (1.0, 100.0);
        noisy(spec, 0.02)
    }

    /// Velodyne's VLP-16 at 10 turns a second: 16 lasers from +15 to -15 degrees, 1,808 columns.
    ///
    /// One laser fires each 2.304 microseconds and the whole set each 55.296; vertical offsets of up to 11.2 mm.
    #[must_use]
    pub fn vlp16() -> Self {
        // In the order in which they fire: -15, 1, -13, 3, ... -1, 15.
        let elevation_deg = |k: usize| if k.is_multiple_of(2) { -15.0 } else { 1.0 } + (k / 2 * 2) as f64;
        /// The manual's vertical corrections for 1, 3, ... 15 degrees below the horizon.
        const BELOW_MM: [f64; 8] = [0.7, 2.2, 3.7, 5.1, 6.6, 8.1, 9.7, 11.2];
        let ring = |k: usize| {
            let degrees = elevation_deg(k);
            let height_mm = BELOW_MM[(degrees.abs() as usize - 1) / 2];
            let up = if degrees > 0.0 { -1e-3 } else { 1e-3 };
            LaserRing::on_axis(degrees.to_radians(), up * height_mm)
        };
        let mut spec = staggered("vlp16", (0..16).map(ring).collect(), 55.296e-6, 2.304e-6);
        (spec.min_range_m, spec.max_range_m) = (1.0, 100.0);
        noisy(spec, 0.015)
    }

    /// A sensor like Ouster's OS1-64 (45 degrees): 64 lasers in equal steps from +22.5 to -22.5 degrees, 1,024 columns.
    #[must_use]
    pub fn os1_64() -> Self {
        os1("os1_64", 64, 1024)
    }

    /// A sensor like Ouster's OS1-128 (45 degrees): 128 lasers from +22.5 to -22.5 degrees, 2,048 columns.
    #[must_use]
    pub fn os1_128() -> Self {
        os1("os1_128", 128, 2048)
    }
}

/// A Velodyne that fires one laser after the other, given in that order, each `laser_s` after the last and the next set
/// `set_s` after this one.
fn staggered(name: &str, fired: Vec<LaserRing>, set_s: f64, laser_s: f64) -> LidarSpec {
    let columns = (1.0 / (TURNS_PER_S * set_s)).floor() as usize;
    // Seen from above it turns clockwise: what fires later stands clockwise of what fired before.
    let offset_rad = |k: usize| -(k as f64) * laser_s * TURNS_PER_S * TAU;
    let mut rings: Vec<(LaserRing, f64)> = fired.into_iter().enumerate().map(|(k, r)| (r, offset_rad(k))).collect();
    rings.sort_by(|a, b| b.0.elevation_rad.total_cmp(&a.0.elevation_rad));
    let (rings, offsets_rad): (Vec<_>, Vec<_>) = rings.into_iter().unzip();
    LidarSpec::with_firing(name, rings, Firing::Uniform { columns })
        .and_then(|spec| spec.staggered(offsets_rad))
        .expect("a valid preset")
}

/// The same sensor with this noise of its ranges; no other receiver than the HDL-64E's has been measured.
fn noisy(spec: LidarSpec, range_noise_m: f64) -> LidarSpec {
    let receiver = Receiver { range_noise_m, ..*spec.receiver() };
    spec.with_receiver(receiver).expect("a valid preset")
}

/// Lasers and receivers stand in four columns, 1.41 and 4.22 degrees to either side of the encoder's angle: 4 and 12 of
/// 1,024 columns, 8 and 24 of 2,048. A whole turn is the same without them.
fn os1(name: &str, rings: usize, columns: usize) -> LidarSpec {
    const LENS_RADIUS_M: f64 = 0.015_806;
    let ring = |k: usize| {
        let elevation_rad = (22.5 - 45.0 * k as f64 / (rings - 1) as f64).to_radians();
        LaserRing::on_axis(elevation_rad, -LENS_RADIUS_M * math::tan(elevation_rad))
    };
    let mut spec = LidarSpec::with_firing(name, (0..rings).map(ring).collect(), Firing::Uniform { columns })
        .expect("a valid preset");
    (spec.min_range_m, spec.max_range_m) = (0.8, 120.0);
    noisy(spec, 0.015)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_fields_of_view_are_the_data_sheets() {
        // Beams a turn, elevations in degrees, points a second that the makers state (single return).
        for (spec, top, bottom, per_s) in [
            (LidarSpec::hdl32e(), 10.67, -30.67, 694_400.0),
            (LidarSpec::vlp16(), 15.0, -15.0, 289_352.0),
            (LidarSpec::os1_64(), 22.5, -22.5, 655_360.0),
            (LidarSpec::os1_128(), 22.5, -22.5, 2_621_440.0),
        ] {
            let rings = spec.rings();
            let (first, last) =
                (rings[0].elevation_rad.to_degrees(), rings[rings.len() - 1].elevation_rad.to_degrees());
            assert!((first - top).abs() < 0.005 && (last - bottom).abs() < 0.005, "{first} {last}");
            assert!(rings.windows(2).all(|w| w[0].elevation_rad > w[1].elevation_rad), "rings run from the top down");
            let beams_per_s = TURNS_PER_S * spec.num_beams() as f64;
            assert!((beams_per_s / per_s - 1.0).abs() < 1e-3, "{}: {beams_per_s} {per_s}", spec.name());
        }
    }

    #[test]
    fn the_hdl32e_hops_between_its_banks() {
        let spec = LidarSpec::hdl32e();
        // The manual's firing order: -30.67, -9.33, -29.33, -8.00, ... -10.67, 10.67.
        let sets_rad = 46.08e-6 * TURNS_PER_S * TAU;
        for (order, degrees) in [(0, -30.67), (1, -9.33), (2, -29.33), (15, 0.0), (16, -20.0), (31, 10.67)] {
            let ring = spec.rings().iter().position(|r| (r.elevation_rad.to_degrees() - degrees).abs() < 0.01);
            let offset = spec.azimuth_offsets_rad()[ring.expect("a laser of the table")];
            let late = f64::from(order) * 1.152e-6 * TURNS_PER_S * TAU;
            let expected = if order == 0 { 0.0 } else { TAU / 2170.0 - late };
            assert!((offset - expected).abs() < 1e-3 * sets_rad, "{degrees}: {offset} {expected}");
        }
    }

    #[test]
    fn the_vlp16s_lasers_seem_to_leave_one_circle() {
        // The manual's table is what a circle of 41.9 mm gives, to its rounding.
        for ring in LidarSpec::vlp16().rings() {
            assert!((ring.height_m + 0.0419 * math::tan(ring.elevation_rad)).abs() < 1e-4, "{ring:?}");
        }
    }
}
