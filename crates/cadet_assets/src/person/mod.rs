//! People: walkers with a gait cycle, people who stand, and people who sit.

pub(super) mod arms;
pub(super) mod body;
pub(super) mod clothes;
pub(super) mod frame;
pub(super) mod gait;
pub(super) mod head;
pub(super) mod hold;
pub(super) mod proportions;
mod sitting;
#[cfg(test)]
mod tests;
pub(super) mod tube;

use std::sync::{Arc, OnceLock};

use crate::annotation;
use crate::belongings::{Belonging, Thing};
use cadet_base::actor::AnnotatedBox;
use cadet_base::geometry::{Bounds, LodSet};
use cadet_base::material::Palette;
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

use proportions::{ArmPose, Legwear, Load, PersonKind, Proportions, Top};
use sitting::{HIP_BEFORE_MIDDLE_M, Sitting};
use tube::Tubes;

/// Phases of the gait cycle that have a shape: 3 cm of way each.
const NUM_PHASES: usize = 48;
/// Where the levels of detail end, meters from the ego: a person is 140 and 57 pixels of KITTI's camera high there.
const LEVEL_LIMITS_M: [f32; 3] = [9.0, 22.0, f32::INFINITY];

/// A person's shape, in the box frame: x forward, y left, z up, origin on the ground.
#[derive(Debug, Clone)]
pub struct PersonModel {
    /// For example `"woman/12345"`.
    pub name: String,
    /// Length, width, height of the body's box: the largest over the gait cycle for a walker.
    pub size_lwh: DVec3,
    /// What an annotator would draw instead.
    pub annotated: AnnotatedBox,
    /// Walking speed that the stride fits, m/s; 0 for a person who stands.
    pub walking_speed_mps: f64,
    /// Length of a full gait cycle (two steps) on the ground, meters.
    pub cycle_length_m: f64,
    /// The materials.
    pub palette: Arc<Palette>,
    proportions: Arc<Proportions>,
    /// How the person sits, if they do.
    sitting: Option<Sitting>,
    /// What the person has along, if anything.
    pub belonging: Option<Belonging>,
    seed: u64,
    /// From the pelvis' vertical to the middle of the cycle's bounds.
    offset: Vec3,
    shapes: Arc<[OnceLock<LodSet>; NUM_PHASES]>,
}

impl PersonModel {
    /// The person of a seed, of a body that fills an annotated box drawn from KITTI's; one in four stands.
    #[must_use]
    pub fn generate(model_seed: u64) -> Self {
        let mut s = Stream::from_seed("person", model_seed);
        let annotated = annotation::person_box(&mut s);
        let stature_m = annotation::person_height_m(&annotated, &mut s);
        let mut p = Proportions::draw(annotation::is_standing(&annotated), stature_m, &mut s);
        let wanted = annotation::person_extents(&annotated);
        let found = cycle_bounds(&p, None, 3, 1).size();
        p.grow(wanted.x as f32 - found.x, wanted.y as f32 - found.y);
        Self::of(p, None, annotated, model_seed, &mut s)
    }

    /// The person of a seed who sits on a seat of a height, of a size that goes with an annotated box drawn from KITTI's.
    #[must_use]
    pub fn sitting(model_seed: u64, seat_m: f64) -> Self {
        let mut s = Stream::from_seed("sitting person", model_seed);
        let annotated = annotation::sitting_box(&mut s);
        let stature_m = annotation::sitting_stature_m(&annotated, &mut s);
        let mut p = Proportions::draw(true, stature_m, &mut s);
        // Bags are put down; what hangs over the legs of those who stand would hang through the seat.
        p.load = Load::None;
        p.legwear = if p.legwear == Legwear::Skirt { Legwear::WideTrousers } else { p.legwear };
        p.top = if p.top == Top::Coat { Top::Jacket } else { p.top };
        let mut sitting = Sitting::draw(seat_m as f32, annotated.size_lwh.x, &mut s);
        // Clothes and girth tell how high the hips are over the seat.
        for _ in 0..2 {
            let body = grounded(&p, Some(&sitting), 0, 0);
            let on_seat = body.vertices.iter().filter(|v| (-0.17..0.08).contains(&v.x) && v.y.abs() < 0.2 && v.z > 0.3);
            sitting.hip_over_seat_m += sitting.seat_m - on_seat.map(|v| v.z).fold(f32::INFINITY, f32::min);
        }
        Self::of(p, Some(sitting), annotated, model_seed, &mut s)
    }

