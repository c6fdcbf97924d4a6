//! Things that stand about: on sidewalks' edges, in parking places, on vacant plots, in front gardens.

mod bays;
mod cafes;
mod city;
mod edge;
mod gardens;
mod lots;
mod sidewalk;

pub(super) use lots::is_cleared;

use edge::{CORNER_M, EdgePlace, INSET_M, along_edge, at_edge, to_traffic};

use std::sync::Arc;

use crate::network::{ParkingSpot, SpotKind, Walkway};
use crate::placement::{Occupancy, Placer, PropConfig, footprint};
use crate::plots::{Frontage, Plot, StreetStyle};
use cadet_assets::props::{Drawn, OwnProps, Shipped};
use cadet_base::frames;
use cadet_base::math::{DPose3, DVec2};
use cadet_base::plane::{OrientedRect, bounds};
use cadet_base::rng::{Stream, StreamKey};

/// Where somebody may sit.
#[derive(Debug, Clone, Copy)]
pub struct Seat {
    /// The middle of the seat on the ground; who sits there looks along x.
    pub world_from_seat: DPose3,
    /// The seat's height over it.
    pub height_m: f64,
}

impl Seat {
    /// Those of what was put last.
    pub(super) fn of_last<'a>(drawn: &'a Drawn, placer: &Placer) -> impl Iterator<Item = Self> + use<'a> {
        let last = placer.instances.last().map(|instance| instance.world_from_local);
        drawn.seats.iter().zip(std::iter::repeat(last)).filter_map(|(seat, last)| {
            let place = last?.transform_point(seat.with_z(0.0));
            Some(Self { world_from_seat: frames::upright(place, frames::yaw_of(&last?)), height_m: seat.z })
        })
    }
}

/// What others need to know of the things.
#[derive(Debug, Default)]
pub(super) struct StreetThings {
    pub obstacles: Vec<OrientedRect>,
    pub seats: Vec<Seat>,
}

/// A plot, and the frontage that it lies along.
#[derive(Debug)]
pub(super) struct PlotOnStreet {
    pub plot: Plot,
    pub frontage: usize,
    /// Nothing grows on it, and something is to be built there.
    pub is_cleared: bool,
}

/// The streets of a town, as they were laid out.
pub(super) struct StreetLayout<'a> {
    pub frontages: &'a [Frontage],
    pub styles: &'a [StreetStyle],
    pub plots_on_streets: &'a [PlotOnStreet],
}

/// No thing comes nearer to another, to a wall or to a trunk.
const APART_M: f64 = 0.06;
/// Between a door and what stands in front of it, and how wide what stays free there is at least.
const DOOR_DEPTH_M: f64 = 2.2;
const DOOR_WIDTH_M: f64 = 1.7;
/// People pass a thing on a sidewalk if so much of its width is left beside it, and if some line that they walk along keeps
/// so far from everything.
const LEFT_FOR_WALKERS_M: f64 = 0.95;
const SHOULDER_M: f64 = 0.42;

/// Places things where they are free to stand, and remembers where.
struct Furnisher<'a, 'b> {
    placer: &'a mut Placer<'b>,
    /// Walls, trunks, fences, things, parking places.
    taken: Occupancy,
    /// Ways to doors and garages.
    ways: Occupancy,
    /// Where cars park.
    parked: Occupancy,
    walkways: &'a [Walkway],
    /// The lowest and highest coordinates of each.
    walkway_bounds: Vec<(DVec2, DVec2)>,
    own: &'a OwnProps,
    out: StreetThings,
}

/// Places the things of a town; parking places are those along streets and those in drives.
pub(super) fn place(
    key: &StreamKey,
    streets: &StreetLayout,
    (parking, drives): (&[ParkingSpot], &[ParkingSpot]),
    walkways: &[Walkway],
    config: &PropConfig,
    placer: &mut Placer,
) -> StreetThings {
    let clutter = config.clutter;
    if clutter <= 0.0 {
        return StreetThings::default();
    }
    let taken = Occupancy::of(placer.standing.iter().map(|s| s.rect));
    let parked = Occupancy::of(parking.iter().chain(drives).map(ParkingSpot::rect));
    let mut ways = Occupancy::of(placer.ways.iter().copied());
    for plots_on_streets in streets.plots_on_streets {
        let plot = &plots_on_streets.plot;
        let Some(house) = &plot.house else { continue };
        let before_m = (house.setback_m - DOOR_DEPTH_M).max(-1.3);
        let doors = plot.before_doors(DOOR_WIDTH_M, [before_m, house.setback_m]);
        doors.into_iter().for_each(|door| ways.take(door));
    }
    let walkway_bounds = walkways.iter().map(|w| bounds(w.center.iter().map(|p| p.truncate()))).collect();
    let out = StreetThings::default();
    let own = &config.own;
    let mut furnisher = Furnisher { placer, taken, ways, parked, walkways, walkway_bounds, own, out };
    for (i, plots_on_streets) in streets.plots_on_streets.iter().enumerate() {
        let style = &streets.styles[plots_on_streets.frontage];
        let mut s = key.indexed("things/plot", i as u64);
        if plots_on_streets.is_cleared {
            lots::build(&mut furnisher, &plots_on_streets.plot, style, &mut s);
        } else {
            gardens::furnish(&mut furnisher, &plots_on_streets.plot, clutter, &mut s);
        }
    }
    for spot in drives.iter().filter(|spot| spot.kind == SpotKind::Drive) {
        gardens::roof_over(&mut furnisher, spot, &mut key.indexed("things/drive", place_key(spot)));
    }
    for spot in parking {
        bays::fill(&mut furnisher, spot, clutter, &mut key.indexed("things/bay", place_key(spot)));
    }
    for (i, frontage) in streets.frontages.iter().enumerate() {
        let plots: Vec<&Plot> =
            streets.plots_on_streets.iter().filter(|l| l.frontage == i && !l.is_cleared).map(|l| &l.plot).collect();
        let mut s = key.indexed("things/sidewalk", i as u64);
        if let Some(style) = &streets.styles[i].city {
            let has_lamps = streets.frontages[..i].iter().all(|f| f.road != frontage.road);
            let mut s = key.indexed("things/city", i as u64);
            let light = has_lamps.then_some(streets.styles[i].street_light);
            city::furnish(&mut furnisher, frontage, style, &plots, light, &mut s);
        }
        sidewalk::furnish(&mut furnisher, frontage, &streets.styles[i], &plots, clutter, &mut s);
        let at_edge = |name: &str| key.indexed(&format!("things/sidewalk/{name}"), i as u64);
        sidewalk::furnish_edge(&mut furnisher, frontage, &streets.styles[i], clutter, at_edge);
    }
    furnisher.out
}

