//! A LIDAR's table: read from a `cadet.BeamTable`, and given as a dictionary of its fields.

use cadet_core::Error;
use cadet_core::lidar::{
    Aim, BlindSector, Firing as CoreFiring, LaserReceiver, LidarSpec, Raster, Receiver, Rosette, Spin, SpinDirection,
};
use cadet_core::math::TAU;
use cadet_core::sense::LaserRing;
use pyo3::prelude::*;

/// Equal steps of azimuth.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) struct UniformFiring {
    columns: usize,
}

/// Even firings, reported at the nearest tick of an encoder.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) struct EncoderFiring {
    ticks_per_turn: u32,
    ticks_per_firing: f64,
    firings: usize,
    phase_ticks: f64,
}

/// Any azimuths.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) struct ListedFiring {
    azimuths_deg: Vec<f64>,
}

/// Lines from the left to the right, from the top to the bottom.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) struct RasterFiring {
    lines: usize,
    columns: usize,
    azimuth_span_deg: [f64; 2],
    elevation_span_deg: [f64; 2],
}

/// What two turning prisms draw.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) struct RosetteFiring {
    firings: usize,
    deflections_deg: [f64; 2],
    prism_rates_hz: [f64; 2],
}

/// Any directions at any times.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) struct TableFiring {
    /// Time, azimuth and elevation.
    aims: Vec<(f64, f64, f64)>,
}

/// Where all lasers point when they fire.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) enum Firing {
    // The first whose fields an object has: those with more of them stand first.
    Encoder(EncoderFiring),
    Raster(RasterFiring),
    Rosette(RosetteFiring),
    Table(TableFiring),
    Listed(ListedFiring),
    Uniform(UniformFiring),
}

/// One laser: a ring of the scan.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) struct Laser {
    elevation_deg: f64,
    height_m: f64,
    left_m: f64,
    azimuth_offset_deg: f64,
    gain: f64,
    range_offset_m: f64,
    focus_m: f64,
    blind_deg: Vec<(f64, f64)>,
}

/// A LIDAR.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) struct BeamTable {
    name: String,
    rings: Vec<Laser>,
    firing: Firing,
    min_range_m: f64,
    max_range_m: f64,
    range_noise_m: f64,
    detection_range_m: f64,
    beam_mrad: f64,
    pulse_ns: f64,
    halo_share: f64,
    halo_mrad: f64,
    spin: String,
    rate_hz: f64,
    start_azimuth_deg: f64,
}

impl BeamTable {
    /// The table of a sensor, angles rounded to a billionth of a degree.
    pub(crate) fn of(spec: &LidarSpec) -> Self {
        let lasers = spec.rings().iter().zip(spec.azimuth_offsets_rad()).zip(&spec.laser_receivers).enumerate();
        let blind_deg = |ring: usize| {
            let sectors = spec.blind_sectors.iter().filter(|s| s.ring == ring);
            sectors.map(|s| (degrees(s.from_rad), degrees(s.to_rad))).collect()
        };
        let laser = |(ring, ((laser, offset_rad), receiver)): (usize, ((&LaserRing, &f64), &LaserReceiver))| Laser {
            elevation_deg: degrees(laser.elevation_rad),
            height_m: rounded(laser.height_m),
            left_m: rounded(laser.left_m),
            azimuth_offset_deg: degrees(*offset_rad),
            gain: rounded(receiver.gain),
            range_offset_m: rounded(receiver.range_offset_m),
            focus_m: rounded(receiver.focus_m),
            blind_deg: blind_deg(ring),
        };
        Self {
            name: spec.name().to_owned(),
            rings: lasers.map(laser).collect(),
            firing: firing_of(spec.firing()),
            min_range_m: spec.min_range_m,
            max_range_m: spec.max_range_m,
            range_noise_m: spec.receiver().range_noise_m,
            detection_range_m: spec.receiver().detection_range_m,
            beam_mrad: rounded(spec.receiver().divergence_rad * 1e3),
            pulse_ns: rounded(spec.receiver().pulse_s * 1e9),
            halo_share: spec.receiver().halo_share,
            halo_mrad: rounded(spec.receiver().halo_rad * 1e3),
            spin: spec.spin.direction.as_ref().to_owned(),
            rate_hz: spec.spin.rate_hz,
            start_azimuth_deg: degrees(spec.spin.start_rad),
        }
    }

