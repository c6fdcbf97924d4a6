//! What stands on plots without a house: bottle banks, transformers, posters, sites, bus stops, mounds, bicycles.

use std::sync::Arc;

use crate::assets::scenery::{
    BENCH_SEAT_M, FurnitureKind, SHELTER_SEAT_M, SceneryModel, THING_VARIANTS, ThingKind, furniture, thing,
};
use crate::rng::Stream;
use crate::town::plots::plot::Plot;
use crate::town::plots::street_style::StreetStyle;
use crate::town::street_things::Furnisher;

/// Share of the vacant plots on which something is built, in a common suburb.
const CLEARED_SHARE: f64 = 0.4;
/// Shorter plots stay as they are.
const SHORTEST_M: f64 = 4.5;

/// Whether a plot gets such things in place of a garden; draws once for each plot without a house.
pub(in super::super) fn is_cleared(plot: &Plot, clutter: f64, s: &mut Stream) -> bool {
    let luck = s.unit();
    plot.house.is_none() && plot.length_m >= SHORTEST_M && luck < (CLEARED_SHARE * clutter).min(0.8)
}

/// Builds on a cleared plot.
pub(super) fn build(f: &mut Furnisher, plot: &Plot, style: &StreetStyle, s: &mut Stream) {
    let is_main = style.setback_m >= 5.0 && style.vacant_share > 0.3;
    let weights = if is_main {
        [0.08, 0.05, 0.12, 0.05, 0.34, 0.2, 0.12, 0.04]
    } else {
        [0.16, 0.1, 0.06, 0.15, 0.28, 0.05, 0.1, 0.1]
    };
    match s.weighted(&weights) {
        0 => banks(f, plot, s),
        1 => transformer(f, plot, s),
        2 => billboards(f, plot, s),
        3 => site(f, plot, s),
        4 => green(f, plot, s),
        5 => bus_stop(f, plot, s),
        6 => cycles(f, plot, s),
        _ => yard(f, plot, s),
    }
}

/// Puts one `a` along the front, its foremost side `d` behind it, facing the street; returns its extent along the front.
fn put_facing(f: &mut Furnisher, plot: &Plot, kind: ThingKind, s: &mut Stream, (a, d): (f64, f64)) -> Option<f64> {
    let model = thing(kind, s.below(THING_VARIANTS));
    let at = plot.at(a, d + model.footprint_max.x);
    let half = model.footprint_size().y / 2.0;
    (a.abs() + half < plot.length_m / 2.0 && f.put_model(kind, &model, s, at, -plot.out())).then_some(2.0 * half)
}

/// Somewhere on the plot, any way round.
fn scatter(f: &mut Furnisher, plot: &Plot, kind: ThingKind, s: &mut Stream, depth_m: f64) -> bool {
    let (half, depth_m) = (plot.length_m / 2.0 - 1.0, depth_m.min(plot.depth_m));
    (0..4).any(|_| {
        let at = plot.at(s.range(-half, half), s.range(0.8, depth_m.max(1.0)));
        let turn = s.range(-0.5, 0.5);
        let facing = -plot.out() + plot.along * turn;
        f.put(kind, s, at, facing)
    })
}

fn banks(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let half = plot.length_m / 2.0;
    let d = s.range(0.3, 0.9);
    let mut a = -half + 0.3 + s.range(0.0, 0.6);
    let variant = s.below(THING_VARIANTS);
    let most = 2 + s.below(4);
    for k in 0..most {
        let kind = if k + 1 == most && s.chance(0.6) { ThingKind::ClothesBank } else { ThingKind::GlassBank };
        let model = thing(kind, if kind == ThingKind::GlassBank { variant } else { s.below(THING_VARIANTS) });
        let width = model.footprint_size().y;
        if a + width > half - 0.2 {
            break;
        }
        let at = plot.at(a + width / 2.0, d + model.footprint_max.x);
        let _ = f.put_model(kind, &model, s, at, -plot.out());
        a += width + s.range(0.15, 0.4);
    }
    if s.chance(0.5) {
        let _ = scatter(f, plot, ThingKind::ClippedBush, s, 6.0);
    }
}

fn transformer(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let (a, d) = (s.range(-0.5, 0.5), s.range(0.4, 1.5));
    let _ = put_facing(f, plot, ThingKind::Transformer, s, (a, d));
    for _ in 0..s.below(3) {
        let kind = [ThingKind::ClippedBush, ThingKind::ShrubBed, ThingKind::Cabinet][s.below(3)];
        let _ = scatter(f, plot, kind, s, 5.0);
    }
}

