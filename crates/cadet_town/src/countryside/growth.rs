//! What grows on parcels: woods with their edges, maize, orchards, lone trees, and hedges and fences on the balks between.

use std::sync::Arc;

use crate::countryside::SEEN_M;
use crate::countryside::verges::room_m;
use crate::ground::land::fields::Crop;
use crate::ground::region::{Inside, Ring, with_steps};
use crate::placement::boundary::Boundary;
use crate::placement::occupancy::Occupancy;
use crate::placement::placer::{Placer, boundary_palette};
use crate::plots::belt::StreetPoints;
use cadet_assets::props::WIRE;
use cadet_assets::scenery::materials::maize_palette;
use cadet_assets::scenery::{CROP_VARIANTS, MAIZE_M, TreeKind, maize as maize_row, num_variants, tree};
use cadet_base::math::DVec2;
use cadet_base::plane::bounds;
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

/// A field and how far it reaches.
struct FieldArea<'a> {
    rings: &'a [Ring],
    inside: Inside,
    min: DVec2,
    max: DVec2,
}

impl<'a> FieldArea<'a> {
    fn new(rings: &'a [Ring]) -> Self {
        let points = rings.iter().flatten();
        let (min, max) = bounds(points.copied());
        Self { rings, inside: Inside::new(rings), min, max }
    }

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

    /// Whether a place is so near to the field's outline.
    fn is_edge(&self, p: DVec2, within_m: f64) -> bool {
        (0..8).any(|k| {
            let around = cadet_base::math::TAU * f64::from(k) / 8.0;
            let to = DVec2::new(cadet_base::math::cos(around), cadet_base::math::sin(around)) * within_m;
            !self.inside.contains(p + to)
        })
    }
}

/// Plants all fields.
pub(super) fn grow(key: &StreamKey, streets: &StreetPoints, greenery: f64, taken: &Occupancy, placer: &mut Placer) {
    for (i, (crop, rings)) in placer.site.fields().iter().enumerate() {
        let s = &mut key.indexed("country/field", i as u64);
        let field = FieldArea::new(rings);
        if greenery <= 0.0 {
            continue;
        }
        match crop {
            Crop::Wood => wood(s, &field, streets, taken, placer),
            Crop::Maize => maize(s, &field, streets, taken, placer),
            Crop::Meadow => meadow(s, &field, streets, greenery, taken, placer),
            Crop::Stubble | Crop::Soil | Crop::Greens => {
                if s.chance(HEDGE_SHARE * greenery.min(1.5)) {
                    hedge(s, &field, streets, taken, placer);
                }
            }
        }
    }
}

fn plant(s: &mut Stream, kind: TreeKind, at: DVec2, taken: &Occupancy, placer: &mut Placer) {
    let [_, variants, ..] = num_variants();
    let model = tree(kind, s.below(variants));
    if placer.site.is_clear(at, room_m(kind, model.footprint_max.x)) && taken.is_free_at(at, 2.0) {
        let _ = placer.plant_model(kind, &model, s, at);
    }
}

fn wood(s: &mut Stream, field: &FieldArea, streets: &StreetPoints, taken: &Occupancy, placer: &mut Placer) {
    thicket(s, field, streets, taken, placer);
    let conifers = [0.05, 0.25, 0.7][s.weighted(&[0.5, 0.3, 0.2])];
    for at in field.cells(WOOD_CELL_M, s) {
        let from_street_m = streets.distance_m(at);
        let (luck, is_conifer, at_edge) = (s.unit(), s.chance(conifers), field.is_edge(at, WOOD_EDGE_M));
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
        plant(s, kind, at, taken, placer);
    }
}

/// Undergrowth along the edge of a wood, where it gets light.
fn thicket(s: &mut Stream, field: &FieldArea, streets: &StreetPoints, taken: &Occupancy, placer: &mut Placer) {
    let gaps = s.range(0.05, 0.35);
    for ring in field.rings {
        let points = with_steps(ring, THICKET_M);
        for (i, a) in points.iter().enumerate() {
            let b = points[(i + 1) % points.len()];
            let inward = (b - *a).normalize_or_zero().perp();
            let (is_gap, is_tall) = (s.chance(gaps), s.chance(0.22));
            let depths_m = [s.range(0.0, 1.2), s.range(1.8, 4.5)];
            if streets.distance_m(*a) > THICKET_SEEN_M || is_gap {
                continue;
            }
            for depth_m in depths_m {
                let kind = if is_tall { TreeKind::Garden } else { TreeKind::Shrub };
                plant(s, kind, *a + inward * depth_m, taken, placer);
            }
        }
    }
}

