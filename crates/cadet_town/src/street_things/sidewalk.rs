//! What stands on sidewalks, along their outer edges, where people still get past.

use crate::placement::{Boundary, footprint};
use crate::plots::{Frontage, Plot, StreetStyle};
use crate::street_things::{CORNER_M, Furnisher, along_edge, at_edge, cafes, to_traffic};
use cadet_assets::props::{BICYCLE, BOLLARD, DELINEATOR, GUARD_RAIL, LARGE_CONTAINER, Place, Streets, WHEELED_BIN};
use cadet_assets::scenery::HouseKind;
use cadet_base::plane::OrientedRect;
use cadet_base::rng::Stream;

/// Share of the streets where the bins are out for collection, and of their houses that have put some out.
const COLLECTION_SHARE: f64 = 0.16;
const BINS_OUT_SHARE: f64 = 0.7;

/// Furnishes one frontage; `plots` lie along it.
pub(super) fn furnish(
    f: &mut Furnisher,
    frontage: &Frontage,
    style: &StreetStyle,
    plots: &[&Plot],
    clutter: f64,
    s: &mut Stream,
) {
    let length_m = frontage.length_m();
    if length_m < 3.0 * CORNER_M {
        return;
    }
    if s.chance((COLLECTION_SHARE * clutter).min(0.8)) {
        for plot in plots.iter().filter(|p| p.house.is_some()) {
            if s.chance(BINS_OUT_SHARE) {
                bins(f, frontage, plot, s);
            }
        }
    }
    let mut every = |spacing_m: f64, put: &dyn Fn(&mut Furnisher, &mut Stream, f64)| {
        for at_m in places(length_m, spacing_m / clutter, s) {
            put(f, s, at_m);
        }
    };
    every(if is_urban(style) { 45.0 } else { 140.0 }, &|f, s, at_m| leaning_cycles(f, frontage, at_m, s));
    if style.houses[0] == HouseKind::Block || style.houses[0] == HouseKind::Village {
        every(160.0, &|f, s, at_m| cafes::terrace(f, frontage, at_m, s));
    }
    every(250.0, &|f, s, at_m| bollards(f, frontage, at_m, s));
    if frontage.is_main_road {
        main_road(f, frontage, plots, s);
    }
}

/// Puts the props that stand at the outer edge, each by a stream of its own, so that none moves another but by its room.
pub(super) fn furnish_edge(
    f: &mut Furnisher,
    frontage: &Frontage,
    style: &StreetStyle,
    clutter: f64,
    stream_of: impl Fn(&str) -> Stream,
) {
    if frontage.length_m() < 3.0 * CORNER_M {
        return;
    }
    for (prop, rule) in f.own.placed(|place| if let Place::Sidewalk(rule) = place { Some(*rule) } else { None }) {
        let is_here = match rule.streets {
            Streets::All => true,
            Streets::Urban => is_urban(style),
            Streets::Suburban => !is_urban(style),
        };
        if !is_here {
            continue;
        }
        let s = &mut stream_of(&format!("{}/{}", prop.name(), rule.every_m));
        for at_m in places(frontage.length_m(), rule.every_m / clutter, s) {
            let drawn = prop.draw(s);
            let place = match rule.faces_traffic {
                true => to_traffic(frontage, &drawn.model, at_m),
                false => at_edge(frontage, &drawn.model, at_m),
            };
            f.put_at_edge(&drawn, &place);
        }
    }
}

fn is_urban(style: &StreetStyle) -> bool {
    style.houses.iter().any(|k| matches!(k, HouseKind::Block | HouseKind::Village | HouseKind::Terrace))
}

/// Places along a frontage, one every so many meters on average.
fn places(length_m: f64, every_m: f64, s: &mut Stream) -> Vec<f64> {
    let count = s.poisson((length_m / every_m).min(30.0));
    (0..count).map(|_| s.range(CORNER_M, length_m - CORNER_M)).collect()
}