    fn of(p: Proportions, sitting: Option<Sitting>, annotated: AnnotatedBox, model_seed: u64, s: &mut Stream) -> Self {
        let palette = clothes::palette(p.kind, p.headwear, s);
        let bounds = cycle_bounds(&p, sitting.as_ref(), 2, 0);
        let (size, center) = (bounds.size(), bounds.center());
        Self {
            name: format!("{}/{model_seed}", p.kind.as_ref()),
            size_lwh: size.with_z(bounds.max.z).as_dvec3(),
            annotated,
            walking_speed_mps: f64::from(p.speed_mps),
            cycle_length_m: f64::from(p.cycle_length_m),
            palette: Arc::new(palette),
            sitting,
            belonging: None,
            seed: model_seed,
            offset: Vec3::new(-center.x, -center.y, 0.0),
            proportions: Arc::new(p),
            shapes: Arc::new([const { OnceLock::new() }; NUM_PHASES]),
        }
    }

    /// What the person's own draws begin with.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Whether somebody is a child.
    pub fn is_child(&self) -> bool {
        self.proportions.kind == PersonKind::Child
    }

    /// Whether somebody sits.
    pub fn sits(&self) -> bool {
        self.sitting.is_some()
    }

    /// Whether somebody is old.
    pub fn is_elderly(&self) -> bool {
        self.proportions.is_elderly
    }

    /// Returns this person with a thing along, in the hand of a side if it takes one: +1 is the left. Sizes and boxes
    /// stay those of the body.
    #[must_use]
    pub fn carrying(&self, thing: Thing, side: f32) -> Self {
        let mut p = Proportions::clone(&self.proportions);
        let belonging = Belonging::draw(thing, &p, self.offset, side, self.seed);
        p.held = belonging.hands;
        for (arm, held) in p.arms.iter_mut().zip(&p.held) {
            // The other arm leaves what takes both, and a bag goes to the other hand.
            if held.is_none() && *arm == ArmPose::Crossed {
                *arm = ArmPose::Hang;
            }
        }
        if p.load == Load::Shopping {
            match p.held {
                [Some(_), None] => p.arms[1] = ArmPose::Carry,
                [None, Some(_)] => p.arms[0] = ArmPose::Carry,
                _ => p.load = Load::None,
            }
        }
        let (kind, what) = (p.kind.as_ref(), thing.as_ref());
        Self {
            name: format!("{kind} with {what}/{}", self.seed),
            proportions: Arc::new(p),
            belonging: Some(belonging),
            shapes: Arc::new([const { OnceLock::new() }; NUM_PHASES]),
            ..self.clone()
        }
    }

    /// The box frame's origin, in the frame of the seat that somebody sits on: x forward, on the ground below its middle.
    #[must_use]
    pub fn seat_from_box(&self) -> DVec3 {
        DVec3::new(f64::from(HIP_BEFORE_MIDDLE_M - self.offset.x), f64::from(-self.offset.y), 0.0)
    }

    /// The shape at a phase of the gait cycle in [0, 1), one of 48 that are made once; the left heel strikes at 0.
    #[must_use]
    pub fn pose(&self, phase: f64) -> LodSet {
        let wrapped = phase - phase.floor();
        let k = if self.proportions.speed_mps > 0.0 { (wrapped * NUM_PHASES as f64) as usize % NUM_PHASES } else { 0 };
        let shape = self.shapes[k].get_or_init(|| {
            // Most people are far away, and few are seen in more than one phase from near by.
            let (p, sitting) = (Arc::clone(&self.proportions), self.sitting);
            let make = move |level: usize| grounded(&p, sitting.as_ref(), k, level);
            Tubes::lods(&self.name, LEVEL_LIMITS_M, self.offset, make)
        });
        shape.clone()
    }
}

/// The bounds of a body over its cycle; one in `every` phases is looked at.
fn cycle_bounds(p: &Proportions, sitting: Option<&Sitting>, every: usize, level: usize) -> Bounds {
    let num_phases = if p.speed_mps > 0.0 { NUM_PHASES } else { 1 };
    (0..num_phases)
        .step_by(every)
        .map(|k| Bounds::of(grounded(p, sitting, k, level).vertices))
        .fold(Bounds::EMPTY, |a, b| Bounds { min: a.min.min(b.min), max: a.max.max(b.max) })
}

/// The body at a quantized phase with its lower sole on the ground, or with its seat on what it sits on.
fn grounded(p: &Proportions, sitting: Option<&Sitting>, phase_index: usize, level: usize) -> Tubes {
    let posture = match sitting {
        Some(sitting) => sitting.posture(p),
        None if p.speed_mps > 0.0 => gait::walking(p, phase_index as f32 / NUM_PHASES as f32),
        None => gait::standing(p),
    };
    let mut tubes = body::body(p, &posture, level);
    let low = match sitting {
        Some(sitting) => -sitting.hip_m(),
        None => tubes.vertices.iter().fold(f32::INFINITY, |a, v| a.min(v.z)),
    };
    for v in &mut tubes.vertices {
        v.z -= low;
    }
    tubes
}
