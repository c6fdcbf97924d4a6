//! Bicycles with their riders.

mod bicycle;
mod paint;
mod rider;
mod shape;
#[cfg(test)]
mod tests;

use std::sync::{Arc, OnceLock};

use crate::annotation;
use crate::person::proportions::{Headwear, Legwear, Load, PersonKind, Proportions, Top};
use crate::person::tube::Tubes;
use cadet_base::actor::AnnotatedBox;
use cadet_base::geometry::{Bounds, LodSet};
use cadet_base::material::Palette;
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

use bicycle::Bicycle;
use rider::{Legs, Seat};

/// Phases of the crank that have a shape.
const NUM_PHASES: usize = 24;
/// Where the levels of detail end, meters from the ego, as of people.
const LEVEL_LIMITS_M: [f32; 3] = [9.0, 22.0, f32::INFINITY];
/// Steps in which an arm is stretched out.
const ARM_STEPS: usize = 4;
/// Shares of adults and of children who wear a helmet.
const HELMET_SHARE: f64 = 0.2;
const CHILD_HELMET_SHARE: f64 = 0.6;

/// What a cyclist is made of, fixed for its life.
#[derive(Debug)]
struct Design {
    bicycle: Bicycle,
    rider: Proportions,
    riding: Seat,
    standing: Seat,
    /// The foot that is put down: the left one if +1.
    foot: f32,
}

/// A cyclist's shape, in the box frame: x forward, y left, z up, origin on the ground midway between the axles.
#[derive(Debug, Clone)]
pub struct CyclistModel {
    /// For example `"woman on bicycle/12345"`.
    pub name: String,
    /// Length, width, height of what rides, the crank's turn included.
    pub size_lwh: DVec3,
    /// What an annotator would draw instead.
    pub annotated: AnnotatedBox,
    /// Radius of the tires: also the height of the axles.
    pub wheel_radius_m: f64,
    /// Distance of the axles, which are as far before as behind the origin.
    pub wheelbase_m: f64,
    /// Way on the ground for a turn of the crank, meters.
    pub development_m: f64,
    /// The materials.
    pub palette: Arc<Palette>,
    /// A wheel about its axle.
    pub wheel: Arc<LodSet>,
    design: Arc<Design>,
    /// Bicycle, trunk, arms, and head: riding, and with a foot on the ground.
    bodies: [Arc<LodSet>; 2],
    legs: Arc<[OnceLock<Arc<LodSet>>; NUM_PHASES + 1]>,
    /// Bodies that point to the left and to the right, an arm stretched out farther and farther.
    pointing: Arc<[[OnceLock<Arc<LodSet>>; ARM_STEPS]; 2]>,
}

impl CyclistModel {
    /// The cyclist of a seed, whose bicycle and height go with an annotated box drawn from KITTI's.
    #[must_use]
    pub fn generate(model_seed: u64) -> Self {
        let mut s = Stream::from_seed("cyclist", model_seed);
        let annotated = annotation::cyclist_box(&mut s);
        let true_lwh = annotation::cyclist_size(&annotated, &mut s);
        let design = Arc::new(Design::draw(true_lwh, &mut s));
        let palette = paint::palette(&design.rider, &mut s);
        let name = format!("{} on bicycle/{model_seed}", design.rider.kind.as_ref());
        let riding = design.body(false, None, 0);
        let bounds = (0..NUM_PHASES)
            .map(|k| Bounds::of(design.legs(phase_legs(k), 0).vertices))
            .fold(Bounds::of(riding.vertices), |a, b| Bounds { min: a.min.min(b.min), max: a.max.max(b.max) });
        let wheels_half = design.bicycle.wheelbase_m / 2.0 + design.bicycle.wheel_radius_m;
        let half_length = wheels_half.max(bounds.max.x).max(-bounds.min.x);
        let half_width = bounds.max.y.max(-bounds.min.y);
        let size_lwh = Vec3::new(2.0 * half_length, 2.0 * half_width, bounds.max.z).as_dvec3();
        let bodies = [false, true].map(|stands| {
            let make = Arc::clone(&design);
            levels(&name, move |level| make.body(stands, None, level))
        });
        let make = Arc::clone(&design);
        let wheel = levels(&name, move |level| shape::wheel(&make.bicycle, level));
        Self {
            size_lwh,
            annotated,
            wheel_radius_m: f64::from(design.bicycle.wheel_radius_m),
            wheelbase_m: f64::from(design.bicycle.wheelbase_m),
            development_m: design.bicycle.development_m,
            palette: Arc::new(palette),
            wheel,
            design,
            bodies,
            legs: Arc::new([const { OnceLock::new() }; NUM_PHASES + 1]),
            pointing: Arc::new([const { [const { OnceLock::new() }; ARM_STEPS] }; 2]),
            name,
        }
    }

    /// Bicycle, trunk, arms, and head, riding or standing with a foot on the ground; the wheels are extra.
    #[must_use]
    pub fn body(&self, stands: bool) -> Arc<LodSet> {
        Arc::clone(&self.bodies[usize::from(stands)])
    }

