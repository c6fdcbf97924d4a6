//! What a LIDAR is: its lasers, when they fire, and what it can see.

use std::sync::Arc;

use super::divergence::DivergentBeams;
use crate::lidar::detection::{LaserReceiver, MAX_DIVERGENCE_RAD, Receiver, ReturnMode, RingReceiver};
use crate::lidar::scan_pattern::{Aim, Firing, HalvesMade, Spin, azimuths_of};
use crate::sense::{LaserRing, SpinningGrid};
use cadet_base::error::{Error, Result, finite, within};
use cadet_base::math::{DPose3, TAU};

/// A LIDAR: lasers that fire together, in turns or along a path.
#[derive(Debug, Clone)]
pub struct LidarSpec {
    name: String,
    rings: Vec<LaserRing>,
    firing: Firing,
    pub(super) azimuths_rad: Vec<f64>,
    pub(super) azimuth_offsets_rad: Vec<f64>,
    reporting_turns: Vec<[f64; 2]>,
    pub(super) scanner: Scanner,
    receiver: Receiver,
    /// None for beams that meet surfaces as lines do.
    divergent: Option<Arc<DivergentBeams>>,
    /// Returns nearer than this to the frame's origin are not kept.
    pub min_range_m: f64,
    /// Returns as far from the frame's origin as this, or farther, are not kept.
    pub max_range_m: f64,
    /// What tells each ring's receiver from the others.
    pub laser_receivers: Vec<LaserReceiver>,
    /// Which echo is reported where a beam meets several surfaces.
    pub returns: ReturnMode,
    /// How it turns.
    pub spin: Spin,
    /// Whether a scan tells what each point's surface is ([`crate::lidar::Scan::surface`]).
    pub records_surfaces: bool,
    /// Whether the sensor and the world move while it turns ([`crate::lidar::scan_in_motion`]).
    pub rolling: bool,
    /// Where the car that carries the sensor is in the way: beams in these sectors never return. Ideal scans ignore them.
    pub blind_sectors: Vec<BlindSector>,
}

/// What points the lasers.
#[derive(Debug, Clone)]
pub(super) enum Scanner {
    /// A head that spins: every laser fires at the same azimuths. With the halves of its turn, once somebody asks.
    Spinning(SpinningGrid, HalvesMade),
    /// Mirrors or prisms, with where they point at every firing.
    Path(Vec<Aim>),
}

impl Scanner {
    fn spinning(grid: SpinningGrid) -> Self {
        Self::Spinning(grid, Arc::default())
    }
}

/// Azimuths at which a laser meets the car that carries it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlindSector {
    /// Ring, 0 the first of the sensor's table.
    pub ring: usize,
    /// Where the sector begins, counter-clockwise from forward, in [0, 2 pi].
    pub from_rad: f64,
    /// Where it ends, at most 2 pi: a sector across forward is two.
    pub to_rad: f64,
}

impl LidarSpec {
    /// A LIDAR with these rings, each firing at every azimuth (rising, in [0, 2 pi), counter-clockwise from forward).
    ///
    /// Ranges from 1.45 m up to 80 m, equal gains, the HDL-64E's receiver: change the public fields for others, and
    /// [`LidarSpec::with_receiver`].
    ///
    /// # Errors
    /// [`Error::NotFinite`] and [`Error::OutOfRange`], as [`SpinningGrid::new`] gives them.
    pub fn new(name: &str, rings: Vec<LaserRing>, azimuths_rad: Vec<f64>) -> Result<Self> {
        Self::with_firing(name, rings, Firing::Listed(azimuths_rad))
    }

    /// A LIDAR with these rings that all fire in this pattern; the rest as [`LidarSpec::new`] has it.
    ///
    /// # Errors
    /// As [`Firing::azimuths_rad`] and [`SpinningGrid::new`].
    pub fn with_firing(name: &str, rings: Vec<LaserRing>, firing: Firing) -> Result<Self> {
        let (azimuths_rad, scanner) = match firing.aims(0.0)? {
            None => {
                let azimuths_rad = firing.azimuths_rad()?;
                let grid = SpinningGrid::new(DPose3::IDENTITY, &rings, &azimuths_rad)?;
                (azimuths_rad, Scanner::spinning(grid))
            }
            Some(aims) => {
                check_lasers_of_path(&rings, &aims)?;
                (azimuths_of(&aims), Scanner::Path(aims))
            }
        };
        Ok(Self {
            name: name.to_owned(),
            laser_receivers: vec![LaserReceiver::default(); rings.len()],
            blind_sectors: Vec::new(),
            azimuth_offsets_rad: vec![0.0; rings.len()],
            rings,
            reporting_turns: firing.reporting_turns(azimuths_rad.len()),
            firing,
            azimuths_rad,
            scanner,
            divergent: None,
            returns: ReturnMode::Strongest,
            spin: Spin::default(),
            records_surfaces: false,
            rolling: false,
            min_range_m: 1.45,
            max_range_m: 80.0,
            receiver: Receiver::default(),
        })
    }

