//! What grows on parcels: woods with their edges, maize, orchards, lone trees, and hedges and fences on the balks between.

use std::sync::Arc;

use crate::countryside::{Country, SEEN_M};
use crate::ground::land::Crop;
use crate::ground::region::{Inside, Ring, with_steps};
use crate::placement::{Boundary, draw_plant};
use cadet_assets::props::WIRE;
use cadet_assets::scenery::materials::maize_palette;
use cadet_assets::scenery::{CROP_VARIANTS, MAIZE_M, TreeKind, maize as maize_row};
use cadet_base::math::{DVec2, TAU};
use cadet_base::plane::{DistanceFrom, bounds, edges, unit};
use cadet_base::rng::{Stream, StreamKey};

/// Woods have a tree a cell, and farther than this from all roads only some.
const WOOD_CELL_M: f64 = 4.4;
const WOOD_DENSE_M: f64 = 42.0;
const WOOD_FAR_SHARE: f64 = 0.3;
/// A wood's edge is so deep: shrubs, and trees with leaves down to the ground.
const WOOD_EDGE_M: f64 = 6.0;
/// Undergrowth along its edge: every so far, where that is seen from a road.
const THICKET_M: f64 = 1.5;
const THICKET_SEEN_M: f64 = 70.0;
/// Rows of maize: how many are seen, and how far apart they are.
const MAIZE_ROWS: usize = 3;
const MAIZE_ROW_M: f64 = 1.5;
/// Length of a fence's straight pieces.
const FENCE_PIECE_M: f64 = 4.8;
const MAIZE_SEEN_M: f64 = 110.0;
/// Shares of the meadows that are orchards and that have a fence, and of the fields with a hedge on some of their balks.
const ORCHARD_SHARE: f64 = 0.16;
const FENCE_SHARE: f64 = 0.3;
const HEDGE_SHARE: f64 = 0.4;
const ORCHARD_M: f64 = 9.0;
/// Area that one lone tree has.
const LONE_TREE_M2: f64 = 4500.0;
const FENCE_SEEN_M: f64 = 80.0;

/// Plants all fields.
pub(super) fn grow(key: &StreamKey, streets: &DistanceFrom, country: &mut Country) {
    if country.greenery <= 0.0 {
        return;
    }
    for (i, (crop, rings)) in country.placer.site.ground.fields().iter().enumerate() {
        let s = &mut key.indexed("country/field", i as u64);
        let (min, max) = bounds(rings.iter().flatten().copied());
        let mut field = Field { rings, inside: Inside::new(rings), min, max, streets, country };
        match crop {
            Crop::Wood => field.wood(s),
            Crop::Maize => field.maize(s),
            Crop::Meadow => field.meadow(s),
            Crop::Stubble | Crop::Soil | Crop::Greens => {
                if s.chance(field.hedge_share()) {
                    field.hedge(s);
                }
            }
        }
    }
}

/// A field and how far it reaches.
struct Field<'a, 'b, 'c> {
    rings: &'a [Ring],
    inside: Inside,
    min: DVec2,
    max: DVec2,
    streets: &'a DistanceFrom,
    country: &'a mut Country<'b, 'c>,
}