    /// The sensor of a table.
    pub(crate) fn spec(&self) -> Result<LidarSpec, Error> {
        let ring = |laser: &Laser| LaserRing {
            elevation_rad: laser.elevation_deg.to_radians(),
            height_m: laser.height_m,
            left_m: laser.left_m,
        };
        let offsets_rad = self.rings.iter().map(|laser| laser.azimuth_offset_deg.to_radians()).collect();
        let rings = self.rings.iter().map(ring).collect();
        let mut spec = LidarSpec::with_firing(&self.name, rings, self.firing.to_core(1.0 / self.rate_hz))?
            .staggered(offsets_rad)?;
        (spec.min_range_m, spec.max_range_m) = (self.min_range_m, self.max_range_m);
        let receiver = Receiver {
            pulse_s: self.pulse_ns * 1e-9,
            divergence_rad: self.beam_mrad * 1e-3,
            detection_range_m: self.detection_range_m,
            range_noise_m: self.range_noise_m,
            halo_share: self.halo_share,
            halo_rad: self.halo_mrad * 1e-3,
        };
        spec = spec.with_receiver(receiver)?;
        let receiver = |laser: &Laser| LaserReceiver {
            gain: laser.gain,
            range_offset_m: laser.range_offset_m,
            focus_m: laser.focus_m,
        };
        spec.spin = Spin {
            direction: SpinDirection::from_name(&self.spin)?,
            rate_hz: self.rate_hz,
            start_rad: self.start_azimuth_deg.to_radians(),
        };
        spec.laser_receivers = self.rings.iter().map(receiver).collect();
        // A whole turn must not end beyond its end by rounding.
        let radians = |degrees: f64| degrees.to_radians().min(TAU);
        for (ring, laser) in self.rings.iter().enumerate() {
            let sector = |(from, to): &(f64, f64)| BlindSector { ring, from_rad: radians(*from), to_rad: radians(*to) };
            spec.blind_sectors.extend(laser.blind_deg.iter().map(sector));
        }
        spec.check()?;
        Ok(spec)
    }
}

impl Firing {
    /// The pattern of a sensor that takes a scan in `period_s`.
    fn to_core(&self, period_s: f64) -> CoreFiring {
        match self {
            Self::Uniform(firing) => CoreFiring::Uniform { columns: firing.columns },
            Self::Encoder(firing) => CoreFiring::Encoder {
                ticks_per_turn: firing.ticks_per_turn,
                ticks_per_firing: firing.ticks_per_firing,
                phase_ticks: firing.phase_ticks,
                firings: firing.firings,
            },
            Self::Listed(firing) => CoreFiring::Listed(firing.azimuths_deg.iter().map(|a| a.to_radians()).collect()),
            Self::Raster(firing) => CoreFiring::Raster(Raster {
                lines: firing.lines,
                columns: firing.columns,
                azimuth_rad: firing.azimuth_span_deg.map(f64::to_radians),
                elevation_rad: firing.elevation_span_deg.map(f64::to_radians),
                period_s,
            }),
            Self::Rosette(firing) => CoreFiring::Rosette(Rosette {
                firings: firing.firings,
                deflections_rad: firing.deflections_deg.map(f64::to_radians),
                prism_rates_hz: firing.prism_rates_hz,
                period_s,
            }),
            Self::Table(firing) => {
                let aim = |(time_s, azimuth_deg, elevation_deg): &(f64, f64, f64)| Aim {
                    time_s: *time_s,
                    azimuth_rad: azimuth_deg.to_radians(),
                    elevation_rad: elevation_deg.to_radians(),
                };
                CoreFiring::Table(firing.aims.iter().map(aim).collect())
            }
        }
    }
}

fn firing_of(firing: &CoreFiring) -> Firing {
    match firing {
        CoreFiring::Uniform { columns } => Firing::Uniform(UniformFiring { columns: *columns }),
        CoreFiring::Encoder { ticks_per_turn, ticks_per_firing, phase_ticks, firings } => {
            Firing::Encoder(EncoderFiring {
                ticks_per_turn: *ticks_per_turn,
                ticks_per_firing: *ticks_per_firing,
                firings: *firings,
                phase_ticks: *phase_ticks,
            })
        }
        CoreFiring::Listed(azimuths_rad) => {
            Firing::Listed(ListedFiring { azimuths_deg: azimuths_rad.iter().map(|a| degrees(*a)).collect() })
        }
        CoreFiring::Raster(raster) => Firing::Raster(RasterFiring {
            lines: raster.lines,
            columns: raster.columns,
            azimuth_span_deg: raster.azimuth_rad.map(degrees),
            elevation_span_deg: raster.elevation_rad.map(degrees),
        }),
        CoreFiring::Rosette(rosette) => Firing::Rosette(RosetteFiring {
            firings: rosette.firings,
            deflections_deg: rosette.deflections_rad.map(degrees),
            prism_rates_hz: rosette.prism_rates_hz,
        }),
        CoreFiring::Table(aims) => Firing::Table(TableFiring {
            aims: aims.iter().map(|aim| (aim.time_s, degrees(aim.azimuth_rad), degrees(aim.elevation_rad))).collect(),
        }),
    }
}

fn degrees(radians: f64) -> f64 {
    rounded(radians.to_degrees())
}

fn rounded(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
}
