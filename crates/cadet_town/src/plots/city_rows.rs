//! Closed rows of houses along the streets of an inner city: corner houses, then what fits between them.

use crate::placement::{Occupancy, Site};
use crate::plots::{Frontage, PlacedHouse, Plot, right_of};
use cadet_assets::scenery::{CityKind, House, NUM_CITY_HOUSES, city_house};
use cadet_base::math::DVec2;
use cadet_base::plane::OrientedRect;
use cadet_base::rng::Stream;

/// Between the sidewalk's edge and the walls: the foot of a house fills it.
const FRONT_GAP_M: f64 = 0.1;
/// Between neighbors.
const PARTY_GAP_M: f64 = 0.03;
/// A corner house goes on so far beyond the end of its frontage, round the sidewalk's corner, in steps.
const MOST_AHEAD_M: f64 = 9.0;
const STEP_M: f64 = 0.25;
/// Across from where a side street ends, the sidewalk goes on beyond a frontage's end: at least so far, and houses at
/// most so far.
const GOES_ON_FROM_M: f64 = 5.0;
const MOST_GOING_ON_M: f64 = 14.0;
/// Fronts bend away from the sidewalk by no more than this.
const MOST_BULGE_M: f64 = 0.6;
/// Behind every house, and its court from the deepest down.
const BEHIND_M: f64 = 0.05;
const COURTS_M: [f64; 3] = [7.0, 4.0, 1.5];
/// The narrowest house: what is left of a row is nothing or at least this.
const NARROWEST_M: f64 = 6.6;
/// Remainders that count as nothing.
const SMALL_GAP_M: f64 = 0.45;
/// Wider gaps between houses are gardens with walls before them.
const GARDEN_FROM_M: f64 = 3.0;

/// Lays houses wall to wall along one frontage and takes their ground.
pub(crate) fn lay_out(frontage: &Frontage, site: &Site, taken: &mut Occupancy, s: &mut Stream) -> Vec<Plot> {
    let length_m = frontage.length_m();
    let mut row = HouseRow { frontage, site, taken, plots: Vec::new() };
    let mut is_open = [true, true];
    let mut end_of = |kind: CityKind| {
        let ahead_m = row.goes_on_for_m(kind);
        if ahead_m > GOES_ON_FROM_M {
            return if kind == CityKind::FirstCorner { -ahead_m } else { length_m + ahead_m };
        }
        let no_corner = if kind == CityKind::FirstCorner { 0.0 } else { length_m };
        let corner = row.corner(kind, s);
        is_open[usize::from(kind == CityKind::LastCorner)] = corner.is_none();
        corner.unwrap_or(no_corner)
    };
    let mut from = end_of(CityKind::FirstCorner);
    let end = end_of(CityKind::LastCorner);
    let mut gap_from = from;
    while from + NARROWEST_M < end {
        match row.house(from, end, s) {
            Some(to) => {
                // What is open at a corner is left to the side street's houses.
                if !(is_open[0] && row.plots.len() == 1) {
                    row.close(gap_from, from);
                }
                from = to;
                gap_from = to;
            }
            None => from += 2.0 * STEP_M,
        }
    }
    if !is_open[1] {
        row.close(gap_from, end);
    }
    row.plots
}

struct HouseRow<'a, 'b> {
    frontage: &'a Frontage,
    site: &'a Site<'b>,
    taken: &'a mut Occupancy,
    plots: Vec<Plot>,
}

impl HouseRow<'_, '_> {
    /// A place along the front, which goes on straight beyond both ends.
    fn at(&self, s_m: f64) -> DVec2 {
        let (f, length_m) = (self.frontage, self.frontage.length_m());
        let beyond = if s_m < 0.0 { s_m } else { (s_m - length_m).max(0.0) };
        f.at(s_m.clamp(0.0, length_m)) + f.along(s_m.clamp(0.0, length_m)) * beyond
    }

