//! Lays plots along the frontages: which house goes where, without overlaps.

pub(crate) mod belt;
mod city_paving;
mod city_rows;
mod frontage;
pub(crate) mod garden;
mod lot_use;
mod plot;
mod street_style;

pub(crate) use city_paving::Paving;
pub(crate) use frontage::{Frontage, distance_from_streets, frontages, right_of};
pub(crate) use lot_use::LotUse;
pub(crate) use plot::{PlacedHouse, Plot};
pub(crate) use street_style::{CityStyle, StreetStyle};

use crate::placement::{Occupancy, Site};
use cadet_assets::scenery::{HouseKind, house, num_variants};
use cadet_base::math::DVec2;
use cadet_base::rng::Stream;

/// Between the sidewalk's edge and the plot.
const FRONT_GAP_M: f64 = 0.12;
/// Where sidewalks swing out to deep bays between two points of the frontage, the front moves back by steps of the first,
/// by no more than the second.
const BACK_M: (f64, f64) = (0.1, 1.2);
const GARAGE_BAY_M: f64 = 3.0;
/// A house with its garage is laid out along the frontage: where it bends, and most at the ends of deep bays, the plot's
/// straight front is shorter, by no more than this.
const MOST_BENT_M: f64 = 0.6;

/// A plot over [s, s + length] of a frontage, its front moved back until the sidewalk is clear of it.
pub(crate) fn plot_at(frontage: &Frontage, site: &Site, s_m: f64, length_m: f64, depth_m: f64) -> Option<Plot> {
    let (p, q) = (frontage.at(s_m), frontage.at(s_m + length_m));
    let along = (q - p).normalize_or_zero();
    if along == DVec2::ZERO {
        return None;
    }
    let out = right_of(along);
    let bulge = frontage.between(s_m, s_m + length_m).iter().map(|r| (*r - p).dot(out)).fold(0.0, f64::max);
    // Where the street bends too much the chord would leave a wedge of nothing.
    if bulge >= 3.5 {
        return None;
    }
    let front = (p + q) / 2.0 + out * (bulge + FRONT_GAP_M);
    let mut plot = Plot { front, along, length_m: (q - p).length(), depth_m, house: None };
    let mut back_m = 0.0;
    while back_m < BACK_M.1 && plot.front_line().any(|p| site.is_street(p)) {
        back_m += BACK_M.0;
        plot.front = front + out * back_m;
    }
    Some(plot)
}

/// A house of a kind that could go here: the plot's length and the house on it.
fn propose(kind: HouseKind, style: &StreetStyle, s: &mut Stream) -> (f64, f64, PlacedHouse) {
    let [variants, ..] = num_variants();
    let house = house(kind, s.below(variants));
    let size_m = house.model.footprint_size();
    let (setback_m, left, mut right, back) = match kind {
        HouseKind::Detached => (style.setback_m + s.range(-0.6, 0.8), s.range(2.5, 4.5), s.range(2.5, 4.0), 11.0),
        HouseKind::Semi => (style.setback_m + s.range(-0.3, 0.3), s.range(2.5, 3.5), s.range(2.5, 3.5), 10.0),
        HouseKind::Terrace => (style.setback_m.min(5.0), 0.6, s.range(0.6, 2.5), 9.0),
        HouseKind::Village => (s.range(0.3, 0.75), s.range(0.3, 2.0), s.range(0.5, 3.0), 6.0),
        HouseKind::Block => (s.range(0.3, 0.4), 0.06, 0.06, 5.0),
        HouseKind::Flats => (s.range(4.5, 10.0), s.range(2.5, 5.0), s.range(2.5, 5.0), 7.0),
    };
    let garage_share = match kind {
        HouseKind::Detached | HouseKind::Semi => 0.7,
        HouseKind::Village | HouseKind::Flats => 0.25,
        _ => 0.0,
    };
    let garage_bays = if s.chance(garage_share) { 1 + usize::from(s.chance(0.2)) } else { 0 };
    if garage_bays > 0 {
        right += GARAGE_BAY_M * garage_bays as f64 + 0.3;
    }
    let depth = setback_m + size_m.x + back;
    (size_m.y + left + right, depth, PlacedHouse { house, along_m: (left - right) / 2.0, setback_m, garage_bays })
}

/// Lays plots along one frontage and takes their ground.
pub(crate) fn lay_out(
    frontage: &Frontage,
    style: &StreetStyle,
    site: &Site,
    taken: &mut Occupancy,
    s: &mut Stream,
) -> Vec<Plot> {
    if style.city.is_some() {
        return city_rows::lay_out(frontage, site, taken, s);
    }
    let mut plots = Vec::new();
    let mut from = 0.3;
    while from < frontage.length_m() - 3.0 {
        let left = frontage.length_m() - 0.3 - from;
        let mut next = None;
        if !s.chance(style.vacant_share) {
            let first = style.houses[usize::from(!s.chance(style.main_share))];
            // What does not fit gives way to something smaller.
            for kind in [first, HouseKind::Detached, HouseKind::Village, HouseKind::Village] {
                let (length_m, depth_m, house) = propose(kind, style, s);
                if length_m > left {
                    continue;
                }
                let least = house.setback_m + house.size_m().x + 1.5;
                next = [depth_m, (depth_m + least) / 2.0, least].into_iter().find_map(|depth_m| {
                    let mut plot = plot_at(frontage, site, from, length_m, depth_m)?;
                    if plot.length_m < length_m - MOST_BENT_M {
                        return None;
                    }
                    plot.house = Some(house.clone());
                    fits(&plot, site, taken).then_some(plot)
                });
                if next.is_some() {
                    break;
                }
            }
        }
        if next.is_none() {
            let length_m = s.range(5.0, 9.0).min(left);
            next = [14.0, 7.0, 3.5].into_iter().find_map(|depth_m| {
                plot_at(frontage, site, from, length_m, depth_m).filter(|plot| fits(plot, site, taken))
            });
        }
        match next {
            Some(plot) => {
                from += plot.length_m + 0.05;
                taken.take(plot.whole());
                plots.push(plot);
            }
            None => from += 1.5,
        }
    }
    plots
}

pub(crate) fn fits(plot: &Plot, site: &Site, taken: &Occupancy) -> bool {
    let whole = plot.whole();
    taken.is_free(&whole) && site.is_rect_clear(&whole, 0.03)
}