    /// Returns this sensor with ring k firing at `offsets_rad[k]` counter-clockwise of its columns' azimuths.
    ///
    /// With equal steps, whole ones are taken off: they lead from column to column. Otherwise an offset is at least 0
    /// and smaller than the gap behind the last column.
    ///
    /// # Errors
    /// As [`SpinningGrid::staggered`].
    pub fn staggered(mut self, offsets_rad: Vec<f64>) -> Result<Self> {
        self.azimuth_offsets_rad = offsets_rad.into_iter().map(|o| self.firing.reduced_offset_rad(o)).collect();
        self.regrid()?;
        self.respread()
    }

    fn regrid(&mut self) -> Result<()> {
        if self.spins() {
            let (rings, offsets_rad) = (&self.rings, &self.azimuth_offsets_rad);
            let grid = SpinningGrid::staggered(DPose3::IDENTITY, rings, &self.azimuths_rad, offsets_rad)?;
            self.scanner = Scanner::spinning(grid);
        }
        Ok(())
    }

    fn respread(self) -> Result<Self> {
        if self.divergent.is_some() { self.spread() } else { Ok(self) }
    }

    fn spread(mut self) -> Result<Self> {
        let (rings, azimuths, offsets) = (&self.rings, &self.azimuths_rad, &self.azimuth_offsets_rad);
        self.divergent = Some(Arc::new(DivergentBeams::new(rings, azimuths, offsets, self.receiver.divergence_rad)?));
        Ok(self)
    }

    /// Returns this sensor with another receiver.
    ///
    /// # Errors
    /// As [`Receiver::check`], and as [`LidarSpec::with_divergence`] where beams are split.
    pub fn with_receiver(mut self, receiver: Receiver) -> Result<Self> {
        receiver.check()?;
        self.receiver = receiver;
        self.respread()
    }

    /// Pulse, beam, threshold and noise.
    #[must_use]
    pub fn receiver(&self) -> &Receiver {
        &self.receiver
    }

    /// The receiver of a ring.
    #[must_use]
    pub(crate) fn ring_receiver(&self, ring: usize) -> RingReceiver {
        RingReceiver::new(self.receiver, self.laser_receivers[ring], [self.min_range_m, self.max_range_m])
    }

    /// Checks the public fields, which anyone may have set.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::OutOfRange`] or [`Error::Shape`], naming the field.
    pub fn check(&self) -> Result<()> {
        for (what, value, least) in
            [("min_range_m", self.min_range_m, 0.0), ("max_range_m", self.max_range_m, self.min_range_m)]
        {
            if finite(what, value)? < least {
                return Err(Error::OutOfRange {
                    what,
                    value: value.to_string(),
                    expected: format!("at least {least}"),
                });
            }
        }
        self.spin.check()?;
        if self.laser_receivers.len() != self.rings.len() {
            return Err(Error::Shape {
                what: "laser_receivers",
                got: format!("({},)", self.laser_receivers.len()),
                expected: format!("({},)", self.rings.len()),
            });
        }
        for laser in &self.laser_receivers {
            laser.check()?;
        }
        for sector in &self.blind_sectors {
            let is_rising = finite("blind sector", sector.from_rad)? <= finite("blind sector", sector.to_rad)?;
            if sector.ring >= self.rings.len() || !is_rising || sector.from_rad < 0.0 || sector.to_rad > TAU {
                return Err(Error::OutOfRange {
                    what: "blind sector",
                    value: format!("ring {} from {} to {}", sector.ring, sector.from_rad, sector.to_rad),
                    expected: format!("a ring below {}, azimuths that rise within [0, 2 pi]", self.rings.len()),
                });
            }
        }
        Ok(())
    }

    /// Returns this sensor with beams that open by `divergence_rad` (the full cone), so that they may meet several
    /// surfaces at depth edges; 0 for beams that meet surfaces as lines do, in the receiver's own cone for all else.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a divergence below 0 or above 0.02, for one that tips a beam
    /// beyond 89 degrees, or for more than 32,767 rings.
    pub fn with_divergence(mut self, divergence_rad: f64) -> Result<Self> {
        if !(0.0..=MAX_DIVERGENCE_RAD).contains(&finite("divergence", divergence_rad)?) {
            return Err(Error::OutOfRange {
                what: "divergence",
                value: divergence_rad.to_string(),
                expected: format!("0 to {MAX_DIVERGENCE_RAD} rad"),
            });
        }
        if divergence_rad == 0.0 {
            self.divergent = None;
            return Ok(self);
        }
        if let Scanner::Path(_) = self.scanner {
            // Whether a beam meets an edge is told by its neighbors, and along a path there are none.
            let expected = "0 for a sensor that does not spin".to_owned();
            return Err(Error::OutOfRange { what: "divergence", value: divergence_rad.to_string(), expected });
        }
        let receiver = Receiver { divergence_rad, ..self.receiver };
        receiver.check()?;
        self.receiver = receiver;
        self.spread()
    }