    /// How far the sidewalk goes on straight beyond one end of the frontage.
    fn goes_on_for_m(&self, kind: CityKind) -> f64 {
        let length_m = self.frontage.length_m();
        let (end, way) = if kind == CityKind::FirstCorner { (0.0, -1.0) } else { (length_m, 1.0) };
        let out = right_of(self.frontage.along(end));
        let mut ahead_m = 0.0;
        while ahead_m < MOST_GOING_ON_M {
            let edge = self.at(end + way * (ahead_m + STEP_M));
            if !self.site.is_clear(edge + out * 1.0, 0.3) || !self.site.is_street(edge - out * 0.9) {
                break;
            }
            ahead_m += STEP_M;
        }
        ahead_m
    }

    /// The plot from `s_m` on that a house fills from side to side; `None` where the street bends too much.
    fn plot(&self, s_m: f64, house: House) -> Option<Plot> {
        let size = house.model.footprint_size();
        let (p, mut q) = (self.at(s_m), self.at(s_m + size.y));
        let along = (q - p).normalize_or_zero();
        if along == DVec2::ZERO {
            return None;
        }
        q = p + along * size.y;
        let out = right_of(along);
        let edge = self.frontage.between(s_m.max(0.0), s_m + size.y);
        let bulge = edge.iter().map(|r| (*r - p).dot(out)).fold(0.0, f64::max);
        if bulge > MOST_BULGE_M {
            return None;
        }
        let front = (p + q) / 2.0 + out * (bulge + FRONT_GAP_M);
        let house = PlacedHouse { house, along_m: 0.0, setback_m: 0.0, garage_bays: 0 };
        let depth_m = size.x + BEHIND_M;
        Some(Plot { front, along, length_m: size.y, depth_m, house: Some(house) })
    }

    /// Moves a plot back from the sidewalk until its house is clear of it, and of what is taken, or gives it up.
    fn settle(&self, mut plot: Plot) -> Option<Plot> {
        let out = plot.out();
        for _ in 0..3 {
            // A street in the house crosses its outline.
            if plot.house_parts().iter().all(|r| outline(r).all(|p| self.site.is_clear(p, 0.04))) {
                return self.taken.is_free(&plot.whole()).then_some(plot);
            }
            plot.front += out * 0.12;
        }
        None
    }

    /// The deepest court that there is room for.
    fn widen_court(&self, plot: &mut Plot) {
        let least_m = plot.depth_m;
        for court_m in COURTS_M {
            plot.depth_m = least_m + court_m;
            if self.taken.is_free(&plot.whole()) && self.site.is_rect_clear(&yard(plot), 0.04) {
                return;
            }
        }
        plot.depth_m = least_m;
    }

    /// A corner house, as far round the corner as there is room; returns where the front goes on, or ends.
    fn corner(&mut self, kind: CityKind, s: &mut Stream) -> Option<f64> {
        let first = s.below(NUM_CITY_HOUSES[kind as usize]);
        let length_m = self.frontage.length_m();
        for k in 0..2 {
            let house = city_house(kind, first + k);
            let width = house.model.footprint_size().y;
            if width + 2.0 > length_m {
                continue;
            }
            let mut ahead_m = MOST_AHEAD_M;
            while ahead_m > -3.0 {
                let from = if kind == CityKind::FirstCorner { -ahead_m } else { length_m + ahead_m - width };
                let plot = self.plot(from, house.clone()).and_then(|plot| self.settle(plot));
                if let Some(plot) = plot {
                    self.take(plot);
                    return Some(if kind == CityKind::FirstCorner { from + width + PARTY_GAP_M } else { from });
                }
                ahead_m -= 2.0 * STEP_M;
            }
        }
        None
    }

