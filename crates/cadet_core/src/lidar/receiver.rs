//! The receiver in clear air, 64 echoes of a ring together: what [`super::returns::report`] says of each, to the bit, and
//! the point that is written.

use multiversion::multiversion;

use super::reflection::peak_share;
use super::response::{HEARD_POWER, intensity, is_heard, saturated};
use super::returns::{Draws, Echo};
use super::scan::{Scan, round};
use super::spec::LidarSpec;

/// Echoes that are received together.
const MANY: usize = 64;

type Many = [f64; MANY];

/// Echoes of one ring in clear air that wait for the receiver.
pub(super) struct Waiting {
    n: usize,
    column: [i32; MANY],
    actor_id: [i32; MANY],
    echo: Echoes,
    written: Written,
}

struct Echoes {
    range_m: Many,
    /// Reflectance / range^2 at the receiver.
    power: Many,
    /// What a retroreflector returns over that; 1 for others.
    brightness: Many,
    cos_incidence: Many,
    reading_noise: Many,
    detection: Many,
    saturation: Many,
    range_normal: Many,
    direction_velo: [Many; 3],
    origin_velo: [Many; 3],
}

/// What comes out.
struct Written {
    point_velo: [[f32; MANY]; 3],
    intensity: [f32; MANY],
    range_m: Many,
    is_kept: [bool; MANY],
}

/// What all echoes of a ring have in common.
#[derive(Clone, Copy)]
struct Receiver {
    laser_gain: f64,
    range_noise_m: f64,
    min_range_m: f64,
    max_range_m: f64,
}

impl Waiting {
    pub(super) fn new() -> Box<Self> {
        let none = [0.0; MANY];
        Box::new(Self {
            n: 0,
            column: [0; MANY],
            actor_id: [0; MANY],
            echo: Echoes {
                range_m: none,
                power: none,
                brightness: none,
                cos_incidence: none,
                reading_noise: none,
                detection: none,
                saturation: none,
                range_normal: none,
                direction_velo: [none; 3],
                origin_velo: [none; 3],
            },
            written: Written {
                point_velo: [[0.0; MANY]; 3],
                intensity: [0.0; MANY],
                range_m: none,
                is_kept: [false; MANY],
            },
        })
    }

    /// Adds an echo of a ring's column; `power` and `brightness` as the receiver sees them.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        echo: &Echo,
        [power, brightness]: [f64; 2],
        draws: &Draws,
        column: usize,
        [origin_velo, direction_velo]: [[f64; 3]; 2],
    ) {
        let (i, e) = (self.n, &mut self.echo);
        self.column[i] = column as i32;
        self.actor_id[i] = echo.actor_id;
        e.range_m[i] = echo.range_m;
        e.power[i] = power;
        e.brightness[i] = brightness;
        e.cos_incidence[i] = echo.cos_incidence;
        e.reading_noise[i] = echo.reading_noise * draws.gain_normal;
        e.detection[i] = draws.detection;
        e.saturation[i] = draws.saturation;
        e.range_normal[i] = draws.range_normal;
        for axis in 0..3 {
            e.direction_velo[axis][i] = direction_velo[axis];
            e.origin_velo[axis][i] = origin_velo[axis];
        }
        self.n += 1;
    }

    pub(super) fn is_full(&self) -> bool {
        self.n == MANY
    }

    /// Receives what waits and writes what is heard.
    pub(super) fn receive(&mut self, spec: &LidarSpec, ring: usize, out: &mut Scan) {
        let receiver = Receiver {
            laser_gain: spec.laser_gains[ring],
            range_noise_m: spec.range_noise_m,
            min_range_m: spec.min_range_m,
            max_range_m: spec.max_range_m,
        };
        receive(&self.echo, receiver, &mut self.written);
        let w = &self.written;
        for i in (0..self.n).filter(|i| w.is_kept[*i]) {
            let [x, y, z] = [0, 1, 2].map(|axis| w.point_velo[axis][i]);
            out.points_velo.push([x, y, z, w.intensity[i]]);
            out.ring.push(ring as i32);
            out.column.push(self.column[i]);
            out.actor_id.push(self.actor_id[i]);
            out.range_m.push(w.range_m[i]);
        }
        self.n = 0;
    }
}

/// Compiled once more for processors with wide registers, as the kernel is.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn receive(e: &Echoes, receiver: Receiver, out: &mut Written) {
    let Receiver { laser_gain, range_noise_m, min_range_m, max_range_m } = receiver;
    let mut reading: Many = [0.0; MANY];
    for i in 0..MANY {
        let (range_m, power) = (e.range_m[i], e.power[i]);
        let peak = power * range_m * range_m * peak_share(range_m, e.cos_incidence[i]);
        reading[i] = intensity(peak, range_m, laser_gain, e.reading_noise[i]);
    }
    for i in 0..MANY {
        let reading = if e.brightness[i] > 1.0 { saturated(e.saturation[i]) } else { reading[i] };
        out.intensity[i] = (round(reading * 1e2).clamp(0.0, 99.0) / 1e2) as f32;
    }
    for i in 0..MANY {
        let (range_m, power) = (e.range_m[i], e.power[i]);
        let noise_m = range_noise_m * (1.0 + 0.5 / (1.0 + power / HEARD_POWER));
        let range_m = range_m + noise_m * e.range_normal[i];
        out.range_m[i] = range_m;
        let mut square = [0.0; 3];
        for axis in 0..3 {
            let at = e.direction_velo[axis][i] * range_m + e.origin_velo[axis][i];
            let at = (round(at * 1e3) / 1e3) as f32;
            out.point_velo[axis][i] = at;
            square[axis] = f64::from(at) * f64::from(at);
        }
        let written_m = (square[0] + square[1] + square[2]).sqrt();
        let is_heard = is_heard(power * e.brightness[i], e.detection[i]);
        out.is_kept[i] = is_heard & (written_m >= min_range_m) & (written_m < max_range_m);
    }
}