/// Two to four bins before a plot.
fn bins(f: &mut Furnisher, frontage: &Frontage, plot: &Plot, s: &mut Stream) {
    let is_flats =
        plot.house.as_ref().is_some_and(|h| matches!(h.house.kind(), None | Some(HouseKind::Flats | HouseKind::Block)));
    let near = frontage.line.points().iter().position(|p| (*p - plot.front).length() < 1.0);
    let Some(middle_m) = near.map(|i| frontage.line.s_m()[i]) else { return };
    let mut at_m = middle_m + s.range(-0.4, 0.4) * plot.length_m;
    for _ in 0..1 + s.below(4) {
        let drawn = if is_flats && s.chance(0.5) { LARGE_CONTAINER } else { WHEELED_BIN }.draw(s);
        if (CORNER_M..frontage.length_m() - CORNER_M).contains(&at_m) {
            f.put_at_edge(&drawn, &at_edge(frontage, &drawn.model, at_m));
        }
        at_m += drawn.model.footprint_size().y + s.range(0.08, 0.3);
    }
}

/// One to four that lean on the fence or the wall, one behind the other.
fn leaning_cycles(f: &mut Furnisher, frontage: &Frontage, at_m: f64, s: &mut Stream) {
    let is_forth = s.chance(0.5);
    for k in 0..1 + s.below(4) {
        let drawn = BICYCLE.draw(s);
        let at_m = at_m + 2.0 * k as f64;
        if at_m < frontage.length_m() - CORNER_M {
            f.put_at_edge(&drawn, &along_edge(frontage, &drawn.model, at_m, is_forth));
        }
    }
}

/// A row at the curb.
fn bollards(f: &mut Furnisher, frontage: &Frontage, at_m: f64, s: &mut Stream) {
    let (model, spacing_m) = (BOLLARD.model(0), s.range(1.4, 2.6));
    for k in 0..3 + s.below(7) {
        let at_m = at_m + spacing_m * k as f64;
        if at_m > frontage.length_m() - CORNER_M {
            break;
        }
        let (out, sidewalk_m) = (frontage.out(at_m), frontage.sidewalk_at(at_m));
        let at = frontage.behind(at_m, 0.32 - sidewalk_m);
        let rect = footprint(&model, at, -out);
        if sidewalk_m > 1.6 && f.is_free(&rect) && f.parked.is_free(&rect.grown(0.4)) {
            f.placer.put_plain(&model, at, -out);
            f.taken.take(rect);
        }
    }
}

/// Delineators and a guard rail where nobody lives.
fn main_road(f: &mut Furnisher, frontage: &Frontage, plots: &[&Plot], s: &mut Stream) {
    let length_m = frontage.length_m();
    let is_built = plots.iter().any(|p| p.house.is_some());
    if !is_built && s.chance(0.4) {
        let post = DELINEATOR.model(0);
        let mut at_m = s.range(3.0, 20.0);
        while at_m < length_m - 3.0 {
            let (at, facing) = (frontage.behind(at_m, -0.24), -frontage.along(at_m));
            let rect = footprint(&post, at, facing);
            if f.is_free(&rect) {
                f.placer.put_plain(&post, at, facing);
                f.taken.take(rect);
            }
            at_m += 25.0;
        }
    }
    if !is_built && s.chance(0.5) {
        guard_rail(f, frontage, s);
    }
}

/// Along the outer edge, in runs that follow it.
fn guard_rail(f: &mut Furnisher, frontage: &Frontage, s: &mut Stream) {
    let palette = GUARD_RAIL.palette(0, s);
    let end_m = frontage.length_m() - s.range(6.0, 14.0);
    let mut at_m = s.range(6.0, 14.0);
    while at_m + 4.8 < end_m {
        let [from, to] = [at_m, at_m + 4.8].map(|m| frontage.behind(m, -0.1));
        let rect = OrientedRect::about_line(from, to, 0.12);
        if f.is_free(&rect) {
            f.placer.run(Boundary::Fence(GUARD_RAIL, 0), &palette, from, to);
            f.taken.take(rect);
        }
        at_m += 4.8;
    }
}
