//! Sensors by name.

use super::hdl64e;
use super::spec::LidarSpec;
use crate::lidar::scan_pattern::Firing;
use crate::sense::LaserRing;
use cadet_base::error::{Error, Result};

/// A sensor's name and what makes it.
type Preset = (&'static str, fn() -> LidarSpec);

/// The sensors that are made in code; others are data of the Python package.
const BY_NAME: [Preset; 3] = [
    ("hdl64e_kitti", LidarSpec::hdl64e_kitti),
    ("hdl64e_uniform", LidarSpec::hdl64e_uniform),
    ("cadet", LidarSpec::cadet),
];

/// The names that [`LidarSpec::preset`] knows.
pub const PRESETS: [&str; BY_NAME.len()] = {
    let mut names = [""; BY_NAME.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = BY_NAME[i].0;
        i += 1;
    }
    names
};

/// (elevation in degrees, height of the laser's origin in meters) of KITTI's HDL-64E, from the top ring down; fitted to
/// its scans with a median residual of 0.25 mm.
#[rustfmt::skip]
const HDL64E: [(f64, f64); 64] = [
    (1.937, 0.2091), (1.574, 0.2086), (1.305, 0.2083), (0.872, 0.2077),
    (0.579, 0.2073), (0.181, 0.2068), (-0.089, 0.2064), (-0.452, 0.2060),
    (-0.803, 0.2056), (-1.201, 0.2051), (-1.494, 0.2048), (-1.833, 0.2044),
    (-2.208, 0.2040), (-2.547, 0.2036), (-2.874, 0.2032), (-3.236, 0.2028),
    (-3.539, 0.2025), (-3.936, 0.2021), (-4.215, 0.2018), (-4.588, 0.2015),
    (-4.914, 0.2011), (-5.251, 0.2008), (-5.611, 0.2005), (-5.958, 0.2001),
    (-6.329, 0.1998), (-6.676, 0.1995), (-6.999, 0.1992), (-7.287, 0.1990),
    (-7.679, 0.1987), (-8.058, 0.1983), (-8.310, 0.1981), (-8.711, 0.1978),
    (-9.026, 0.1258), (-9.574, 0.1254), (-10.063, 0.1251), (-10.471, 0.1247),
    (-10.957, 0.1244), (-11.599, 0.1239), (-12.115, 0.1235), (-12.562, 0.1233),
    (-13.041, 0.1229), (-13.485, 0.1226), (-14.048, 0.1223), (-14.598, 0.1219),
    (-15.189, 0.1215), (-15.657, 0.1212), (-16.176, 0.1209), (-16.554, 0.1207),
    (-17.187, 0.1203), (-17.730, 0.1200), (-18.323, 0.1196), (-18.797, 0.1194),
    (-19.320, 0.1191), (-19.736, 0.1188), (-20.223, 0.1186), (-20.788, 0.1183),
    (-21.318, 0.1180), (-21.936, 0.1176), (-22.438, 0.1174), (-22.857, 0.1172),
    (-23.322, 0.1169), (-23.971, 0.1166), (-24.507, 0.1163), (-24.999, 0.1161),
];

impl LidarSpec {
    /// The HDL-64E of KITTI's car: each laser at its own height, azimuths on the ticks of the encoder
    /// (0.09 degrees, of which a firing takes 1.8587): 2,152 columns, 137,728 beams, 6 % of which KITTI's car hides. Each
    /// laser's range is off by its own.
    #[must_use]
    pub fn hdl64e_kitti() -> Self {
        let firing =
            Firing::Encoder { ticks_per_turn: 4000, ticks_per_firing: 1.8587, phase_ticks: 0.0, firings: 2152 };
        let mut spec = hdl64e_spec("hdl64e_kitti", firing);
        spec.blind_sectors = hdl64e::car();
        for (laser, offset_mm) in spec.laser_receivers.iter_mut().zip(hdl64e::RANGE_OFFSETS_MM) {
            laser.range_offset_m = offset_mm / 1e3;
        }
        spec
    }

    /// The HDL-64E's elevations from one origin and 2,083 equal azimuth steps: 133,312 beams, the benchmark's scan.
    #[must_use]
    pub fn hdl64e_uniform() -> Self {
        hdl64e_spec("hdl64e_uniform", Firing::Uniform { columns: 2083 }).single_origin().renamed("hdl64e_uniform")
    }

    /// The LIDAR of the 2019 paper: 40 beams from +7 to -16 degrees out of one origin, 720,000 beams a second at 10 Hz.
    #[must_use]
    pub fn cadet() -> Self {
        let ring = |k: usize| LaserRing::on_axis((7.0 - 23.0 * k as f64 / 39.0).to_radians(), 0.0);
        Self::with_firing("cadet", (0..40).map(ring).collect(), Firing::Uniform { columns: 1800 })
            .expect("a valid preset")
    }

    /// The preset of that name.
    ///
    /// # Errors
    /// [`Error::Unknown`], listing [`PRESETS`].
    pub fn preset(name: &str) -> Result<Self> {
        BY_NAME.iter().find(|(known, _)| *known == name).map(|(_, make)| make()).ok_or_else(|| Error::Unknown {
            what: "lidar",
            name: name.to_owned(),
            known: PRESETS.join(", "),
        })
    }
}

/// How far beside the axis KITTI's lasers sit: even rings to the right, odd ones to the left. With it all azimuths of its
/// scans lie on ticks of the encoder, up to the rounding of coordinates and a constant of each laser.
const HDL64E_LEFT_M: f64 = 0.026;

fn hdl64e_rings() -> Vec<LaserRing> {
    let left_m = |ring: usize| if ring.is_multiple_of(2) { -HDL64E_LEFT_M } else { HDL64E_LEFT_M };
    let ring = |(ring, (degrees, height_m)): (usize, (f64, f64))| LaserRing {
        elevation_rad: degrees.to_radians(),
        height_m,
        left_m: left_m(ring),
    };
    HDL64E.into_iter().enumerate().map(ring).collect()
}

fn hdl64e_spec(name: &str, firing: Firing) -> LidarSpec {
    let mut spec = LidarSpec::with_firing(name, hdl64e_rings(), firing).expect("a valid preset");
    for (ring, (laser, gain)) in spec.laser_receivers.iter_mut().zip(hdl64e::GAINS).enumerate() {
        laser.gain = gain;
        laser.focus_m = hdl64e::FOCUS_M[usize::from(ring >= 32)];
    }
    spec
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::math::{self, TAU};

    #[test]
    fn beams_are_counted_as_the_sensors_do() {
        let kitti = LidarSpec::hdl64e_kitti();
        assert_eq!((kitti.num_beams(), kitti.azimuths_rad().len()), (137_728, 2152));
        assert_eq!(LidarSpec::hdl64e_uniform().num_beams(), 133_312);
        assert_eq!(LidarSpec::cadet().num_beams(), 72_000);
        // Reported in steps of one tick and of two, in KITTI's proportion.
        let tick = TAU / 4000.0;
        let turned = |(azimuth, [cos, sin]): (&f64, &[f64; 2])| azimuth + math::atan2(*sin, *cos);
        let reported: Vec<f64> = kitti.azimuths_rad().iter().zip(kitti.reporting_turns()).map(turned).collect();
        let steps: Vec<f64> = reported.windows(2).map(|w| ((w[1] - w[0]) / tick).round()).collect();
        let ones = steps.iter().filter(|s| **s == 1.0).count() as f64 / steps.len() as f64;
        assert!(steps.iter().all(|s| *s == 1.0 || *s == 2.0) && (ones - 0.145).abs() < 0.01, "{ones}");
        assert!((kitti.azimuths_rad()[2151] + 2.0 * tick - TAU).abs() < 1.01 * tick);
    }

    #[test]
    fn names_are_a_closed_list() {
        for name in PRESETS {
            assert_eq!(LidarSpec::preset(name).expect(name).name(), name);
        }
        let text = LidarSpec::preset("hdl16").expect_err("unknown").to_string();
        assert!(text.contains("hdl16") && text.contains("hdl64e_kitti"), "{text}");
    }
}
