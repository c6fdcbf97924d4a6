//! The receiver, 64 arrivals of a ring together: what it detects of them and reports, and the points that are written.

use macro_rules_attribute::{apply, derive};

use super::arrivals::Arrival;
use super::returned_points::{ReturnSurface, Scan};
use crate::lidar::detection::{RingReceiver, intensity, saturated};
use crate::lidar::echoes::Draws;
use crate::zeros::DefaultZeros;
use cadet_base::material::Semantic;

/// Echoes that are received together.
const BATCH_SIZE: usize = 64;

type PerEcho = [f64; BATCH_SIZE];

/// What arrives from the beams of one ring and waits for the receiver.
pub(crate) struct EchoBatch {
    n: usize,
    column: [i32; BATCH_SIZE],
    actor_id: [i32; BATCH_SIZE],
    semantic: [Semantic; BATCH_SIZE],
    number: [u8; BATCH_SIZE],
    surface: [ReturnSurface; BATCH_SIZE],
    echo: Echoes,
    written: Written,
}

#[derive(DefaultZeros!)]
struct Echoes {
    range_m: PerEcho,
    /// Reflectance / range^2 at the receiver.
    power: PerEcho,
    saturates: [bool; BATCH_SIZE],
    is_surface: [bool; BATCH_SIZE],
    /// Of surfaces, otherwise 1.
    cos_incidence: PerEcho,
    reading_noise: PerEcho,
    draws: [Draws; BATCH_SIZE],
    /// The beam as it is reported.
    direction_velo: [PerEcho; 3],
    origin_velo: [PerEcho; 3],
}

/// What comes out.
#[derive(DefaultZeros!)]
struct Written {
    point_velo: [[f32; BATCH_SIZE]; 3],
    intensity: [f32; BATCH_SIZE],
    range_m: PerEcho,
    is_kept: [bool; BATCH_SIZE],
}

impl EchoBatch {
    pub(crate) fn new() -> Box<Self> {
        Box::new(Self {
            n: 0,
            column: [0; BATCH_SIZE],
            actor_id: [0; BATCH_SIZE],
            semantic: [Semantic::Sky; BATCH_SIZE],
            number: [0; BATCH_SIZE],
            surface: [ReturnSurface::AIR; BATCH_SIZE],
            echo: Echoes::default(),
            written: Written::default(),
        })
    }

    /// Adds what arrives from a ring's column, whose beam is reported to start and to go so.
    #[inline(always)]
    pub(crate) fn push(
        &mut self,
        arrival: &Arrival,
        draws: &Draws,
        column: usize,
        [origin_velo, direction_velo]: [[f64; 3]; 2],
    ) {
        let (i, e) = (self.n, &mut self.echo);
        self.column[i] = column as i32;
        self.actor_id[i] = arrival.actor_id;
        self.semantic[i] = arrival.semantic;
        self.number[i] = arrival.number;
        self.surface[i] = arrival.surface;
        e.range_m[i] = arrival.range_m;
        e.power[i] = arrival.power;
        e.saturates[i] = arrival.saturates;
        e.is_surface[i] = arrival.cos_incidence.is_some();
        e.cos_incidence[i] = arrival.cos_incidence.unwrap_or(1.0);
        e.reading_noise[i] = arrival.reading_noise;
        e.draws[i] = *draws;
        for axis in 0..3 {
            e.direction_velo[axis][i] = direction_velo[axis];
            e.origin_velo[axis][i] = origin_velo[axis];
        }
        self.n += 1;
    }

    pub(crate) fn is_full(&self) -> bool {
        self.n == BATCH_SIZE
    }

    /// Receives what waits and writes what is detected, its surfaces too if they are recorded.
    pub(crate) fn receive(&mut self, receiver: &RingReceiver, ring: usize, records_surfaces: bool, out: &mut Scan) {
        receive(&self.echo, *receiver, &mut self.written);
        let w = &self.written;
        // Without branches: which returns are kept is hard to predict.
        let (mut kept, mut n) = ([0; BATCH_SIZE], 0);
        for i in 0..self.n {
            kept[n] = i;
            n += usize::from(w.is_kept[i]);
        }
        let kept = &kept[..n];
        let [x, y, z] = &w.point_velo;
        out.points_velo.extend(kept.iter().map(|i| [x[*i], y[*i], z[*i], w.intensity[*i]]));
        out.ring.extend(std::iter::repeat_n(ring as i32, n));
        out.column.extend(kept.iter().map(|i| self.column[*i]));
        out.actor_id.extend(kept.iter().map(|i| self.actor_id[*i]));
        out.semantic.extend(kept.iter().map(|i| self.semantic[*i]));
        out.echo.extend(kept.iter().map(|i| self.number[*i]));
        out.range_m.extend(kept.iter().map(|i| w.range_m[*i]));
        if records_surfaces {
            out.surface.extend(kept.iter().map(|i| self.surface[*i]));
        }
        self.n = 0;
    }
}

/// Compiled once more for processors with wide registers, as the kernel is.
#[apply(for_wide_registers)]
fn receive(e: &Echoes, ring: RingReceiver, out: &mut Written) {
    let RingReceiver { receiver, laser, min_range_m, max_range_m, .. } = ring;
    let (mut reading, mut detected_power): (PerEcho, PerEcho) = ([0.0; BATCH_SIZE], [0.0; BATCH_SIZE]);
    for i in 0..BATCH_SIZE {
        let share = ring.detected_share(e.range_m[i], e.cos_incidence[i]);
        detected_power[i] = e.power[i] * if e.is_surface[i] { share } else { 1.0 };
    }
    for i in 0..BATCH_SIZE {
        let (range_m, power) = (e.range_m[i], e.power[i]);
        let peak = power * range_m * range_m * ring.peak_share(range_m, e.cos_incidence[i]);
        reading[i] = intensity(peak, range_m, laser.gain, e.reading_noise[i] * e.draws[i].gain_deviate());
    }
    for i in 0..BATCH_SIZE {
        let reading = if e.saturates[i] { saturated(e.draws[i].saturation_chance()) } else { reading[i] };
        out.intensity[i] = (round(reading * 1e2).clamp(0.0, 99.0) / 1e2) as f32;
    }
    for i in 0..BATCH_SIZE {
        let (range_m, power) = (e.range_m[i], e.power[i]);
        let range_m = range_m + laser.range_offset_m + receiver.noise_m(power) * e.draws[i].range_deviate();
        out.range_m[i] = range_m;
        let mut square = [0.0; 3];
        for axis in 0..3 {
            let at = e.direction_velo[axis][i] * range_m + e.origin_velo[axis][i];
            let at = (round(at * 1e3) / 1e3) as f32;
            out.point_velo[axis][i] = at;
            square[axis] = f64::from(at) * f64::from(at);
        }
        // What is kept is judged by the written point, from the frame's origin, as in KITTI's files.
        let written_m = (square[0] + square[1] + square[2]).sqrt();
        let is_detected = receiver.detects(detected_power[i], e.draws[i].detection_chance());
        out.is_kept[i] = is_detected & (written_m >= min_range_m) & (written_m < max_range_m);
    }
}

/// The nearest whole number, for numbers below 2^51: adding 1.5 * 2^52 leaves no place for a fraction. Without SSE 4.1
/// `round` is a call.
#[inline(always)]
fn round(x: f64) -> f64 {
    const NO_FRACTION: f64 = 6_755_399_441_055_744.0;
    (x + NO_FRACTION) - NO_FRACTION
}
