//! Fills a plot: the house and its garage, the boundary with its gates, drive, trees, shrubs and bins.

use crate::network::{ParkingSpot, SpotKind};
use crate::placement::{Boundary, Placer};
use crate::plots::{PlacedHouse, Plot, StreetStyle};
use cadet_assets::props::{DRIVE_PAVING, PATH_PAVING, SCREEN, WALL, WHEELED_BIN};
use cadet_assets::scenery::materials::house_palette;
use cadet_assets::scenery::{HouseKind, TreeKind, garage, num_variants, tree};
use cadet_base::frames;
use cadet_base::math::DVec3;
use cadet_base::rng::Stream;

const GATE_M: f64 = 1.3;
/// Kept free on the sidewalk before a door.
const DOOR_WIDTH_M: f64 = 1.7;
const DOOR_DEPTH_M: f64 = 1.6;

/// A strip of the plot that stays open, from the gate to a door or garage: [a0, a1] along the front.
type GardenWay = [f64; 2];

/// Fills one plot; drives become places to park.
pub(crate) fn fill(
    plot: &Plot,
    style: &StreetStyle,
    s: &mut Stream,
    placer: &mut Placer,
    drives: &mut Vec<ParkingSpot>,
) {
    let half = plot.length_m / 2.0;
    let boundary = if s.chance(0.65) { style.boundary } else { Boundary::draw(s) };
    let mut ways: Vec<GardenWay> = Vec::new();
    let mut behind = 0.0;
    if let Some(house) = &plot.house {
        place_house(plot, house, s, placer);
        behind = house.setback_m + house.size_m().x;
        if house.garage_bays > 0 {
            ways.push(place_garage(plot, house, s, placer, drives));
        }
        if house.setback_m > 1.5 {
            let width = house.size_m().y;
            let doors = if house.house.kind() == Some(HouseKind::Terrace) { 3 } else { 1 };
            for k in 0..doors {
                let a = house.along_m + width * ((k as f64 + s.range(0.3, 0.7)) / doors as f64 - 0.5);
                ways.push([a - GATE_M / 2.0, a + GATE_M / 2.0]);
                pave(plot, [a - 0.6, a + 0.6], house.setback_m - 0.3, placer);
            }
        }
    }
    ways.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let fronted = plot.house.as_ref().is_none_or(|h| h.setback_m > 1.5);
    if fronted {
        let d = boundary.depth_m() / 2.0 + 0.05;
        let palette = boundary.palette(s);
        let mut from = -half;
        for way in ways.iter().chain([&[half, half]]) {
            if way[0] > from + 0.3 {
                placer.run(boundary, &palette, plot.at(from, d), plot.at(way[0], d));
            }
            from = from.max(way[1]);
        }
    } else if let Some(house) = &plot.house {
        close_gaps(plot, house, &ways, s, placer);
    }
    // One side of each plot: its neighbor closes the other.
    let side = if s.chance(0.5) { boundary } else { Boundary::draw(s) };
    let first = if fronted { 1.2 } else { behind };
    if plot.depth_m > first + 3.0 && side != Boundary::Open {
        let a = -half + side.depth_m() / 2.0 + 0.02;
        let palette = side.palette(s);
        placer.run(side, &palette, plot.at(a, first), plot.at(a, plot.depth_m * s.range(0.75, 0.97)));
    }
    plants(plot, &ways, boundary, style, s, placer);
    if plot.house.is_some() && s.chance(style.bin_share) {
        let a = ways.first().map_or(0.0, |w| w[0]) - 0.9;
        let d = if fronted { boundary.depth_m() + 0.6 } else { behind + 0.5 };
        for k in 0..1 + s.below(3) {
            let model = WHEELED_BIN.model(s.below(WHEELED_BIN.num_variants()));
            let at = a - 0.68 * k as f64;
            if at > -half + 1.2 {
                placer.put_plain(&model, plot.at(at, d), -plot.out());
            }
        }
    }
}

fn place_house(plot: &Plot, house: &PlacedHouse, s: &mut Stream, placer: &mut Placer) {
    let size = house.size_m();
    let at = plot.at(house.along_m, house.setback_m + size.x / 2.0);
    placer.put(&house.house.model, house.house.draw_palette(s), at, -plot.out());
    if house.house.is_in_row() {
        let parts = plot.house_parts();
        placer.cover(&parts);
        placer.row_walls.extend(parts);
        placer.ways.extend(plot.before_doors(DOOR_WIDTH_M, [-DOOR_DEPTH_M, 0.0]));
    }
}

