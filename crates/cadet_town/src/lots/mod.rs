//! Lots beside streets: car parks, works, and institutes, with their paved yards, buildings, and places for cars.

mod campus;
mod car_park;
mod industry;
mod layout;
mod place;
#[cfg(test)]
mod tests;

use layout::{LotLayout, fitting};

use crate::ground::Ground;
use crate::ground::land::Yards;
use crate::network::{AISLE_KMH, PaintColor, PaintedQuad, ParkingSpot, RoadNetwork, Walkway};
use crate::placement::{Occupancy, PropConfig, Site};
use crate::plots::{Frontage, LotUse, Plot, StreetStyle, fits, frontages, plot_at};
use cadet_base::frames;
use cadet_base::math::{DVec2, DVec3};
use cadet_base::rng::{Stream, StreamKey};

/// Width of the lines between bays.
const LINE_M: f64 = 0.12;
/// Between two lots.
const GAP_M: f64 = 0.5;
/// Yards begin this far before the front of their lot; the part of them on the street's own ground is cut off.
const BEFORE_M: f64 = 4.0;
/// Around a corner the chord of a front is much shorter than the front, and no lot lies there.
const LEAST_CHORD: f64 = 0.85;
/// Points of walkways are at most so far apart.
const STEP_M: f64 = 1.8;

/// One lot.
#[derive(Debug, Clone)]
pub(super) struct Lot {
    pub plot: Plot,
    pub layout: LotLayout,
}

/// The lots of a town, before its ground is made.
#[derive(Debug, Clone, Default)]
pub(super) struct Lots {
    pub lots: Vec<Lot>,
}

impl Lots {
    /// Lays out the lots along all streets that have them; a function of network, key, and configuration.
    pub fn plan(key: &StreamKey, network: &RoadNetwork, ground: &Ground, config: &PropConfig) -> Self {
        let site = Site::new(ground);
        let mut taken = Occupancy::default();
        let mut lots = Vec::new();
        for (i, frontage) in frontages(network, &site).iter().enumerate() {
            let Some(usage) = StreetStyle::of(key, frontage, config).lots else { continue };
            along(frontage, usage, &site, &mut taken, &mut key.indexed("lots", i as u64), &mut lots);
        }
        Self { lots }
    }

    /// The ground that they take.
    pub fn taken(&self) -> Occupancy {
        Occupancy::of(self.lots.iter().map(|lot| lot.plot.whole()))
    }

    /// The paved ground and the painted lines of all lots.
    pub fn yards(&self) -> Yards {
        let mut yards = Yards::default();
        for (number, lot) in self.lots.iter().enumerate() {
            let rect = |[a0, a1, d0, d1]: [f64; 4]| lot.plot.rect([a0, a1], [d0, d1]).corners();
            yards.outlines.extend(lot.layout.paved.iter().map(|(surface, r)| (*surface, rect(*r))));
            for [from, to] in &lot.layout.lines {
                let (p, q) = (lot.at(*from), lot.at(*to));
                let aside = (q - p).normalize_or(DVec2::X).perp() * (LINE_M / 2.0);
                let corners = [p - aside, q - aside, q + aside, p + aside].map(|c| c.extend(0.0));
                yards.lines.push(PaintedQuad { corners, color: PaintColor::White, line: (1 << 27) + number as u32 });
            }
        }
        yards
    }

    /// Where vehicles may stand on them.
    pub fn parking(&self, ground: &Ground) -> Vec<ParkingSpot> {
        let mut spots = Vec::new();
        for lot in &self.lots {
            for bay in &lot.layout.bays {
                let (at, heading) = (lot.at(bay.at), lot.direction(bay.heading));
                let on = |p: DVec2| ground.height_at(p.x, p.y).map(|z| p.extend(z));
                let (reach, aside) = (heading * (bay.length_m / 4.0), heading.perp() * (bay.width_m / 3.0));
                let (Some(ahead), Some(behind), Some(left), Some(right)) =
                    (on(at + reach), on(at - reach), on(at + aside), on(at - aside))
                else {
                    continue;
                };
                let (along, across) = (ahead - behind, left - right);
                let middle = (ahead + behind + left + right) / 4.0;
                let world_from_spot = frames::facing(middle, along, along.cross(across));
                spots.push(ParkingSpot {
                    kind: bay.kind,
                    world_from_spot,
                    length_m: bay.length_m,
                    width_m: bay.width_m,
                });
            }
        }
        spots
    }

    /// Lines along which people walk to their cars and to doors.
    pub fn walkways(&self, ground: &Ground) -> Vec<Walkway> {
        let mut walkways = Vec::new();
        for lot in &self.lots {
            for (width_m, line) in &lot.layout.walks {
                let mut center: Vec<DVec3> = Vec::new();
                for pair in line.windows(2) {
                    let (p, q) = (lot.at(pair[0]), lot.at(pair[1]));
                    let pieces = ((q - p).length() / STEP_M).ceil().max(1.0);
                    let from = usize::from(!center.is_empty());
                    let points = (from..=pieces as usize).map(|k| p.lerp(q, k as f64 / pieces));
                    center.extend(points.filter_map(|p| ground.height_at(p.x, p.y).map(|z| p.extend(z))));
                }
                if center.len() > 3 {
                    walkways.push(Walkway { center, width_m: *width_m });
                }
            }
        }
        walkways
    }
}

impl Lot {
    /// A place of the lot, (along the front, behind it), in the plane.
    pub fn at(&self, p: DVec2) -> DVec2 {
        self.plot.at(p.x, p.y)
    }

    /// A direction of the lot in the plane.
    pub fn direction(&self, d: DVec2) -> DVec2 {
        self.plot.along * d.x + self.plot.out() * d.y
    }
}

/// Lots one beside the other along a frontage, each as deep as there is room for.
fn along(frontage: &Frontage, usage: LotUse, site: &Site, taken: &mut Occupancy, s: &mut Stream, lots: &mut Vec<Lot>) {
    let is_aisle = frontage.speed_limit_mps * 3.6 < f64::from(AISLE_KMH) + 1.0;
    let (least_m, most_m) = usage.length_m();
    let end = frontage.length_m() - 0.4;
    let mut from = 0.4;
    while from + least_m < end {
        let drawn_m = s.range(least_m, most_m);
        // What is left is no lot of its own.
        let wanted_m = if end - from - drawn_m < least_m { end - from } else { drawn_m }.min(most_m + least_m);
        let mut seed = Stream::from_seed("lot", s.next_u64());
        let lengths = [wanted_m, 0.8 * wanted_m, least_m];
        let found = usage.depths_m().iter().find_map(|depth_m| {
            lengths.into_iter().filter(|l| *l >= least_m).find_map(|length_m| {
                let plot = plot_at(frontage, site, from, length_m, *depth_m)?;
                (plot.length_m > LEAST_CHORD * length_m && fits(&plot, site, taken)).then_some(plot)
            })
        });
        let Some(plot) = found else {
            from += 4.0;
            continue;
        };
        let layout = match usage {
            LotUse::CarPark => car_park::lay_out(plot.length_m, plot.depth_m, is_aisle, &mut seed),
            LotUse::Industry => industry::lay_out(plot.length_m, plot.depth_m, &mut seed),
            LotUse::Campus => campus::lay_out(plot.length_m, plot.depth_m, &mut seed),
        };
        from += plot.length_m + GAP_M;
        taken.take(plot.whole());
        lots.push(Lot { plot, layout });
    }
}
