//! What stands on plots without a house: bottle banks, transformers, posters, sites, bus stops, mounds, bicycles.

use crate::plots::{Plot, StreetStyle};
use crate::street_things::Furnisher;
use cadet_assets::props::{
    ADVERT_COLUMN, BARRIER, BENCH, BICYCLE, BILLBOARD, BUS_SHELTER, CLIPPED_BUSH, CLOTHES_BANK, CYCLE_HOOP, Drawn,
    GLASS_BANK, HEAP, MOUND, NETWORK_CABINET, PALLETS, Place, Prop, SHRUB_BED, SITE_CONTAINER, SKIP, Shipped,
    TRANSFORMER,
};
use cadet_base::rng::Stream;

/// Share of the vacant plots on which something is built, in a common suburb.
const CLEARED_SHARE: f64 = 0.4;
/// Shorter plots stay as they are.
const SHORTEST_M: f64 = 4.5;

/// Whether a plot gets such things in place of a garden; draws once for each plot without a house.
pub(in super::super) fn is_cleared(plot: &Plot, clutter: f64, s: &mut Stream) -> bool {
    let luck = s.unit();
    plot.house.is_none() && plot.length_m >= SHORTEST_M && luck < (CLEARED_SHARE * clutter).min(0.8)
}

/// One of them.
type Build = fn(&mut Furnisher, &Plot, &mut Stream);

/// Ways to build on a plot, with their weights where flats stand behind lawns, and elsewhere.
const BUILT: [(Build, [f64; 2]); 8] = [
    (banks, [0.08, 0.16]),
    (transformer, [0.05, 0.1]),
    (billboards, [0.12, 0.06]),
    (site, [0.05, 0.15]),
    (green, [0.34, 0.28]),
    (bus_stop, [0.2, 0.05]),
    (cycles, [0.12, 0.1]),
    (yard, [0.04, 0.1]),
];

/// Builds on a cleared plot.
pub(super) fn build(f: &mut Furnisher, plot: &Plot, style: &StreetStyle, s: &mut Stream) {
    let is_main = style.setback_m >= 5.0 && style.vacant_share > 0.3;
    let build = s.pick(&BUILT.map(|(build, weights)| (build, weights[usize::from(!is_main)])));
    build(f, plot, s);
}

/// Puts one `a` along the front, its foremost side `d` behind it, facing the street.
fn put_facing(f: &mut Furnisher, plot: &Plot, prop: Shipped, s: &mut Stream, (a, d): (f64, f64)) {
    let drawn = prop.draw(s);
    if a.abs() + drawn.model.footprint_size().y / 2.0 < plot.length_m / 2.0 {
        put_drawn_facing(f, plot, &drawn, (a, d));
    }
}

fn put_drawn_facing(f: &mut Furnisher, plot: &Plot, drawn: &Drawn, (a, d): (f64, f64)) {
    let at = plot.at(a, d + drawn.model.footprint_max.x);
    f.put_drawn(drawn, at, -plot.out());
}

/// Somewhere on the plot, any way round.
fn scatter(f: &mut Furnisher, plot: &Plot, prop: &Prop, s: &mut Stream, depth_m: f64) {
    let (half, depth_m) = (plot.length_m / 2.0 - 1.0, depth_m.min(plot.depth_m));
    for _ in 0..4 {
        let at = plot.at(s.range(-half, half), s.range(0.8, depth_m.max(1.0)));
        let turn = s.range(-0.5, 0.5);
        if f.put_drawn(&prop.draw(s), at, -plot.out() + plot.along * turn) {
            return;
        }
    }
}

fn banks(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let half = plot.length_m / 2.0;
    let d = s.range(0.3, 0.9);
    let mut a = -half + 0.3 + s.range(0.0, 0.6);
    let variant = s.below(GLASS_BANK.num_variants());
    let most = 2 + s.below(4);
    for k in 0..most {
        let is_last = k + 1 == most && s.chance(0.6);
        let drawn = if is_last { CLOTHES_BANK.draw(s) } else { GLASS_BANK.draw_variant(variant, s) };
        let width = drawn.model.footprint_size().y;
        if a + width > half - 0.2 {
            break;
        }
        put_drawn_facing(f, plot, &drawn, (a + width / 2.0, d));
        a += width + s.range(0.15, 0.4);
    }
    if s.chance(0.5) {
        scatter(f, plot, &CLIPPED_BUSH, s, 6.0);
    }
}

