//! The random numbers of a beam.

use cadet_base::rng::{Stream, nearly_normal};

/// The random numbers of one beam: always the same count, so that no beam's fate moves another's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Draws {
    /// Whether a pane is met where it is dirty, or snowed over.
    pub(super) pane_chance: f64,
    pub(super) detection_chance: f64,
    pub(super) saturation_chance: f64,
    /// Names the beam to the air.
    pub(super) air_key: u64,
    pub(super) range_deviate: f64,
    pub(super) gain_deviate: f64,
}

impl Draws {
    pub(super) fn new(stream: &mut Stream) -> Self {
        let [a, b, c, d, e] = std::array::from_fn(|_| stream.next_u64());
        let unit = |bits: u64| (bits & 0xffff_ffff) as f64 * (1.0 / 4_294_967_296.0);
        Self {
            pane_chance: unit(a >> 32),
            detection_chance: unit(a),
            saturation_chance: unit(b >> 32),
            air_key: b << 32 | c >> 32,
            range_deviate: nearly_normal(d),
            gain_deviate: nearly_normal(e),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_uniform_and_normal() {
        let mut stream = Stream::from_seed("draws", 0);
        let n = 50_000;
        let draws: Vec<Draws> = (0..n).map(|_| Draws::new(&mut stream)).collect();
        for (pick, mean, var) in [
            ((|d: &Draws| d.pane_chance) as fn(&Draws) -> f64, 0.5, 1.0 / 12.0),
            (|d| d.detection_chance, 0.5, 1.0 / 12.0),
            (|d| d.saturation_chance, 0.5, 1.0 / 12.0),
            (|d| (d.air_key >> 32) as f64 / 4_294_967_296.0, 0.5, 1.0 / 12.0),
            (|d| (d.air_key & 0xffff_ffff) as f64 / 4_294_967_296.0, 0.5, 1.0 / 12.0),
            (|d| d.range_deviate, 0.0, 1.0),
            (|d| d.gain_deviate, 0.0, 1.0),
        ] {
            let m = draws.iter().map(pick).sum::<f64>() / f64::from(n);
            let v = draws.iter().map(|d| (pick(d) - m) * (pick(d) - m)).sum::<f64>() / f64::from(n);
            assert!((m - mean).abs() < 0.02 && (v / var - 1.0).abs() < 0.03, "{m} {v}");
        }
    }
}
