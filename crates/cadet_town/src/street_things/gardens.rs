//! What stands in front gardens and drives.

use crate::network::ParkingSpot;
use crate::placement::footprint;
use crate::plots::Plot;
use crate::street_things::Furnisher;
use cadet_assets::props::{CARPORT, Drawn, Facing, Homes, Place};
use cadet_assets::scenery::HouseKind;
use cadet_base::frames;
use cadet_base::math::DVec2;
use cadet_base::plane::OrientedRect;
use cadet_base::rng::Stream;

/// Share of the gardens that have something in front.
const FURNISHED_SHARE: f64 = 0.45;
/// Share of the drives that are roofed over.
const CARPORT_SHARE: f64 = 0.12;
/// Front gardens less deep than this have no room.
const LEAST_SETBACK_M: f64 = 2.6;

/// Furnishes the garden of a house, or a vacant plot's.
pub(super) fn furnish(f: &mut Furnisher, plot: &Plot, clutter: f64, s: &mut Stream) {
    let Some(house) = plot.house.as_ref().filter(|h| h.setback_m >= LEAST_SETBACK_M) else { return };
    if !s.chance((FURNISHED_SHARE * clutter).min(0.95)) {
        return;
    }
    let is_flats = house.house.kind() == Some(HouseKind::Flats);
    let half = plot.length_m / 2.0;
    let wanted = if is_flats { Homes::Flats } else { Homes::Houses };
    let rules = f.own.placed(|place| match place {
        Place::Garden(rule) if rule.homes == wanted => Some(*rule),
        _ => None,
    });
    let weights: Vec<f64> = rules.iter().map(|(_, rule)| rule.weight).collect();
    for _ in 0..1 + s.below(if is_flats { 4 } else { 3 }) {
        let (prop, rule) = &rules[s.weighted(&weights)];
        let (fewest, most) = rule.count;
        let count = fewest + s.below(most - fewest + 1);
        // All but sheds and the like stands in front of the house.
        let reach = if rule.is_behind { plot.depth_m - 1.5 } else { house.setback_m - 0.5 };
        let least = if rule.is_behind { 0.6 * house.setback_m } else { 0.9 };
        let (mut a, d) = (s.range(-half + 0.8, half - 0.8), s.range(least, reach.max(least + 0.1)));
        let facing = match rule.facing {
            Facing::Either if s.chance(0.6) => plot.out(),
            Facing::Along => plot.along * if s.chance(0.5) { 1.0 } else { -1.0 } + plot.out() * s.range(-0.3, 0.3),
            _ => -plot.out() + plot.along * s.range(-0.06, 0.06),
        };
        for _ in 0..count {
            let drawn = prop.draw(s);
            let _ = f.put_drawn(&drawn, plot.at(a, d), facing);
            a += drawn.model.footprint_size().max_element().min(1.8) + s.range(0.1, 0.5);
            if a > half - 0.8 {
                break;
            }
        }
    }
}

/// Roofs a drive over, now and then: a car may still be parked below.
pub(super) fn roof_over(f: &mut Furnisher, spot: &ParkingSpot, s: &mut Stream) {
    if !s.chance(CARPORT_SHARE) {
        return;
    }
    let Drawn { model, palette, .. } = CARPORT.draw(s);
    let size = model.footprint_size();
    if size.x > spot.length_m + 0.1 || size.y < spot.width_m + 0.2 {
        return;
    }
    let OrientedRect { center: at, axis, .. } = spot.rect();
    let rect = footprint(&model, at, axis);
    // It stands on its posts, beside the car: only they must be free.
    let feet = [(-1.0, -1.0), (-1.0, 1.0), (0.0, -1.0), (0.0, 1.0), (1.0, -1.0), (1.0, 1.0)].map(|(x, y)| {
        let center = at + axis * (x * (rect.half.x - 0.06)) + axis.perp() * (y * (rect.half.y - 0.06));
        OrientedRect { center, axis, half: DVec2::splat(0.06) }
    });
    let is_free = feet.iter().all(|foot| f.taken.is_free(foot) && !f.placer.site.is_street(foot.center));
    if is_free && f.taken.is_free(&rect.grown(-0.3)) {
        let pose = frames::upright(spot.world_from_spot.translation, frames::yaw_of(&spot.world_from_spot));
        f.placer.instances.push(model.with_palette(palette, pose));
        feet.iter().for_each(|foot| f.taken.take(*foot));
    }
}
