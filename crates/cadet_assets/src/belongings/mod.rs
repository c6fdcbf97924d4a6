//! What people have with them beside what they wear: umbrellas, prams, dogs, wheeled cases, rollators, sticks,
//! crutches.

mod dog;
mod paint;
mod pram;
mod rolling;
mod shapes;
mod stick;
#[cfg(test)]
mod tests;
mod thing;
mod umbrella;

use std::sync::{Arc, OnceLock};

use super::person::hold::Hold;
use super::person::proportions::Proportions;
use super::person::tube::Tubes;
use cadet_base::geometry::LodSet;
use cadet_base::material::Palette;
use cadet_base::math::Vec3;
use cadet_base::rng::Stream;

pub use thing::Thing;

use dog::Dog;
use pram::Pram;
use rolling::{Case, Rollator};
use stick::Sticks;
use umbrella::Umbrella;

/// Phases of the owner's gait at which dogs have a shape, and sticks, as their owners do.
const NUM_PHASES: usize = 24;
const NUM_STICK_PHASES: usize = 48;
/// Where the levels of detail end, meters from the ego, as of people; leads and dogs are not seen beyond the last.
const LEVEL_LIMITS_M: [f32; 3] = [9.0, 22.0, 120.0];

#[derive(Debug)]
enum Design {
    Umbrella(Umbrella),
    Pram(Pram),
    Dog(Dog),
    Case(Case),
    Rollator(Rollator),
    Sticks(Sticks),
}

/// A thing of somebody's, in the person's box frame.
#[derive(Debug, Clone)]
pub struct Belonging {
    /// Its materials.
    pub palette: Arc<Palette>,
    /// Where the hands that hold it are: left, right.
    pub(crate) hands: [Option<Hold>; 2],
    design: Arc<Design>,
    offset: Vec3,
    shapes: Arc<[OnceLock<Arc<LodSet>>; NUM_STICK_PHASES]>,
}

impl Belonging {
    /// The thing of a seed, in the hand of a side if it takes one, for a person whose box frame is `offset` from the pelvis' vertical.
    pub(super) fn draw(thing: Thing, p: &Proportions, offset: Vec3, side: f32, seed: u64) -> Self {
        let mut s = Stream::from_seed("belonging", seed);
        let palette = Arc::new(paint::palette(thing, &mut s));
        let one = |hand: Vec3| {
            let hold = Some(Hold::Still(hand));
            if side > 0.0 { [hold, None] } else { [None, hold] }
        };
        let both = |hands: [Vec3; 2]| hands.map(|hand| Some(Hold::Still(hand)));
        let (stature, cycle_m) = (p.stature_m, if p.speed_mps > 0.0 { p.cycle_length_m } else { 0.0 });
        let (hands, design) = match thing {
            Thing::Umbrella => {
                let umbrella = Umbrella::draw(stature, side, &mut s);
                (one(umbrella.hand), Design::Umbrella(umbrella))
            }
            Thing::Pram => {
                let pram = Pram::draw(stature, &mut s);
                (both(pram.hands()), Design::Pram(pram))
            }
            Thing::Dog => {
                let dog = Dog::draw(stature, side, cycle_m, &mut s);
                (one(dog.hand), Design::Dog(dog))
            }
            Thing::Case => {
                let case = Case::draw(stature, side, &mut s);
                (one(case.hand), Design::Case(case))
            }
            Thing::Rollator => {
                let rollator = Rollator::draw(stature, &mut s);
                (both(rollator.hands()), Design::Rollator(rollator))
            }
            Thing::Stick | Thing::Crutch | Thing::Crutches => {
                let sides: &[f32] = if thing == Thing::Crutches { &[1.0, -1.0] } else { &[side.signum()] };
                let sticks = Sticks::draw(p, sides, thing != Thing::Stick, &mut s);
                (sticks.hands(), Design::Sticks(sticks))
            }
        };
        let shapes = Arc::new([const { OnceLock::new() }; NUM_STICK_PHASES]);
        Self { palette, hands, design: Arc::new(design), offset, shapes }
    }

    /// Whether it stands on the ground and hides the sky from it.
    pub fn is_solid(&self) -> bool {
        matches!(*self.design, Design::Pram(_) | Design::Case(_) | Design::Rollator(_))
    }

    fn num_phases(&self) -> usize {
        match *self.design {
            Design::Dog(_) => NUM_PHASES,
            Design::Sticks(_) => NUM_STICK_PHASES,
            _ => 1,
        }
    }

    /// The shape at a phase of the owner's gait in [0, 1), made when it is first used.
    pub fn pose(&self, phase: f64) -> Arc<LodSet> {
        let phases = self.num_phases();
        let k = ((phase - phase.floor()) * phases as f64) as usize % phases;
        let shape = self.shapes[k].get_or_init(|| {
            let (design, offset, at) = (Arc::clone(&self.design), self.offset, k as f32 / phases as f32);
            Arc::new(Tubes::lods("belonging", LEVEL_LIMITS_M, offset, move |level| design.tubes(at, level)))
        });
        Arc::clone(shape)
    }
}

impl Design {
    fn tubes(&self, phase: f32, level: usize) -> Tubes {
        let mut tubes = Tubes::default();
        match self {
            Self::Umbrella(umbrella) => umbrella.add(&mut tubes, level),
            Self::Pram(pram) => pram.add(&mut tubes, level),
            Self::Dog(dog) => dog.add(&mut tubes, phase, level),
            Self::Case(case) => case.add(&mut tubes, level),
            Self::Rollator(rollator) => rollator.add(&mut tubes, level),
            Self::Sticks(sticks) => sticks.add(&mut tubes, phase, level),
        }
        tubes
    }
}
