//! What people have with them beside what they wear: umbrellas, prams, dogs, wheeled cases, rollators.

mod dog;
mod paint;
mod pram;
mod rolling;
mod shapes;
#[cfg(test)]
mod tests;
mod thing;
mod umbrella;

use std::sync::{Arc, OnceLock};

use super::person::proportions::Proportions;
use super::person::tube::Tubes;
use crate::geometry::{Bounds, LazyMesh, LodSet};
use crate::material::Palette;
use crate::math::Vec3;
use crate::rng::Stream;

pub(crate) use thing::Thing;

use dog::Dog;
use pram::Pram;
use rolling::{Case, Rollator};
use umbrella::Umbrella;

/// Phases of the owner's gait at which what moves has a shape.
const NUM_PHASES: usize = 24;
/// Where the levels of detail end, meters from the ego, as of people; leads and dogs are not seen beyond the last.
const LEVEL_LIMITS_M: [f32; 3] = [9.0, 22.0, 120.0];

#[derive(Debug)]
enum Design {
    Umbrella(Umbrella),
    Pram(Pram),
    Dog(Dog),
    Case(Case),
    Rollator(Rollator),
}

/// A thing of somebody's, in the person's box frame.
#[derive(Debug, Clone)]
pub(crate) struct Belonging {
    pub palette: Arc<Palette>,
    /// Where the hands that hold it are, from the pelvis' vertical and the ground: left, right.
    pub hands: [Option<Vec3>; 2],
    design: Arc<Design>,
    offset: Vec3,
    shapes: Arc<[OnceLock<Arc<LodSet>>; NUM_PHASES]>,
}

impl Belonging {
    /// The thing of a seed, in the hand of a side if it takes one, for a person whose box frame is `offset` from the pelvis' vertical.
    pub(super) fn draw(thing: Thing, p: &Proportions, offset: Vec3, side: f32, seed: u64) -> Self {
        let mut s = Stream::from_seed("belonging", seed);
        let palette = Arc::new(paint::palette(thing, &mut s));
        let one = |hand: Vec3| if side > 0.0 { [Some(hand), None] } else { [None, Some(hand)] };
        let (stature, cycle_m) = (p.stature, if p.speed > 0.0 { p.cycle_length } else { 0.0 });
        let (design, hands) = match thing {
            Thing::Umbrella => {
                let umbrella = Umbrella::draw(stature, side, &mut s);
                let hand = umbrella.hand();
                (Design::Umbrella(umbrella), one(hand))
            }
            Thing::Pram => {
                let pram = Pram::draw(stature, &mut s);
                let hands = pram.hands().map(Some);
                (Design::Pram(pram), hands)
            }
            Thing::Dog => {
                let dog = Dog::draw(stature, side, cycle_m, &mut s);
                let hand = dog.hand();
                (Design::Dog(dog), one(hand))
            }
            Thing::Case => {
                let case = Case::draw(stature, side, &mut s);
                let hand = case.hand();
                (Design::Case(case), one(hand))
            }
            Thing::Rollator => {
                let rollator = Rollator::draw(stature, &mut s);
                let hands = rollator.hands().map(Some);
                (Design::Rollator(rollator), hands)
            }
        };
        let shapes = Arc::new([const { OnceLock::new() }; NUM_PHASES]);
        Self { palette, hands, design: Arc::new(design), offset, shapes }
    }

    /// Whether it stands on the ground and hides the sky from it.
    pub fn is_solid(&self) -> bool {
        matches!(*self.design, Design::Pram(_) | Design::Case(_) | Design::Rollator(_))
    }

    /// The shape at a phase of the owner's gait in [0, 1), made when it is first used.
    pub fn pose(&self, phase: f64) -> Arc<LodSet> {
        let moves = matches!(*self.design, Design::Dog(_));
        let k = if moves { ((phase - phase.floor()) * NUM_PHASES as f64) as usize % NUM_PHASES } else { 0 };
        let shape = self.shapes[k].get_or_init(|| {
            let (design, offset, at) = (Arc::clone(&self.design), self.offset, k as f32 / NUM_PHASES as f32);
            let bounds = Bounds::of(design.tubes(at, 0).vertices.iter().map(|v| *v + offset));
            let level = |i: usize| {
                let design = Arc::clone(&design);
                (LEVEL_LIMITS_M[i], LazyMesh::new(move || design.tubes(at, i).into_mesh("belonging", offset)))
            };
            Arc::new(LodSet { bounds, levels: (0..3).map(level).collect(), coarse_shadow_proxies: 2 })
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
        }
        tubes
    }
}