    /// A house from `from` on; returns where it ends.
    fn house(&mut self, from: f64, end: f64, s: &mut Stream) -> Option<f64> {
        let count = NUM_CITY_HOUSES[CityKind::Row as usize];
        let first = s.below(count);
        // Where the narrowest does not fit none does.
        self.plot(from, city_house(CityKind::Row, 0)).and_then(|plot| self.settle(plot))?;
        let left = end - from;
        let rest = |width: f64| left - width - PARTY_GAP_M;
        let closes = |width: f64| rest(width) >= 0.0 && (rest(width) < SMALL_GAP_M || rest(width) > NARROWEST_M);
        // First those after which the row can still close, then any.
        for must_close in [true, false] {
            // Steps of 5 visit all twelve.
            for house in (0..count).map(|k| city_house(CityKind::Row, (first + 5 * k) % count)) {
                let width = house.model.footprint_size().y;
                if rest(width) < 0.0 || closes(width) != must_close {
                    continue;
                }
                let plot = self.plot(from, house).and_then(|plot| self.settle(plot));
                if let Some(mut plot) = plot {
                    self.widen_court(&mut plot);
                    self.take(plot);
                    return Some(from + width + PARTY_GAP_M);
                }
            }
        }
        None
    }

    /// What closes a gap between houses: a plot without one, with a wall along the sidewalk.
    fn close(&mut self, from: f64, to: f64) {
        if to - from < SMALL_GAP_M {
            return;
        }
        let (p, q) = (self.at(from), self.at(to));
        let along = (q - p).normalize_or_zero();
        for depth_m in if to - from > GARDEN_FROM_M { [9.0, 4.5, 0.8] } else { [0.8, 0.6, 0.4] } {
            let front = (p + q) / 2.0 + right_of(along) * FRONT_GAP_M;
            let length_m = ((q - p).length() - 2.0 * PARTY_GAP_M).max(0.1);
            let plot = Plot { front, along, length_m, depth_m, house: None };
            if self.taken.is_free(&plot.whole()) && self.site.is_rect_clear(&plot.whole(), 0.03) {
                self.take(plot);
                return;
            }
        }
    }

    fn take(&mut self, plot: Plot) {
        self.taken.take(plot.whole());
        self.plots.push(plot);
    }
}

/// Places along a rectangle's edges, half a meter apart.
fn outline(rect: &OrientedRect) -> impl Iterator<Item = DVec2> {
    let [a, b, c, d] = rect.corners();
    [[a, b], [b, c], [c, d], [d, a]].into_iter().flat_map(|[a, b]| {
        let steps = ((b - a).length() / 0.5).ceil().max(1.0) as usize;
        (0..steps).map(move |k| a.lerp(b, k as f64 / steps as f64))
    })
}