    /// The riding body with an arm stretched out: wholly the left one at 1 and the right one at -1, none at 0.
    #[must_use]
    pub fn pointing(&self, arm_share: f64) -> Arc<LodSet> {
        let step = (arm_share.abs() * ARM_STEPS as f64).round() as usize;
        let Some(index) = step.min(ARM_STEPS).checked_sub(1) else { return self.body(false) };
        let shape = self.pointing[usize::from(arm_share < 0.0)][index].get_or_init(|| {
            let (design, share) = (Arc::clone(&self.design), step as f32 / ARM_STEPS as f32);
            let side = if arm_share < 0.0 { -1.0 } else { 1.0 };
            levels(&self.name, move |level| design.body(false, Some((side, share)), level))
        });
        Arc::clone(shape)
    }

    /// Legs and cranks of who rides, the crank at a phase in [0, 1), one of 24 that are made once.
    #[must_use]
    pub fn pedaling(&self, phase: f64) -> Arc<LodSet> {
        let k = ((phase - phase.floor()) * NUM_PHASES as f64) as usize % NUM_PHASES;
        self.legs_at(k, phase_legs(k))
    }

    /// Legs and cranks of who stands.
    #[must_use]
    pub fn standing(&self) -> Arc<LodSet> {
        self.legs_at(NUM_PHASES, Legs::Stand(self.design.foot))
    }

    /// Centers of the rear wheel and of the front one.
    #[must_use]
    pub fn axles(&self) -> [DVec3; 2] {
        self.design.bicycle.axles().map(Vec3::as_dvec3)
    }

    fn legs_at(&self, index: usize, legs: Legs) -> Arc<LodSet> {
        let shape = self.legs[index].get_or_init(|| {
            let design = Arc::clone(&self.design);
            levels(&self.name, move |level| design.legs(legs, level))
        });
        Arc::clone(shape)
    }
}

fn phase_legs(index: usize) -> Legs {
    Legs::Pedal(index as f32 / NUM_PHASES as f32)
}

fn levels(name: &str, make: impl Fn(usize) -> Tubes + Send + Sync + 'static) -> Arc<LodSet> {
    Arc::new(Tubes::lods(name, LEVEL_LIMITS_M, Vec3::ZERO, make))
}

impl Design {
    /// Draws bicycle and rider that together are about as long, wide, and high as asked for.
    fn draw(true_lwh: DVec3, s: &mut Stream) -> Self {
        let (rider_seed, bicycle_seed) = (s.next_u64(), s.next_u64());
        let wanted = true_lwh.as_vec3();
        let mut stature = f64::from(wanted.z);
        let mut design = Self::of_stature(stature, wanted, rider_seed, bicycle_seed);
        for _ in 0..4 {
            let top = design.body_top();
            stature = (stature + 0.95 * f64::from(wanted.z - top)).clamp(1.30, 2.02);
            design = Self::of_stature(stature, wanted, rider_seed, bicycle_seed);
        }
        design
    }

    fn of_stature(stature_m: f64, wanted: Vec3, rider_seed: u64, bicycle_seed: u64) -> Self {
        let mut s = Stream::from_seed("rider", rider_seed);
        let mut rider = Proportions::draw(false, stature_m, &mut s);
        rider.top = if rider.top == Top::Coat { Top::Jacket } else { rider.top };
        rider.legwear = if rider.legwear == Legwear::Skirt { Legwear::Shorts } else { rider.legwear };
        rider.load = match rider.load {
            Load::Shopping | Load::ShoulderBag => Load::None,
            load => load,
        };
        let helmets = if rider.kind == PersonKind::Child { CHILD_HELMET_SHARE } else { HELMET_SHARE };
        if s.chance(helmets) {
            rider.headwear = Headwear::Helmet;
        }
        let foot = if s.chance(0.6) { 1.0 } else { -1.0 };
        let mut s = Stream::from_seed("bicycle", bicycle_seed);
        let bicycle = Bicycle::draw(wanted.x, wanted.y, rider.stature_m, rider.kind == PersonKind::Woman, &mut s);
        let riding = Seat::riding(&rider, &bicycle);
        let standing = riding.standing(&rider, &bicycle);
        Self { bicycle, rider, riding, standing, foot }
    }

    fn seat(&self, stands: bool) -> &Seat {
        if stands { &self.standing } else { &self.riding }
    }

    fn body_top(&self) -> f32 {
        let tubes = self.riding.upper_body(&self.rider, &self.bicycle, None, 2);
        tubes.vertices.iter().fold(0.0, |top: f32, v| top.max(v.z))
    }

    /// The body, perhaps with an arm stretched out to a side by a share of the way.
    fn body(&self, stands: bool, pointing: Option<(f32, f32)>, level: usize) -> Tubes {
        let mut tubes = self.seat(stands).upper_body(&self.rider, &self.bicycle, pointing, level);
        shape::add_bicycle(&mut tubes, &self.bicycle, &self.riding, level);
        tubes
    }

    fn legs(&self, legs: Legs, level: usize) -> Tubes {
        let seat = self.seat(matches!(legs, Legs::Stand(_)));
        let mut tubes = seat.legs(&self.rider, &self.bicycle, legs, level);
        shape::add_cranks(&mut tubes, &self.bicycle, legs.crank_phase(), level);
        tubes
    }
}