/// Its outer rows; the others are hidden by them.
fn maize(s: &mut Stream, field: &FieldArea, streets: &StreetPoints, taken: &Occupancy, placer: &mut Placer) {
    let palette = maize_palette(s);
    for ring in field.rings {
        let points = with_steps(ring, MAIZE_M.0);
        for (i, a) in points.iter().enumerate() {
            let b = points[(i + 1) % points.len()];
            let inward = (b - *a).normalize_or_zero().perp();
            if streets.distance_m(*a) > MAIZE_SEEN_M {
                continue;
            }
            for row in 0..MAIZE_ROWS {
                let by = inward * (0.7 + row as f64 * MAIZE_ROW_M);
                let is_free = |p: DVec2| field.inside.contains(p) && taken.is_free_at(p, 1.5);
                if is_free(*a + by) && is_free(b + by) {
                    placer.lay(&maize_row(s.below(CROP_VARIANTS)), Arc::clone(&palette), *a + by, b + by);
                }
            }
        }
    }
}

fn meadow(
    s: &mut Stream,
    field: &FieldArea,
    streets: &StreetPoints,
    greenery: f64,
    taken: &Occupancy,
    placer: &mut Placer,
) {
    let (is_orchard, has_fence, has_hedge) =
        (s.chance(ORCHARD_SHARE), s.chance(FENCE_SHARE), s.chance(HEDGE_SHARE * greenery.min(1.5)));
    if is_orchard {
        for at in field.cells(ORCHARD_M, s) {
            if streets.distance_m(at) < SEEN_M && s.chance(0.85) {
                plant(s, TreeKind::Garden, at, taken, placer);
            }
        }
    } else {
        let size = field.max - field.min;
        for _ in 0..s.poisson((greenery * size.x * size.y / LONE_TREE_M2).min(12.0)) {
            let at = field.min + size * DVec2::new(s.unit(), s.unit());
            let kind = [TreeKind::Garden, TreeKind::Street, TreeKind::Wood, TreeKind::Shrub]
                [s.weighted(&[0.35, 0.15, 0.2, 0.3])];
            if field.inside.contains(at) && streets.distance_m(at) < SEEN_M {
                plant(s, kind, at, taken, placer);
            }
        }
    }
    if has_fence {
        fence(s, field, streets, taken, placer);
    }
    if has_hedge {
        hedge(s, field, streets, taken, placer);
    }
}

/// Wire on posts round a pasture.
fn fence(s: &mut Stream, field: &FieldArea, streets: &StreetPoints, taken: &Occupancy, placer: &mut Placer) {
    let boundary = Boundary::Fence(WIRE, s.below(WIRE.num_variants()));
    let palette = boundary_palette(boundary, s);
    for ring in field.rings {
        let points = with_steps(ring, FENCE_PIECE_M);
        for (i, a) in points.iter().enumerate() {
            let b = points[(i + 1) % points.len()];
            if streets.distance_m(*a) < FENCE_SEEN_M && taken.is_free_at(*a, 0.5) && taken.is_free_at(b, 0.5) {
                placer.run(boundary, &palette, *a, b);
            }
        }
    }
}

/// Shrubs and trees on half of the balks round a field.
fn hedge(s: &mut Stream, field: &FieldArea, streets: &StreetPoints, taken: &Occupancy, placer: &mut Placer) {
    for ring in field.rings {
        let points = with_steps(ring, 1.0);
        let (first, count) = (s.below(points.len()), points.len() / 2);
        let mut k = 0;
        while k < count {
            let aside = DVec2::new(s.range(-0.5, 0.5), s.range(-0.5, 0.5));
            let at = points[(first + k) % points.len()] + aside;
            let kind = [TreeKind::Shrub, TreeKind::Garden, TreeKind::Wood][s.weighted(&[0.62, 0.2, 0.18])];
            // Beside roads other things grow.
            if placer.site.is_clear(at, 5.8) && streets.distance_m(at) < SEEN_M {
                plant(s, kind, at, taken, placer);
            }
            k += 1 + s.below(3);
        }
    }
}
