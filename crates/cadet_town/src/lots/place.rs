//! Puts what stands on lots.

use std::sync::Arc;

use crate::lots::{Lot, Lots};
use crate::placement::occupancy::Occupancy;
use crate::placement::placer::{Placer, boundary_palette};
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
            let axis = self.direction(bay.heading);
            let half = DVec2::new(bay.length_m, bay.width_m) / 2.0;
            let rect = OrientedRect { center: self.at(bay.at), axis, half };
            taken.take(rect);
            placer.bays.push(rect);
        }
        for item in &self.layout.items {
            let (at, facing) = (self.at(item.at), self.direction(item.facing));
            let axis = facing.normalize_or(DVec2::X);
            let middle = (item.drawn.model.footprint_min + item.drawn.model.footprint_max) / 2.0;
            let center = at + axis * middle.x + axis.perp() * middle.y;
            let rect = OrientedRect { center, axis, half: item.drawn.model.footprint_size() / 2.0 };
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
            let palette = boundary_palette(*boundary, s);
            placer.run(*boundary, &palette, self.at(*from), self.at(*to));
            let (p, q) = (self.at(*from), self.at(*to));
            let half = DVec2::new((q - p).length() / 2.0, 0.3);
            taken.take(OrientedRect { center: p.midpoint(q), axis: (q - p).normalize_or(DVec2::X), half });
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