/// A garage beside the house, with its drive.
fn place_garage(
    plot: &Plot,
    house: &PlacedHouse,
    s: &mut Stream,
    placer: &mut Placer,
    drives: &mut Vec<ParkingSpot>,
) -> GardenWay {
    let model = garage(house.garage_bays);
    let size = model.footprint_size();
    let a = plot.length_m / 2.0 - 0.15 - size.y / 2.0;
    let room = plot.depth_m - size.x - 0.2;
    let setback = if s.chance(0.25) { 0.6 } else { house.setback_m + s.range(0.5, 3.5) }.clamp(0.05, room.max(0.05));
    let palette = house_palette(s, true);
    placer.put(&model, palette, plot.at(a, setback + size.x / 2.0), -plot.out());
    let way = [a - size.y / 2.0 + 0.2, a + size.y / 2.0 - 0.1];
    pave(plot, way, setback - 0.05, placer);
    if setback > 5.0 {
        let at = plot.at(a, setback / 2.0 + 0.2);
        let nose_in = if s.chance(0.7) { plot.out() } else { -plot.out() };
        let position = placer.site.on_ground(at);
        let ahead = placer.site.on_ground(at + nose_in) - position;
        let world_from_spot = frames::facing(position, ahead, DVec3::Z);
        drives.push(ParkingSpot {
            kind: SpotKind::Drive,
            world_from_spot,
            length_m: setback - 0.3,
            width_m: size.y.min(3.0) - 0.3,
        });
    }
    way
}

/// Paves a way from the front to `depth` behind it.
fn pave(plot: &Plot, [a0, a1]: GardenWay, depth_m: f64, placer: &mut Placer) {
    let model = if a1 - a0 > 2.0 { DRIVE_PAVING } else { PATH_PAVING }.model(0);
    let length = model.footprint_max.x;
    placer.ways.push(plot.rect([a0, a1], [0.0, depth_m.max(0.1)]));
    let a = (a0 + a1) / 2.0;
    let mut d = -0.05;
    while d + 0.3 < depth_m {
        let start = d.min((depth_m - length).max(-0.05));
        let (p, q) = (placer.site.on_ground(plot.at(a, start)), placer.site.on_ground(plot.at(a, start + length)));
        placer.instances.push(model.at(frames::facing(p, q - p, DVec3::Z)));
        d += length;
    }
}

/// Walls between a house on the sidewalk's line and its neighbors.
fn close_gaps(plot: &Plot, house: &PlacedHouse, ways: &[GardenWay], s: &mut Stream, placer: &mut Placer) {
    let (half, width) = (plot.length_m / 2.0, house.size_m().y);
    let (left, right) = (house.along_m - width / 2.0, house.along_m + width / 2.0);
    let boundary = Boundary::Fence(if s.chance(0.6) { WALL } else { SCREEN }, s.below(2));
    let palette = boundary.palette(s);
    let end = ways.first().map_or(half, |w| w[0]);
    for (from, to) in [(-half, left), (right, end)] {
        if to - from > 0.7 {
            placer.run(boundary, &palette, plot.at(from, 0.3), plot.at(to, 0.3));
        }
    }
}

fn plants(
    plot: &Plot,
    ways: &[GardenWay],
    boundary: Boundary,
    style: &StreetStyle,
    s: &mut Stream,
    placer: &mut Placer,
) {
    let half = plot.length_m / 2.0;
    let [_, variants, ..] = num_variants();
    let built = plot.house_rect();
    let house_area = built.map_or(0.0, |r| 4.0 * r.half.x * r.half.y);
    let area = (plot.length_m * plot.depth_m - house_area).max(0.0);
    let wild = if built.is_none() { 1.6 } else { 1.0 };
    let behind = boundary.depth_m() + 0.15;
    let trees = s.poisson((style.trees_per_100_m2 * wild * area / 100.0).min(9.0));
    let shrubs = s.poisson((style.trees_per_100_m2 * wild * (plot.length_m / 7.0).min(6.0)).min(7.0));
    let garage = plot.house.as_ref().filter(|h| h.garage_bays > 0).map(|_| half - 0.15 - 6.5);
    for k in 0..trees + shrubs {
        let kind = if k >= trees {
            TreeKind::Shrub
        } else if s.chance(0.18) {
            TreeKind::Conifer
        } else if plot.depth_m > 12.0 && s.chance(0.2) {
            TreeKind::Wood
        } else {
            TreeKind::Garden
        };
        let model = tree(kind, s.below(variants));
        let radius = model.footprint_max.x;
        let low = matches!(kind, TreeKind::Conifer | TreeKind::Shrub | TreeKind::Wood);
        for _ in 0..5 {
            // Shrubs keep to the front, where they are seen.
            let reach = if kind == TreeKind::Shrub { plot.depth_m.min(8.0) } else { plot.depth_m };
            // More of them in front, where they make the street.
            let back = s.unit();
            let (a, d) = (s.range(-half + 0.5, half - 0.5), behind + (reach - behind).max(0.1) * back * back.sqrt());
            let room = if low { radius * 0.95 } else { 0.7 };
            let on_way = ways.iter().any(|w| a > w[0] - room && a < w[1] + room) && d < 14.0;
            let at = plot.at(a, d);
            let near_house = built.is_some_and(|r| r.contains(at, if low { radius * 0.8 } else { radius * 0.6 }));
            let near_garage = garage.is_some_and(|from| a > from - 0.5 && d < 16.0);
            let off_plot = d < behind + if low { radius } else { 0.4 } || !placer.site.is_clear(at, room);
            if !(on_way || near_house || near_garage || off_plot) && placer.plant_model(kind, &model, s, at) {
                break;
            }
        }
    }
}
