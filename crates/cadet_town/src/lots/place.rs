//! Puts what stands on lots.

use std::sync::Arc;

use crate::lots::{Lot, Lots};
use crate::placement::{Occupancy, Placer, footprint};
use crate::street_things::{Seat, StreetThings};
use cadet_assets::scenery::{TreeKind, num_variants, tree};
use cadet_base::math::DVec2;
use cadet_base::plane::OrientedRect;
use cadet_base::rng::{Stream, StreamKey};

/// Trunks keep so far from bays and from what stands.
const TRUNK_APART_M: f64 = 0.35;

impl Lots {
    /// Puts buildings, furniture, borders, and plants; returns seats, and what people keep off.
    pub fn place(&self, key: &StreamKey, greenery: f64, placer: &mut Placer) -> StreetThings {
        let mut things = StreetThings::default();
        for (i, lot) in self.lots.iter().enumerate() {
            lot.place(greenery, &mut key.indexed("lots/plants", i as u64), placer, &mut things);
        }
        things
    }
}

impl Lot {
    fn place(&self, greenery: f64, s: &mut Stream, placer: &mut Placer, things: &mut StreetThings) {
        let mut taken = Occupancy::default();
        for bay in &self.layout.bays {
            let half = DVec2::new(bay.length_m, bay.width_m) / 2.0;
            let rect = OrientedRect { center: self.at(bay.at), axis: self.direction(bay.heading), half };
            taken.take(rect);
            placer.bays.push(rect);
        }
        for item in &self.layout.items {
            let (at, facing) = (self.at(item.at), self.direction(item.facing));
            let rect = footprint(&item.drawn.model, at, facing);
            let is_on_street = rect.samples(0.5).any(|p| placer.site.is_street(p));
            // Trees and lamps stand on islands.
            let is_low = item.drawn.model.height_m < 0.2;
            if is_on_street || !taken.is_free(&rect) {
                continue;
            }
            if !is_low {
                taken.take(rect);
                things.obstacles.push(rect);
            }
            placer.put(&item.drawn.model, Arc::clone(&item.drawn.palette), at, facing);
            if is_low {
                placer.standing.pop();
            }
            things.seats.extend(Seat::of_last(&item.drawn, placer));
        }
        for (boundary, from, to) in &self.layout.borders {
            let palette = boundary.palette(s);
            let (p, q) = (self.at(*from), self.at(*to));
            placer.run(*boundary, &palette, p, q);
            taken.take(OrientedRect::about_line(p, q, 0.3));
        }
        let [_, variants, ..] = num_variants();
        let street_tree = s.below(variants);
        for (kind, at) in &self.layout.trees {
            if !s.chance(greenery.min(1.0)) {
                continue;
            }
            // One kind along all of a lot.
            let model = tree(*kind, if *kind == TreeKind::Street { street_tree } else { s.below(variants) });
            let at = self.at(*at);
            let reach_m = if *kind == TreeKind::Shrub { 0.75 * model.footprint_max.x } else { TRUNK_APART_M };
            if taken.is_free_at(at, reach_m) && placer.site.is_clear(at, reach_m) {
                let _ = placer.plant_model(*kind, &model, s, at);
            }
        }
    }
}