impl Field<'_, '_, '_> {
    /// Places on a jittered grid inside.
    fn cells(&self, step_m: f64, s: &mut Stream) -> Vec<DVec2> {
        let count = ((self.max - self.min) / step_m).ceil();
        let mut out = Vec::new();
        for i in 0..count.x as usize {
            for j in 0..count.y as usize {
                let jitter = DVec2::new(s.range(0.1, 0.9), s.range(0.1, 0.9));
                let at = self.min + (DVec2::new(i as f64, j as f64) + jitter) * step_m;
                if self.inside.contains(at) {
                    out.push(at);
                }
            }
        }
        out
    }

    /// The pieces of its outline, no longer than a step, each with the unit vector into the field.
    fn outline(&self, step_m: f64) -> Vec<([DVec2; 2], DVec2)> {
        let rings = self.rings.iter().map(|ring| with_steps(ring, step_m));
        let piece = |[a, b]: [DVec2; 2]| ([a, b], (b - a).normalize_or_zero().perp());
        rings.flat_map(|ring| edges(&ring).map(piece).collect::<Vec<_>>()).collect()
    }

    /// Whether a place is so near to the field's outline.
    fn is_edge(&self, p: DVec2, within_m: f64) -> bool {
        (0..8).any(|k| !self.inside.contains(p + unit(TAU * f64::from(k) / 8.0) * within_m))
    }

    fn is_seen(&self, p: DVec2, within_m: f64) -> bool {
        self.streets.distance_m(p) < within_m
    }

    fn hedge_share(&self) -> f64 {
        HEDGE_SHARE * self.country.greenery.min(1.5)
    }

    fn plant(&mut self, s: &mut Stream, kind: TreeKind, at: DVec2) {
        let model = draw_plant(kind, s);
        self.country.plant(kind, &model, s, at);
    }

    fn wood(&mut self, s: &mut Stream) {
        self.thicket(s);
        let conifers = s.pick(&[(0.05, 0.5), (0.25, 0.3), (0.7, 0.2)]);
        for at in self.cells(WOOD_CELL_M, s) {
            let from_street_m = self.streets.distance_m(at);
            let (luck, is_conifer, at_edge) = (s.unit(), s.chance(conifers), self.is_edge(at, WOOD_EDGE_M));
            let is_low = s.chance(if at_edge { 0.45 } else { 0.12 });
            if from_street_m > SEEN_M || (from_street_m > WOOD_DENSE_M && !at_edge && luck > WOOD_FAR_SHARE) {
                continue;
            }
            let kind = if is_low && from_street_m < 2.0 * WOOD_DENSE_M {
                TreeKind::Shrub
            } else if is_conifer {
                TreeKind::Conifer
            } else {
                TreeKind::Wood
            };
            self.plant(s, kind, at);
        }
    }

    /// Undergrowth along the edge of a wood, where it gets light.
    fn thicket(&mut self, s: &mut Stream) {
        let gaps = s.range(0.05, 0.35);
        for ([a, _], inward) in self.outline(THICKET_M) {
            let (is_gap, is_tall) = (s.chance(gaps), s.chance(0.22));
            let depths_m = [s.range(0.0, 1.2), s.range(1.8, 4.5)];
            if self.streets.distance_m(a) > THICKET_SEEN_M || is_gap {
                continue;
            }
            for depth_m in depths_m {
                self.plant(s, if is_tall { TreeKind::Garden } else { TreeKind::Shrub }, a + inward * depth_m);
            }
        }
    }

    /// Its outer rows; the others are hidden by them.
    fn maize(&mut self, s: &mut Stream) {
        let palette = maize_palette(s);
        for ([a, b], inward) in self.outline(MAIZE_M.0) {
            if self.streets.distance_m(a) > MAIZE_SEEN_M {
                continue;
            }
            for row in 0..MAIZE_ROWS {
                let by = inward * (0.7 + row as f64 * MAIZE_ROW_M);
                let is_free = |p: DVec2| self.inside.contains(p) && self.country.taken.is_free_at(p, 1.5);
                if is_free(a + by) && is_free(b + by) {
                    let model = maize_row(s.below(CROP_VARIANTS));
                    self.country.placer.lay(&model, Arc::clone(&palette), a + by, b + by);
                }
            }
        }
    }

    fn meadow(&mut self, s: &mut Stream) {
        let (is_orchard, has_fence, has_hedge) =
            (s.chance(ORCHARD_SHARE), s.chance(FENCE_SHARE), s.chance(self.hedge_share()));
        if is_orchard {
            for at in self.cells(ORCHARD_M, s) {
                if self.is_seen(at, SEEN_M) && s.chance(0.85) {
                    self.plant(s, TreeKind::Garden, at);
                }
            }
        } else {
            let size = self.max - self.min;
            for _ in 0..s.poisson((self.country.greenery * size.x * size.y / LONE_TREE_M2).min(12.0)) {
                let at = self.min + size * DVec2::new(s.unit(), s.unit());
                let kinds =
                    [(TreeKind::Garden, 0.35), (TreeKind::Street, 0.15), (TreeKind::Wood, 0.2), (TreeKind::Shrub, 0.3)];
                let kind = s.pick(&kinds);
                if self.inside.contains(at) && self.is_seen(at, SEEN_M) {
                    self.plant(s, kind, at);
                }
            }
        }
        if has_fence {
            self.fence(s);
        }
        if has_hedge {
            self.hedge(s);
        }
    }

    /// Wire on posts round a pasture.
    fn fence(&mut self, s: &mut Stream) {
        let boundary = Boundary::fence(WIRE, s);
        let palette = boundary.palette(s);
        for ([a, b], _) in self.outline(FENCE_PIECE_M) {
            if self.is_seen(a, FENCE_SEEN_M) && [a, b].iter().all(|p| self.country.taken.is_free_at(*p, 0.5)) {
                self.country.placer.run(boundary, &palette, a, b);
            }
        }
    }

    /// Shrubs and trees on half of the balks round a field.
    fn hedge(&mut self, s: &mut Stream) {
        for ring in self.rings {
            let points = with_steps(ring, 1.0);
            let (first, count) = (s.below(points.len()), points.len() / 2);
            let mut k = 0;
            while k < count {
                let aside = DVec2::new(s.range(-0.5, 0.5), s.range(-0.5, 0.5));
                let at = points[(first + k) % points.len()] + aside;
                let kind = s.pick(&[(TreeKind::Shrub, 0.62), (TreeKind::Garden, 0.2), (TreeKind::Wood, 0.18)]);
                // Beside roads other things grow.
                if self.country.placer.site.is_clear(at, 5.8) && self.is_seen(at, SEEN_M) {
                    self.plant(s, kind, at);
                }
                k += 1 + s.below(3);
            }
        }
    }
}