/// A number that goes with a place, for its stream.
fn place_key(spot: &ParkingSpot) -> u64 {
    let p = spot.world_from_spot.translation;
    ((p.x * 10.0).round() as i64 as u64) << 32 | ((p.y * 10.0).round() as i64 as u64 & 0xffff_ffff)
}

impl Furnisher<'_, '_> {
    /// Whether a rectangle is free of everything, of ways to doors, of carriageways and parked cars.
    fn is_free(&self, rect: &OrientedRect) -> bool {
        self.taken.is_free(&rect.grown(APART_M))
            && self.ways.is_free(rect)
            && self.parked.is_free(&rect.grown(APART_M))
            && !rect.samples(0.4).any(|p| self.placer.site.is_road(p))
    }

    /// Puts a prop of any size and color behind the sidewalk, if there is room.
    fn put(&mut self, prop: Shipped, s: &mut Stream, at: DVec2, facing: DVec2) -> bool {
        self.put_drawn(&prop.draw(s), at, facing)
    }

    /// Puts this very one.
    fn put_drawn(&mut self, drawn: &Drawn, at: DVec2, facing: DVec2) -> bool {
        let rect = footprint(&drawn.model, at, facing);
        let is_off_street = rect.samples(0.5).all(|p| !self.placer.site.is_street(p));
        if !is_off_street || !self.is_free(&rect) {
            return false;
        }
        self.stand(drawn, at, facing, rect);
        true
    }

    /// Puts a prop where there is room for it.
    fn stand(&mut self, drawn: &Drawn, at: DVec2, facing: DVec2, rect: OrientedRect) {
        self.placer.put(&drawn.model, Arc::clone(&drawn.palette), at, facing);
        self.taken.take(rect);
        self.out.seats.extend(Seat::of_last(drawn, self.placer));
    }

    /// Puts a prop where people walk or park.
    fn stand_in_the_way(&mut self, drawn: &Drawn, at: DVec2, facing: DVec2, rect: OrientedRect) {
        self.stand(drawn, at, facing, rect);
        self.out.obstacles.push(rect);
    }

    /// Puts a prop on the sidewalk's outer edge, if people still get past.
    fn put_at_edge(&mut self, drawn: &Drawn, place: &EdgePlace) -> bool {
        let rect = footprint(&drawn.model, place.at, place.facing);
        // How far it reaches in from the outer edge.
        let depth_m = (place.edge - rect.center).dot(place.out)
            + rect.axis.dot(place.out).abs() * rect.half.x
            + rect.axis.perp().dot(place.out).abs() * rect.half.y;
        let has_room = depth_m + LEFT_FOR_WALKERS_M <= place.sidewalk_m;
        if !(has_room && self.is_free(&rect) && self.parked.is_free(&rect.grown(0.8)) && self.is_passable(&rect)) {
            return false;
        }
        self.stand_in_the_way(drawn, place.at, place.facing, rect);
        true
    }

    /// Whether people on every walkway get past a rectangle and what stands near it.
    fn is_passable(&self, rect: &OrientedRect) -> bool {
        let reach_m = rect.half.length() + 1.0;
        let is_near = |p: DVec2, within_m: f64| (p - rect.center).length() < within_m;
        let near: Vec<OrientedRect> =
            self.out.obstacles.iter().copied().filter(|o| is_near(o.center, reach_m + 4.0)).collect();
        let is_about =
            |(low, high): &(DVec2, DVec2)| (rect.center.clamp(*low, *high) - rect.center).length() < reach_m + 2.0;
        let about = self.walkways.iter().zip(&self.walkway_bounds).filter(|(_, bounds)| is_about(bounds));
        let places = about.flat_map(|(w, _)| w.center.windows(2).map(move |pair| (w.width_m, pair)));
        let mut places = places.filter(|(_, pair)| is_near(pair[0].truncate(), reach_m + 2.0));
        places.all(|(width_m, pair)| {
            let (from, to) = (pair[0].truncate(), pair[1].truncate());
            let left = (to - from).normalize_or(DVec2::X).perp();
            let room_m = (width_m / 2.0 - 0.1).max(0.0);
            (0..3).all(|k| {
                let middle = from.lerp(to, f64::from(k) / 3.0);
                let mut lines = (0..=10).map(|k| middle + left * (room_m * (f64::from(k) / 5.0 - 1.0)));
                lines.any(|p| near.iter().chain([rect]).all(|o| !o.contains(p, SHOULDER_M)))
            })
        })
    }
}

#[cfg(test)]
pub(crate) mod tests;