/// The ground behind the house.
fn yard(plot: &Plot) -> OrientedRect {
    let half = plot.length_m / 2.0;
    let depth_m = plot.house.as_ref().map_or(0.0, |h| h.size_m().x);
    plot.rect([-half, half], [depth_m, plot.depth_m])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::GroundKind;
    use crate::placement::PropFootprint;
    use crate::plots::frontages;
    use crate::testing::{assert_apart, things, town};
    use crate::{PropConfig, SuburbConfig, Town};
    use cadet_base::math::DVec3;
    use cadet_base::rng::StreamKey;

    fn city(seed: u64, suburb: &SuburbConfig) -> (Town, Vec<PropFootprint>) {
        let (town, layout) = town(seed, suburb, &PropConfig { city_share: 1.0, ..Default::default() });
        (town, layout.standing)
    }

    fn is_house(standing: &&PropFootprint) -> bool {
        standing.name.starts_with("city-")
    }

    fn wide() -> SuburbConfig {
        SuburbConfig { blocks: (3, 3), sidewalk_m: (2.2, 3.8), ..Default::default() }
    }

    #[test]
    fn houses_of_rows_stand_neither_on_streets_nor_in_each_other() {
        let suburbs =
            [wide(), SuburbConfig { main_share: 1.0, hilly_share: 1.0, blocks: (3, 2), ..Default::default() }];
        for seed in 0..4 {
            let (Town { ground, .. }, standing) = city(seed, &suburbs[seed as usize % 2]);
            let houses: Vec<_> = standing.iter().filter(is_house).collect();
            assert!(houses.len() > 40, "seed {seed}: {} houses", houses.len());
            assert_apart(&houses, &format!("seed {seed}"));
            for (house, p) in houses.iter().flat_map(|h| h.rect.samples(0.5).map(move |p| (h, p))) {
                let kind = ground.kind_at(p.x, p.y);
                assert!(kind.is_none_or(|k| k == GroundKind::Terrain), "seed {seed}: {house:?} on {kind:?} at {p}");
            }
        }
    }

    #[test]
    fn rows_are_closed_but_for_little() {
        let (mut walled, mut all) = (0, 0);
        for seed in 0..3 {
            let (Town { network, ground, .. }, standing) = city(seed, &wide());
            let site = Site::new(&ground);
            let houses: Vec<_> = standing.iter().filter(is_house).collect();
            for frontage in frontages(&network, &site).iter().filter(|f| f.length_m() > 40.0) {
                let mut at_m = 1.0;
                while at_m < frontage.length_m() - 1.0 {
                    let behind = frontage.behind(at_m, 2.5);
                    walled += usize::from(houses.iter().any(|h| h.rect.contains(behind, 0.0)));
                    all += 1;
                    at_m += 1.0;
                }
            }
        }
        assert!(100 * walled > 75 * all, "{walled} of {all} m");
    }

    #[test]
    fn doors_open_onto_sidewalks_with_nothing_before_them() {
        let (mut num_doors, mut num_blocked, mut num_far) = (0, 0, 0);
        for seed in 0..3 {
            let key = StreamKey::scene(seed);
            let (Town { network, ground, .. }, standing) = city(seed, &wide());
            let site = Site::new(&ground);
            let mut taken = Occupancy::default();
            for (i, frontage) in frontages(&network, &site).iter().enumerate() {
                // As they were laid out: nothing else is drawn from these streams.
                for plot in lay_out(frontage, &site, &mut taken, &mut key.indexed("plots", i as u64)) {
                    let Some(house) = &plot.house else { continue };
                    let is_there = |s: &PropFootprint| s.rect.contains(plot.at(0.0, 6.0), 0.0);
                    assert!(standing.iter().any(|s| is_there(s) && s.name == house.house.model.name));
                    for [y0, y1] in house.house.doorways_m() {
                        num_doors += 1;
                        let door = (y0 + y1) / 2.0;
                        let steps: Vec<DVec2> = [0.3, 0.7, 1.1].map(|d| plot.at(-door, -d)).into();
                        let on_sidewalk = |p: &DVec2| ground.kind_at(p.x, p.y) == Some(GroundKind::Sidewalk);
                        let is_free = |p: &DVec2| !standing.iter().any(|s| s.rect.contains(*p, 0.2));
                        num_far += usize::from(house.house.corner().is_none() && !steps.iter().any(on_sidewalk));
                        num_blocked += usize::from(!steps[..2].iter().all(is_free));
                    }
                }
            }
        }
        // A sign of the street round the corner may stand before one.
        assert!(50 * num_far <= num_doors, "{num_far} of {num_doors} doors are far from the sidewalk");
        assert!(num_doors > 100 && 100 * num_blocked <= num_doors, "{num_blocked} of {num_doors}");
    }

    #[test]
    fn lamps_hang_high_over_the_street_from_wall_to_wall() {
        let mut num_lamps = 0;
        for seed in 0..3 {
            let (town, standing) = city(seed, &wide());
            let lamps = things(&town).iter().filter(|i| {
                let size = i.shape.bounds.size();
                size.y > 7.0 && size.x < 1.0 && i.shape.bounds.min.z > 6.0
            });
            for lamp in lamps {
                num_lamps += 1;
                let (middle, bounds) = (lamp.world_from_local.translation, &lamp.shape.bounds);
                let kind = town.ground.kind_at(middle.x, middle.y);
                assert!(kind.is_some_and(|k| k != GroundKind::Terrain), "seed {seed}: lamp at {middle}");
                for end in [bounds.min.y, bounds.max.y] {
                    let at = lamp.world_from_local.transform_point(DVec3::Y * f64::from(end));
                    let in_wall = |s: &PropFootprint| is_house(&s) && s.rect.contains(at.truncate(), 0.0);
                    assert!(standing.iter().any(in_wall), "seed {seed}: a wire ends in the air at {at}");
                }
            }
        }
        assert!(num_lamps > 5, "{num_lamps}");
    }
}
