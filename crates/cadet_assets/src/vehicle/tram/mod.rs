//! Trams: trains of cars with bellows between, and single cars.

mod equipment;
mod inside;
mod plan;
mod shell;
#[cfg(test)]
mod tests;

use std::sync::{Arc, OnceLock};

use super::levels::{Blueprint, DISTANT, Fitted};
use super::paint::Livery;
use super::surface::Surface;
use super::{VehicleModel, work_paint};
use cadet_base::actor::{AnnotatedBox, ObjectClass};
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

use plan::CarPlan;
use shell::Shell;

/// Designs of trains, each made once a process when it is first asked for.
const NUM_TRAINS: usize = 12;
static TRAINS: [OnceLock<Vec<Arc<VehicleModel>>>; NUM_TRAINS] = [const { OnceLock::new() }; NUM_TRAINS];

/// From the middle of the track to the middle of a wheel's tread.
const HALF_TRACK_M: f32 = 0.75;
const WHEEL_RADIUS_M: f32 = 0.33;

/// The single car of a seed.
pub(super) fn single_car(model_seed: u64, s: &mut Stream) -> VehicleModel {
    model(&plan::single(s), model_seed, s)
}

/// The cars of a tram of traffic, the first ahead, all in the same colors; each has a label of its own.
#[must_use]
pub fn train_of_traffic(seed: u64) -> Vec<Arc<VehicleModel>> {
    let mut s = Stream::from_seed("traffic tram", seed);
    let number = s.below(NUM_TRAINS);
    let paint_seed = s.next_u64();
    let design = TRAINS[number].get_or_init(|| {
        let mut s = Stream::from_seed("tram", number as u64);
        plan::train(&mut s).iter().map(|car| Arc::new(model(car, number as u64, &mut s))).collect()
    });
    // One palette for all: a stream of its own for each car's box.
    let mut paint = Stream::from_seed("vehicle paint", paint_seed);
    let palette = Arc::new(work_paint::palette(ObjectClass::Tram, Livery::Tram, &mut paint));
    let cars = design.iter().map(|car| {
        let annotated = VehicleModel::clone(car).annotated_by(s.next_u64());
        Arc::new(VehicleModel { palette: Arc::clone(&palette), ..annotated })
    });
    cars.collect()
}

fn model(p: &CarPlan, number: u64, s: &mut Stream) -> VehicleModel {
    let palette = work_paint::palette(ObjectClass::Tram, Livery::Tram, s);
    let size = Vec3::new(p.length_m, p.width_m, p.height_m);
    // In a short car between two others there may be nobody.
    let is_empty = inside::occupants(p, DISTANT).builder.num_faces() == 0;
    let fitted = Fitted::new(p.name, p.clone(), size);
    // The outermost wheels stand on the ground: those of a single bogie 0.9 m before and behind its middle.
    let (front, rear) = match p.bogies[..] {
        [only] => (only + 0.9, only - 0.9),
        _ => (p.bogies[0], p.bogies[p.bogies.len() - 1]),
    };
    let (left, right) = (HALF_TRACK_M, -HALF_TRACK_M);
    let wheels = [(front, left), (front, right), (rear, left), (rear, right)];
    let wheel_centers = wheels.map(|(x, y)| Vec3::new(x, y, WHEEL_RADIUS_M));
    let size: DVec3 = size.as_dvec3();
    VehicleModel {
        name: format!("{}/{number}", p.name),
        class: ObjectClass::Tram,
        size_lwh: size,
        annotated: AnnotatedBox::exact(size),
        body: fitted.body(),
        driver: (!is_empty).then(|| fitted.occupants()),
        wheel: None,
        wheel_centers,
        wheel_radius_m: f64::from(WHEEL_RADIUS_M),
        palette: Arc::new(palette),
        has_lenses: true,
        openings: None,
        livery: Livery::Tram,
    }
}

impl Blueprint for CarPlan {
    fn shell(&self, level: usize) -> Surface {
        let mut surface = Surface::default();
        Shell::new(self).add(&mut surface, level);
        equipment::add_bellows(&mut surface, self, level);
        equipment::add_roof_boxes(&mut surface, self, level);
        equipment::add_bogies(&mut surface, self, level);
        equipment::add_ends(&mut surface, self, level);
        surface
    }

    fn add_more(&self, surface: &mut Surface, level: usize) {
        if level != DISTANT {
            inside::add(surface, self, level);
        }
        equipment::add_what_sticks_out(surface, self, level);
    }

    fn occupants(&self, level: usize) -> Surface {
        inside::occupants(self, level)
    }
}
