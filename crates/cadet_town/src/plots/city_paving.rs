//! Paves what is left between the sidewalks and closed rows: before cut corners, and where streets meet at an angle.

use crate::placement::{Occupancy, Placer};
use crate::plots::{Frontage, Plot};
use cadet_assets::props::FLAGSTONES;
use cadet_base::frames;
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::OrientedRect;

/// Beyond an end of a frontage and along it, and behind the sidewalk's edge.
const BEYOND_M: f64 = 11.0;
const ALONG_M: f64 = 6.0;
const DEEP_M: f64 = 8.0;
/// Stones lie on the sidewalk's edge by no more than this, and no farther from it than that.
const ON_SIDEWALK_M: f64 = 0.45;
const FROM_SIDEWALK_M: f64 = 4.5;
/// Between a stone and the carriageway: the curb.
const CURB_M: f64 = 0.3;

/// Ground that is paved, and ground that must not be.
pub(crate) struct Paving {
    kept: Occupancy,
    paved: Occupancy,
}

impl Paving {
    /// Nothing is paved yet; plots and walls stay as they are, but for the ground before cut corners.
    pub fn new<'a>(plots: impl Iterator<Item = &'a Plot>) -> Self {
        let is_cut = |plot: &Plot| plot.house.as_ref().is_some_and(|h| h.house.corner().is_some());
        let kept = plots.flat_map(|plot| if is_cut(plot) { plot.house_parts() } else { vec![plot.whole()] });
        Self { kept: Occupancy::of(kept), paved: Occupancy::default() }
    }

    /// Paves at both ends of a frontage.
    pub fn pave(&mut self, frontage: &Frontage, placer: &mut Placer) {
        let stone = FLAGSTONES.model(0);
        let side_m = stone.footprint_size().x;
        let length_m = frontage.length_m();
        for (end, way) in [(0.0, -1.0), (length_m, 1.0)] {
            let (origin, ahead, out) = (frontage.at(end), frontage.along(end) * way, frontage.out(end));
            let mut along_m = -ALONG_M.min(length_m / 2.0);
            while along_m < BEYOND_M {
                let mut deep_m = 0.0;
                while deep_m < DEEP_M {
                    let at = origin + ahead * along_m + out * deep_m;
                    if self.is_open(at, ahead, side_m, placer) {
                        self.paved.take(OrientedRect { center: at, axis: ahead, half: DVec2::splat(side_m / 2.0) });
                        let site = placer.site;
                        let (here, there) = (site.on_ground(at), site.on_ground(at + ahead * (side_m / 2.0)));
                        let aside = site.on_ground(at + ahead.perp() * (side_m / 2.0));
                        let up = (there - here).cross(aside - here).normalize_or(DVec3::Z);
                        placer.instances.push(stone.at(frames::facing(here, there - here, up)));
                    }
                    deep_m += side_m;
                }
                along_m += side_m;
            }
        }
    }

    fn is_open(&self, at: DVec2, ahead: DVec2, side_m: f64, placer: &Placer) -> bool {
        let site = placer.site;
        let clearance_m = site.clearance_m(at);
        if !(-ON_SIDEWALK_M..FROM_SIDEWALK_M).contains(&clearance_m) {
            return false;
        }
        let rect = OrientedRect { center: at, axis: ahead, half: DVec2::splat(side_m / 2.0 + CURB_M) };
        let on_road = rect.samples(0.6).any(|p| site.is_road(p));
        !on_road && self.kept.is_free_at(at, 0.05) && self.paved.is_free_at(at, 0.3 * side_m)
    }
}