    pub(crate) fn divergent(&self) -> Option<&DivergentBeams> {
        self.divergent.as_deref()
    }

    /// Returns this sensor with every laser in the frame's origin.
    #[must_use]
    pub fn single_origin(mut self) -> Self {
        for ring in &mut self.rings {
            (ring.height_m, ring.left_m) = (0.0, 0.0);
        }
        self.regrid().expect("checked when the spec was made, and 0 is a height");
        self = self.respread().expect("checked when the divergence was set, and 0 is a height");
        let name = format!("{}_single_origin", self.name);
        self.renamed(&name)
    }

    pub(super) fn renamed(mut self, name: &str) -> Self {
        self.name = name.to_owned();
        self
    }

    /// The sensor's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The lasers.
    #[must_use]
    pub fn rings(&self) -> &[LaserRing] {
        &self.rings
    }

    /// When they fire: the azimuth of each column, counter-clockwise from forward.
    #[must_use]
    pub fn azimuths_rad(&self) -> &[f64] {
        &self.azimuths_rad
    }

    /// The pattern of [`LidarSpec::azimuths_rad`].
    #[must_use]
    pub fn firing(&self) -> &Firing {
        &self.firing
    }

    /// How far counter-clockwise of its columns' azimuths each ring fires.
    #[must_use]
    pub fn azimuth_offsets_rad(&self) -> &[f64] {
        &self.azimuth_offsets_rad
    }

    /// How far counter-clockwise of where its beams go each column is reported, as (cosine, sine): an encoder's rounding.
    #[must_use]
    pub(crate) fn reporting_turns(&self) -> &[[f64; 2]] {
        &self.reporting_turns
    }
}

/// A path's lasers leave one point, and tip no beam beyond 89 degrees.
fn check_lasers_of_path(rings: &[LaserRing], aims: &[Aim]) -> Result<()> {
    if rings.is_empty() {
        let expected = "at least 1".to_owned();
        return Err(Error::OutOfRange { what: "number of rings", value: "0".to_owned(), expected });
    }
    let elevations_rad = || aims.iter().map(|aim| aim.elevation_rad);
    let (least, most) = (elevations_rad().fold(f64::MAX, f64::min), elevations_rad().fold(f64::MIN, f64::max));
    let limit_rad = 89.0_f64.to_radians();
    for ring in rings {
        let _ = within("ring elevation", ring.elevation_rad, -limit_rad - least..=limit_rad - most)?;
        let _ = within("left_m of a laser that does not spin", ring.left_m, 0.0..=0.0)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_sensors_are_refused_by_name() {
        let ring = |e: f64| LaserRing::on_axis(e, 0.0);
        let text = |r: Vec<LaserRing>, a: Vec<f64>| LidarSpec::new("x", r, a).expect_err("bad").to_string();
        assert!(text(vec![], vec![0.0]).contains("number of rings is 0"));
        assert!(text(vec![ring(0.0)], vec![]).contains("number of columns is 0"));
        assert!(text(vec![ring(f64::NAN)], vec![0.0]).contains("ring elevation"));
        assert!(text(vec![ring(1.57)], vec![0.0]).contains("ring elevation is 1.57"));
        assert!(text(vec![ring(0.0)], vec![0.2, 0.1]).contains("azimuth is 0.1"));
        assert!(text(vec![ring(0.0)], vec![7.0]).contains("azimuth is 7"));
        let mut spec = LidarSpec::cadet();
        spec.laser_receivers.pop();
        assert!(spec.check().expect_err("short").to_string().contains("laser_receivers has shape (39,)"));
        for (gain, range_offset_m, what) in
            [(-1.0, 0.0, "laser gain is -1"), (1.0, -1.01, "offset is -1.01"), (1.0, f64::NAN, "offset is not finite")]
        {
            spec = LidarSpec::cadet();
            spec.laser_receivers[7] = LaserReceiver { gain, range_offset_m, ..LaserReceiver::default() };
            let text = spec.check().expect_err("bad").to_string();
            assert!(text.contains(what), "{text}");
        }
        spec = LidarSpec::cadet();
        spec.max_range_m = -1.0;
        assert!(spec.check().expect_err("negative").to_string().contains("max_range_m is -1"));
    }
}
