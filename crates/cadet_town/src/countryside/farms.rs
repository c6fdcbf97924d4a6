//! Lone houses and farms beside country roads: a house with its garden, a barn, a drive.

use crate::countryside::Country;
use crate::ground::land::Land;
use crate::network::ParkingSpot;
use crate::placement::PropConfig;
use crate::plots::{Frontage, PlacedHouse, Plot, StreetStyle, garden, right_of};
use cadet_assets::props::DRIVE_PAVING;
use cadet_assets::scenery::materials::barn_palette;
use cadet_assets::scenery::{HouseKind, house, num_variants};
use cadet_base::frames;
use cadet_base::math::{DVec2, DVec3};
use cadet_base::rng::{Stream, StreamKey};

/// Share of the sides of roads with a farm, and with a few houses at the edge of a village.
const FARM_SHARE: f64 = 0.16;
const HAMLET_SHARE: f64 = 0.12;
const HAMLET_HOUSES: (usize, usize) = (3, 7);
/// Plots begin behind verge and ditch, and only where the ditch is shallower than this.
const BEHIND_M: f64 = 0.8;
const SHALLOW_M: f64 = 0.12;
/// Between the corner of a road and the first plot.
const CLEAR_OF_JUNCTION_M: f64 = 25.0;
const TRIES: usize = 10;
/// How far the front of a plot may be from where the road's bend has it.
const MOST_BENT_M: f64 = 2.5;

/// Builds what stands beside one side of a road.
pub(super) fn build(
    key: &StreamKey,
    s: &mut Stream,
    frontage: &Frontage,
    config: &PropConfig,
    country: &mut Country,
    drives: &mut Vec<ParkingSpot>,
) {
    let (is_farm, is_hamlet) = (s.chance(FARM_SHARE), s.chance(HAMLET_SHARE));
    let houses = if is_hamlet { HAMLET_HOUSES.0 + s.below(HAMLET_HOUSES.1 - HAMLET_HOUSES.0 + 1) } else { 1 };
    let room_m = frontage.length_m() - 2.0 * CLEAR_OF_JUNCTION_M;
    if !(is_farm || is_hamlet) || room_m < 40.0 {
        return;
    }
    let style = StreetStyle::of(key, frontage, config);
    let mut from_m = CLEAR_OF_JUNCTION_M + s.unit() * (room_m - 40.0);
    let mut built = 0;
    for _ in 0..TRIES + houses {
        if built == houses || from_m > frontage.length_m() - CLEAR_OF_JUNCTION_M - 20.0 {
            return;
        }
        let reach_m = country.land.roadside.reach_m();
        let plot = propose(s, frontage, country.land, from_m, is_hamlet)
            .filter(|p| country.taken.is_free(&p.whole()) && country.placer.site.is_rect_clear(&p.whole(), reach_m));
        let Some(plot) = plot else {
            from_m += 9.0;
            continue;
        };
        country.taken.take(plot.whole());
        garden::fill(&plot, &style, s, country.placer, drives);
        culvert(&plot, country);
        if !is_hamlet {
            barn(s, &plot, country);
        }
        from_m += plot.length_m + 0.2;
        built += 1;
    }
}

fn propose(s: &mut Stream, frontage: &Frontage, land: &Land, from_m: f64, is_hamlet: bool) -> Option<Plot> {
    let [variants, ..] = num_variants();
    let [detached, village, semi] = if is_hamlet { [0.7, 0.1, 0.2] } else { [0.45, 0.5, 0.05] };
    let kind = s.pick(&[(HouseKind::Detached, detached), (HouseKind::Village, village), (HouseKind::Semi, semi)]);
    let house = house(kind, s.below(variants));
    let size = house.model.footprint_size();
    let (left_m, right_m) = (s.range(3.0, 7.0), 6.8 + s.range(0.0, 4.0));
    let setback_m = if is_hamlet { s.range(4.0, 8.0) } else { s.range(6.0, 16.0) };
    let length_m = size.y + left_m + right_m;
    if from_m + length_m > frontage.length_m() - 4.0 {
        return None;
    }
    let (p, q) = (frontage.at(from_m), frontage.at(from_m + length_m));
    let along = (q - p).normalize_or(DVec2::X);
    let out = right_of(along);
    let bulge_m = frontage.between(from_m, from_m + length_m).iter().map(|r| (*r - p).dot(out));
    let (low, high) = bulge_m.fold((0.0_f64, 0.0_f64), |(a, b), m| (a.min(m), b.max(m)));
    let front = (p + q) / 2.0 + out * (high + land.roadside.ditch_m + BEHIND_M);
    if high - low > MOST_BENT_M || land.roadside.depth_m(front) > SHALLOW_M {
        return None;
    }
    let house = PlacedHouse { house, along_m: (left_m - right_m) / 2.0, setback_m, garage_bays: 1 };
    Some(Plot { front, along, length_m, depth_m: setback_m + size.x + s.range(9.0, 16.0), house: Some(house) })
}

/// Paves the way from the carriageway to the plot's drive.
fn culvert(plot: &Plot, country: &mut Country) {
    let model = DRIVE_PAVING.model(0);
    let piece_m = model.footprint_max.x;
    let a = plot.length_m / 2.0 - 1.8;
    let reach_m = country.land.roadside.reach_m() + BEHIND_M + 2.0;
    country.taken.take(plot.rect([a - 1.7, a + 1.7], [-reach_m, 0.0]));
    let mut d = 0.0;
    while d > -reach_m {
        let [p, q] = [plot.at(a, d), plot.at(a, d - piece_m)];
        if country.placer.site.is_street(q) {
            return;
        }
        let [p, q] = [p, q].map(|p| country.placer.site.on_ground(p) + DVec3::Z * 0.02);
        country.placer.instances.push(model.at(frames::facing(p, q - p, DVec3::Z)));
        d -= piece_m;
    }
}

/// Behind the house, its gable to the road.
fn barn(s: &mut Stream, plot: &Plot, country: &mut Country) {
    let [variants, ..] = num_variants();
    let model = house(HouseKind::Village, s.below(variants)).model;
    let size = model.footprint_size();
    let side = if s.chance(0.5) { 1.0 } else { -1.0 };
    let a = side * (plot.length_m / 2.0 + size.x / 2.0 + s.range(2.0, 5.0));
    let d = s.range(10.0, 16.0);
    let rect = plot.rect([a - size.x / 2.0, a + size.x / 2.0], [d, d + size.y]);
    let is_on_plot = plot.house_rect().is_some_and(|h| h.overlaps(&rect));
    if !is_on_plot && country.taken.is_free(&rect) && country.placer.site.is_rect_clear(&rect, 5.0) {
        country.taken.take(rect);
        country.placer.put(&model, barn_palette(s), plot.at(a, d + size.y / 2.0), plot.along * -side);
    }
}
