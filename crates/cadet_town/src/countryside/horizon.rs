//! Where the land ends: wooded hills all round, for the eye alone.

use std::sync::Arc;

use crate::ground::Ground;
use crate::ground::region::with_steps;
use cadet_base::geometry::MeshBuilder;
use cadet_base::instance::Instance;
use cadet_base::material::{Material, Palette, Pattern, Semantic};
use cadet_base::math::{self, DVec2, DVec3, TAU};
use cadet_base::plane::bounds;
use cadet_base::rng::{Stream, StreamKey};

/// The rings of the hills: how far beyond the ground, and the share of their height that they have there.
const RINGS_M: [(f64, f64); 9] = [
    (0.0, 0.0),
    (1.0, 0.0),
    (30.0, 0.02),
    (80.0, 0.07),
    (160.0, 0.2),
    (280.0, 0.45),
    (430.0, 0.75),
    (620.0, 1.0),
    (900.0, 0.9),
];
/// Width of a treetop's face on the ground's outline.
const STEP_M: f64 = 7.0;
/// Height of the hills over the land, of the trees on them, and by how much treetops differ.
const HILL_M: (f64, f64) = (4.0, 75.0);
const TREES_M: (f64, f64) = (9.0, 14.0);
const TOPS_M: f64 = 2.4;
/// The first ring begins so far below the ground's edge.
const FOOT_M: f64 = 0.5;

/// The hills round a ground.
pub(crate) fn hills(key: &StreamKey, ground: &Ground) -> Instance {
    let (min, max) = bounds(ground.vertices.iter().map(|p| p.as_dvec3().truncate()));
    let s = &mut key.stream("land/hills");
    // Places along the ground's edge, counter-clockwise.
    let around = with_steps(&[min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)], STEP_M);
    let middle = (min + max) / 2.0;
    let height = Profile::draw(s);
    let n = around.len();
    let mut b = MeshBuilder::new();
    let mut indices: Vec<Vec<u32>> = Vec::new();
    for (k, (out_m, share)) in RINGS_M.iter().enumerate() {
        let ring = (0..n).map(|i| {
            let edge = around[i];
            // Corners go out along the diagonal, so that the rings stay closed.
            let away = (edge - middle) / (max - min) * 2.0;
            let at = edge + away.clamp(DVec2::NEG_ONE, DVec2::ONE) * *out_m;
            let base = ground.height_at(edge.x.clamp(min.x + 0.5, max.x - 0.5), edge.y.clamp(min.y + 0.5, max.y - 0.5));
            let turn = TAU * i as f64 / n as f64;
            let tops = if k == 0 { -FOOT_M } else { height.trees_m(turn) + s.range(-TOPS_M, TOPS_M) };
            at.extend(base.unwrap_or(0.0) + height.hill_m(turn) * share + tops).as_vec3()
        });
        indices.push(ring.map(|p| b.vertex(p)).collect());
    }
    for rings in indices.windows(2) {
        for i in 0..n {
            let j = (i + 1) % n;
            let [a, c, d, e] = [rings[0][i], rings[0][j], rings[1][j], rings[1][i]];
            let slot = (s.below(3)) as u8;
            b.face([a, d, c], slot);
            b.face([a, e, d], slot);
        }
    }
    Instance::standing(b.build("hills", 0.4), Arc::new(palette(s)), DVec3::ZERO)
}

/// How high hills and their trees are by direction.
struct Profile {
    waves: Vec<(f64, f64, f64)>,
    trees: Vec<(f64, f64, f64)>,
}

impl Profile {
    fn draw(s: &mut Stream) -> Self {
        let mut waves = |counts: &[f64]| -> Vec<(f64, f64, f64)> {
            counts.iter().map(|n| (*n, s.range(0.0, TAU), s.range(0.5, 1.0))).collect()
        };
        Self { waves: waves(&[1.0, 2.0, 3.0, 5.0, 9.0]), trees: waves(&[7.0, 17.0, 29.0]) }
    }

    /// From 0 to 1.
    fn level(waves: &[(f64, f64, f64)], turn: f64) -> f64 {
        let whole: f64 = waves.iter().map(|w| w.2).sum();
        let sum: f64 = waves.iter().map(|(n, phase, share)| share * math::sin(n * turn + phase)).sum();
        0.5 + 0.5 * sum / whole
    }

    fn hill_m(&self, turn: f64) -> f64 {
        let level = Self::level(&self.waves, turn);
        math::lerp(HILL_M.0, HILL_M.1, level * level)
    }

    fn trees_m(&self, turn: f64) -> f64 {
        math::lerp(TREES_M.0, TREES_M.1, Self::level(&self.trees, turn))
    }
}

/// Crowns seen from afar, in three shades.
fn palette(s: &mut Stream) -> Palette {
    let tint = [s.range(0.85, 1.15), s.range(0.9, 1.1), s.range(0.85, 1.15)];
    let shade = |albedo: [f64; 3]| {
        let albedo = std::array::from_fn(|i| (albedo[i] * tint[i]) as f32);
        Material::matt(Semantic::Vegetation, albedo, Pattern::Leaves, 0.45)
    };
    Palette::new(vec![shade([0.046, 0.066, 0.034]), shade([0.036, 0.054, 0.030]), shade([0.058, 0.074, 0.036])])
}
