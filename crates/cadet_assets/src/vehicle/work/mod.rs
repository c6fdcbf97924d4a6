//! Vehicles that work: trucks and buses, and what is parked beside the road without an engine or with two wheels.

mod body;
mod cab;
mod caravan;
mod coach;
mod frame;
mod hull;
mod motorbike;
mod plan;
#[cfg(test)]
mod tests;
mod towed;

use std::sync::Arc;

use super::levels::{Blueprint, Fitted, wheels_of};
use super::surface::Surface;
use super::{VehicleModel, work_paint};
use cadet_base::actor::{AnnotatedBox, ObjectClass};
use cadet_base::error::Result;
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

use cab::Cab;
use coach::Coach;
use plan::{Chassis, Plan, TowedPlan};

pub(super) use hull::{Cell, Hull, Part};

/// Length, width and height of the truck or trailer of a seed.
pub(super) fn size_of_seed(class: ObjectClass, model_seed: u64) -> DVec3 {
    let mut s = Stream::from_seed("vehicle", model_seed);
    let size = |l: f32, w: f32, h: f32| Vec3::new(l, w, h).as_dvec3();
    if class == ObjectClass::Truck {
        let p = Plan::draw(&mut s);
        size(p.length_m, p.width_m, p.height_m)
    } else {
        let p = TowedPlan::draw(&mut s);
        size(p.length_m, p.width_m, p.height_m)
    }
}

/// The truck of a seed.
pub(super) fn truck(model_seed: u64, s: &mut Stream) -> Result<VehicleModel> {
    let p = Plan::draw(s);
    let palette = work_paint::palette(ObjectClass::Truck, p.livery(), s);
    let has_passenger = s.chance(0.35);
    let front: Front = if p.chassis == Chassis::Bus { Front::Coach(Coach::new(&p)) } else { Front::Cab(Cab::new(&p)) };
    let size = Vec3::new(p.length_m, p.width_m, p.height_m);
    p.load().check()?;
    let fitted = Fitted::new(p.name(), TruckBlueprint { plan: p, front, has_passenger }, size);
    let (body, p) = (fitted.body(), &fitted.blueprint.plan);
    let wheel = wheels_of(p.name(), p.wheel_radius_m, p.tyre_width_m, frame::RIM);
    let wheel_centers = std::array::from_fn(|k| {
        let y = if k % 2 == 0 { p.hub_y() } else { -p.hub_y() };
        Vec3 { z: p.wheel_radius_m, ..fitted.fit(0).point(Vec3::new(p.axles_x[k / 2], y, p.wheel_radius_m)) }
    });
    Ok(VehicleModel {
        name: format!("{}/{model_seed}", p.name()),
        class: ObjectClass::Truck,
        size_lwh: size.as_dvec3(),
        annotated: AnnotatedBox::exact(size.as_dvec3()),
        body,
        driver: Some(fitted.occupants()),
        wheel: Some(wheel),
        wheel_centers,
        wheel_radius_m: f64::from(p.wheel_radius_m),
        palette: Arc::new(palette),
        has_lenses: true,
        openings: None,
        livery: p.livery(),
    })
}

/// What drives a truck: a cab before what it carries, or a whole coach.
enum Front {
    Cab(Cab),
    Coach(Coach),
}

/// What a truck or a bus is drawn from.
struct TruckBlueprint {
    plan: Plan,
    front: Front,
    has_passenger: bool,
}

impl Blueprint for TruckBlueprint {
    fn shell(&self, level: usize) -> Surface {
        let (mut surface, p) = (Surface::default(), &self.plan);
        match &self.front {
            Front::Coach(coach) => coach.add(&mut surface, p, level),
            Front::Cab(cab) => {
                cab.add(&mut surface, p, level);
                frame::add_frame(&mut surface, p, level);
                frame::add_coupling(&mut surface, p, level);
                p.load().add(&mut surface, level);
            }
        }
        frame::add_fixed_wheels(&mut surface, p, level);
        surface
    }

    fn add_more(&self, surface: &mut Surface, level: usize) {
        match &self.front {
            Front::Coach(coach) => coach.add_mirrors(surface, level),
            Front::Cab(cab) => cab.add_mirrors(surface, level),
        }
    }

    fn occupants(&self, level: usize) -> Surface {
        match &self.front {
            Front::Coach(coach) => coach.occupants(level),
            Front::Cab(cab) => cab.occupants(self.has_passenger, level),
        }
    }
}

/// The trailer or motorbike of a seed.
pub(super) fn towed(model_seed: u64, s: &mut Stream) -> Result<VehicleModel> {
    let p = TowedPlan::draw(s);
    let palette = work_paint::palette(ObjectClass::Misc, p.livery(), s);
    let size = Vec3::new(p.length_m, p.width_m, p.height_m);
    p.load().check()?;
    let fitted = Fitted::new(p.name(), p, size);
    let p = &fitted.blueprint;
    let stand = p.stand();
    let wheel_centers = std::array::from_fn(|k| {
        let x = if k < 2 { stand.leg_x } else { stand.wheels_x };
        Vec3::new(x, if k % 2 == 0 { stand.half_track_m } else { -stand.half_track_m }, 0.2)
    });
    Ok(VehicleModel {
        name: format!("{}/{model_seed}", p.name()),
        class: ObjectClass::Misc,
        size_lwh: size.as_dvec3(),
        annotated: AnnotatedBox::exact(size.as_dvec3()),
        body: fitted.body(),
        driver: None,
        wheel: None,
        wheel_centers,
        wheel_radius_m: 0.2,
        palette: Arc::new(palette),
        has_lenses: true,
        openings: None,
        livery: p.livery(),
    })
}
