//! How the reflectance of paved ground differs from place to place.
//!
//! Neighboring readings on KITTI's roads are alike: stones, stains, patches and worn tracks are wider than a beam's spot.
//! Here that is a fixed function of the place in the world, the same for every sensor, view and run: octaves of value
//! noise from 0.2 m to 6.4 m, made once as a square that repeats.

use std::sync::LazyLock;

use cadet_base::material::{Material, Pattern, Semantic};
use cadet_base::math::{DVec2, floor};
use cadet_base::rng::CounterRng;

/// Side of the square in cells, a power of two, and of a cell.
const CELLS: usize = 512;
const CELL_M: f64 = 0.1;
/// (cells of the square from node to node, share of the variance) of the octaves.
const OCTAVES: [(usize, f64); 4] = [(2, 0.45), (8, 0.25), (32, 0.2), (64, 0.1)];
/// Standard deviation of the reflectance, as a share of it.
const SPREAD: f64 = 0.27;
/// No place is darker or brighter than this.
const DARKEST: f32 = 0.3;
const BRIGHTEST: f32 = 1.9;

/// True for what [`paved`] describes: asphalt, slabs and blocks of the ground, and the paint on them.
#[inline]
pub(crate) fn is_varied(material: &Material) -> bool {
    matches!(material.pattern, Pattern::Asphalt | Pattern::Slabs | Pattern::Blocks | Pattern::Paint)
        && matches!(material.semantic, Semantic::Road | Semantic::Sidewalk | Semantic::RoadMarking)
}

/// Reflectance of paved ground at a place, as a multiple of its mean.
#[inline]
pub(crate) fn paved(place_world: DVec2) -> f64 {
    let table: &[f32] = &TABLE;
    let at = place_world * (1.0 / CELL_M);
    let (i, j) = (floor(at.x), floor(at.y));
    let (u, v) = ((at.x - i as f64) as f32, (at.y - j as f64) as f32);
    let wrap = |i: i64| i as usize & (CELLS - 1);
    let (left, right) = (wrap(i), wrap(i + 1));
    let (low, high) = (wrap(j) * CELLS, wrap(j + 1) * CELLS);
    let below = table[low + left] + (table[low + right] - table[low + left]) * u;
    let above = table[high + left] + (table[high + right] - table[high + left]) * u;
    f64::from(below + (above - below) * v)
}

static TABLE: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let mut sum = vec![0.0_f64; CELLS * CELLS];
    for (octave, (step, share)) in OCTAVES.into_iter().enumerate() {
        let nodes = CELLS / step;
        let node = |i: usize, j: usize| {
            CounterRng::new(CounterRng::key(0x7E47, [octave as u64, (i % nodes) as u64, (j % nodes) as u64])).unit()
                - 0.5
        };
        let values: Vec<f64> = (0..nodes * nodes).map(|k| node(k % nodes, k / nodes)).collect();
        let value = |i: usize, j: usize| values[(j % nodes) * nodes + i % nodes];
        let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
        let weights: Vec<f64> = (0..step).map(|k| smooth(k as f64 / step as f64)).collect();
        let mut layer = Vec::with_capacity(CELLS * CELLS);
        for y in 0..CELLS {
            let (j, v) = (y / step, weights[y % step]);
            for x in 0..CELLS {
                let (i, u) = (x / step, weights[x % step]);
                let below = value(i, j) + (value(i + 1, j) - value(i, j)) * u;
                let above = value(i, j + 1) + (value(i + 1, j + 1) - value(i, j + 1)) * u;
                layer.push(below + (above - below) * v);
            }
        }
        let n = layer.len() as f64;
        let mean = layer.iter().sum::<f64>() / n;
        let variance = layer.iter().map(|z| (z - mean) * (z - mean)).sum::<f64>() / n;
        let scale = (share / variance).sqrt();
        sum.iter_mut().zip(&layer).for_each(|(s, z)| *s += (z - mean) * scale);
    }
    sum.iter().map(|z| ((1.0 + SPREAD * z) as f32).clamp(DARKEST, BRIGHTEST)).collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_alike_and_far_places_are_not() {
        let n = 60_000;
        let places = |shift: f64| -> Vec<f64> {
            (0..n).map(|k| paved(DVec2::new(0.0137 * f64::from(k) + shift, -7.3 + 0.0041 * f64::from(k)))).collect()
        };
        let here = places(0.0);
        let mean = here.iter().sum::<f64>() / f64::from(n);
        let variance = here.iter().map(|z| (z - mean) * (z - mean)).sum::<f64>() / f64::from(n);
        assert!((mean - 1.0).abs() < 0.03 && (variance.sqrt() / SPREAD - 1.0).abs() < 0.2, "{mean} {variance}");
        let alike = |shift: f64| {
            let there = places(shift);
            here.iter().zip(&there).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / f64::from(n) / variance
        };
        let [beside, decimetre, metre, street] = [0.02, 0.1, 1.0, 23.0].map(alike);
        assert!(beside > 0.9 && decimetre > 0.6, "{beside} {decimetre}");
        assert!((0.1..0.5).contains(&metre) && street.abs() < 0.2, "{metre} {street}");
    }

    #[test]
    fn it_is_defined_everywhere_and_has_no_seams() {
        for place in [DVec2::new(-1e6, 1e6), DVec2::new(-0.05, -51.2), DVec2::ZERO] {
            let (a, b) = (paved(place - 1e-6), paved(place + 1e-6));
            assert!((a - b).abs() < 1e-4 && (0.3..=1.9).contains(&a), "{place} {a} {b}");
        }
    }
}