fn transformer(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let (a, d) = (s.range(-0.5, 0.5), s.range(0.4, 1.5));
    put_facing(f, plot, TRANSFORMER, s, (a, d));
    for _ in 0..s.below(3) {
        let kind = [CLIPPED_BUSH, SHRUB_BED, NETWORK_CABINET][s.below(3)];
        scatter(f, plot, &kind, s, 5.0);
    }
}

fn billboards(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let a = s.range(-0.4, 0.4);
    if s.chance(0.25) {
        put_facing(f, plot, ADVERT_COLUMN, s, (a, 0.4));
    } else {
        let d = s.range(0.4, 2.0);
        put_facing(f, plot, BILLBOARD, s, (a, d));
    }
    for _ in 0..1 + s.below(2) {
        scatter(f, plot, &SHRUB_BED, s, 4.5);
    }
}

fn site(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    for a in [-0.3, 0.25] {
        let kind = [SITE_CONTAINER, SKIP][s.below(2)];
        let place = (a * plot.length_m, s.range(0.4, 1.5));
        put_facing(f, plot, kind, s, place);
    }
    for _ in 0..2 + s.below(3) {
        let kind = [PALLETS, HEAP, PALLETS][s.below(3)];
        scatter(f, plot, &kind, s, 7.0);
    }
    for _ in 0..1 + s.below(2) {
        let place = (s.range(-0.4, 0.4) * plot.length_m, 0.1);
        put_facing(f, plot, BARRIER, s, place);
    }
}

/// Lawn with mounds, beds, and single bushes.
fn green(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    for _ in 0..2 + s.below(3) {
        let kind = [MOUND, SHRUB_BED, CLIPPED_BUSH, SHRUB_BED][s.below(4)];
        scatter(f, plot, &kind, s, 6.0);
    }
    if s.chance(0.35) {
        bench(f, plot, s);
    }
}

fn bench(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let (at, facing) = (plot.at(s.range(-0.3, 0.3) * plot.length_m, s.range(0.4, 0.9)), -plot.out());
    let _ = f.put(BENCH, s, at, facing);
}

fn bus_stop(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let a = s.range(-0.3, 0.3);
    put_drawn_facing(f, plot, &BUS_SHELTER.draw(s), (a, 0.25));
    if s.chance(0.4) {
        scatter(f, plot, &ADVERT_COLUMN, s, 2.5);
    }
    if s.chance(0.5) {
        scatter(f, plot, &BICYCLE, s, 3.0);
    }
}

/// A row of hoops, and bicycles at some of them, square to the street.
fn cycles(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let (pitch_m, d) = (s.range(0.75, 1.0), s.range(1.1, 1.6));
    let (fullness, has_hoops) = (s.range(0.35, 1.0), s.chance(0.7));
    let count = ((plot.length_m - 1.2) / pitch_m) as usize;
    for k in 0..count.min(9) {
        let a = pitch_m * (k as f64 - (count.min(9) as f64 - 1.0) / 2.0);
        if has_hoops {
            let _ = f.put(CYCLE_HOOP, s, plot.at(a, d), plot.out());
        }
        if s.chance(fullness) {
            let facing = if s.chance(0.7) { plot.out() } else { -plot.out() };
            let facing = facing + plot.along * s.range(-0.08, 0.08);
            let at = plot.at(a + 0.5 * pitch_m, d + s.range(-0.12, 0.12));
            let _ = f.put(BICYCLE, s, at, facing);
        }
    }
}

/// Where people keep what they use now and then.
fn yard(f: &mut Furnisher, plot: &Plot, s: &mut Stream) {
    let rules = f.own.placed(|place| if let Place::Yard(weight) = place { Some(*weight) } else { None });
    let weights: Vec<f64> = rules.iter().map(|(_, weight)| *weight).collect();
    for _ in 0..2 + s.below(2) {
        scatter(f, plot, rules[s.weighted(&weights)].0, s, 8.0);
    }
}