fn billboards(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let a = s.range(-0.4, 0.4);
    if s.chance(0.25) {
        let _ = put_facing(f, plot, ThingKind::AdvertColumn, s, (a, 0.4));
    } else {
        let d = s.range(0.4, 2.0);
        let _ = put_facing(f, plot, ThingKind::Billboard, s, (a, d));
    }
    for _ in 0..1 + s.below(2) {
        let _ = scatter(f, plot, ThingKind::ShrubBed, s, 4.5);
    }
}

fn site(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    for a in [-0.3, 0.25] {
        let kind = [ThingKind::SiteContainer, ThingKind::Skip][s.below(2)];
        let place = (a * plot.length_m, s.range(0.4, 1.5));
        let _ = put_facing(f, plot, kind, s, place);
    }
    for _ in 0..2 + s.below(3) {
        let kind = [ThingKind::Pallets, ThingKind::Heap, ThingKind::Pallets][s.below(3)];
        let _ = scatter(f, plot, kind, s, 7.0);
    }
    for _ in 0..1 + s.below(2) {
        let place = (s.range(-0.4, 0.4) * plot.length_m, 0.1);
        let _ = put_facing(f, plot, ThingKind::Barrier, s, place);
    }
}

/// Lawn with mounds, beds, and single bushes.
fn green(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    for _ in 0..2 + s.below(3) {
        let kind = [ThingKind::Mound, ThingKind::ShrubBed, ThingKind::ClippedBush, ThingKind::ShrubBed][s.below(4)];
        let _ = scatter(f, plot, kind, s, 6.0);
    }
    if s.chance(0.35) {
        bench(f, plot, s);
    }
}

fn bench(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let model = furniture(FurnitureKind::Bench, s.below(3));
    let (at, facing) = (plot.at(s.range(-0.3, 0.3) * plot.length_m, s.range(0.4, 0.9)), -plot.out());
    let rect = crate::town::street_things::footprint(&model, at, facing);
    if rect.samples(0.5).all(|p| !f.placer.site.is_street(p)) && f.is_free(&rect) {
        f.placer.put(&model, Arc::clone(&model.palette), at, facing);
        f.taken.take(rect);
        for aside_m in [-0.45, 0.4] {
            f.add_seat((0.0, aside_m), BENCH_SEAT_M);
        }
    }
}

fn bus_stop(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let a = s.range(-0.3, 0.3);
    let model = thing(ThingKind::BusShelter, s.below(THING_VARIANTS));
    let (back_m, width_m) = (model.footprint_min.x, model.footprint_size().y);
    if put_model_facing(f, plot, &model, s, (a, 0.25)) {
        for aside_m in [-0.28, -0.1, 0.08] {
            f.add_seat((back_m + 0.32, aside_m * width_m), SHELTER_SEAT_M);
        }
    }
    if s.chance(0.4) {
        let _ = scatter(f, plot, ThingKind::AdvertColumn, s, 2.5);
    }
    if s.chance(0.5) {
        let _ = scatter(f, plot, ThingKind::Bicycle, s, 3.0);
    }
}

fn put_model_facing(f: &mut Furnisher, plot: &Plot, model: &SceneryModel, s: &mut Stream, (a, d): (f64, f64)) -> bool {
    let at = plot.at(a, d + model.footprint_max.x);
    f.put_model(ThingKind::BusShelter, model, s, at, -plot.out())
}

/// A row of hoops, and bicycles at some of them, square to the street.
fn cycles(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let (pitch_m, d) = (s.range(0.75, 1.0), s.range(1.1, 1.6));
    let (fullness, has_hoops) = (s.range(0.35, 1.0), s.chance(0.7));
    let count = ((plot.length_m - 1.2) / pitch_m) as usize;
    for k in 0..count.min(9) {
        let a = pitch_m * (k as f64 - (count.min(9) as f64 - 1.0) / 2.0);
        if has_hoops {
            let _ = f.put(ThingKind::CycleHoop, s, plot.at(a, d), plot.out());
        }
        if s.chance(fullness) {
            let facing = if s.chance(0.7) { plot.out() } else { -plot.out() };
            let facing = facing + plot.along * s.range(-0.08, 0.08);
            let at = plot.at(a + 0.5 * pitch_m, d + s.range(-0.12, 0.12));
            let _ = f.put(ThingKind::Bicycle, s, at, facing);
        }
    }
}

/// Where people keep what they use now and then.
fn yard(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let kinds =
        [ThingKind::CoveredCar, ThingKind::Shed, ThingKind::WoodPile, ThingKind::CoveredCycle, ThingKind::Pallets];
    for _ in 0..2 + s.below(2) {
        let _ = scatter(f, plot, kinds[s.below(kinds.len())], s, 8.0);
    }
}
