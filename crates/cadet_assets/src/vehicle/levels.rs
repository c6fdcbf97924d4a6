//! The levels of detail of vehicles: each is drawn when it is first used, as of most vehicles some never are. The finest is
//! also drawn at once, for its bounds.

use std::sync::{Arc, OnceLock};

use super::surface::Surface;
use super::wheels::{self, Rim};
use cadet_base::geometry::{Bounds, LazyMesh, LodSet};
use cadet_base::math::Vec3;

/// Where the levels of detail end, meters from the ego: a car is a hundred pixels of KITTI's camera high at the first limit,
/// and looking through its windows shows nothing beyond the third.
const LEVEL_LIMITS_M: [f32; LEVELS] = [11.0, 32.0, 80.0, f32::INFINITY];
pub(super) const LEVELS: usize = 4;
/// The coarsest.
pub(super) const DISTANT: usize = LEVELS - 1;
/// Nobody sees wheels beyond this distance (a wheel is 3 pixels tall there), meters.
const WHEELS_TO_M: f32 = 150.0;
/// Nobody sees who sits inside beyond this distance, meters.
const OCCUPANTS_TO_M: f32 = 70.0;
/// Faces that meet at more than this angle show an edge.
pub(super) const CREASE_RAD: f32 = 0.55;
/// As [`CREASE_RAD`], of people, who are round.
const OCCUPANT_CREASE_RAD: f32 = 1.2;

/// What a vehicle is drawn from, the same at each level of detail.
pub(super) trait Blueprint: Send + Sync + 'static {
    /// What fills the box.
    fn shell(&self, level: usize) -> Surface;

    /// Adds what sticks out of the box or stands inside of the shell, if there is such.
    fn add_more(&self, _surface: &mut Surface, _level: usize) {}

    /// The people inside, if there are any.
    fn occupants(&self, _level: usize) -> Surface {
        Surface::default()
    }
}

/// A vehicle whose shell fills its box at each level of detail.
pub(super) struct Fitted<B> {
    name: &'static str,
    pub blueprint: B,
    size_lwh: Vec3,
    fits: [OnceLock<Fit>; LEVELS],
}

impl<B: Blueprint> Fitted<B> {
    pub fn new(name: &'static str, blueprint: B, size_lwh: Vec3) -> Arc<Self> {
        Arc::new(Self { name, blueprint, size_lwh, fits: Default::default() })
    }

    /// How a level's shell is moved into the box.
    pub fn fit(&self, level: usize) -> Fit {
        *self.fits[level].get_or_init(|| Fit::of(&self.blueprint.shell(level), self.size_lwh))
    }

    /// Everything but wheels and occupants.
    pub fn body(self: &Arc<Self>) -> Arc<LodSet> {
        let of = Arc::clone(self);
        levels_of(self.name, CREASE_RAD, f32::INFINITY, move |level| {
            let mut surface = of.blueprint.shell(level);
            let fit = *of.fits[level].get_or_init(|| Fit::of(&surface, of.size_lwh));
            of.blueprint.add_more(&mut surface, level);
            fit.apply(&mut surface);
            surface
        })
    }

    /// The people inside.
    pub fn occupants(self: &Arc<Self>) -> Arc<LodSet> {
        let of = Arc::clone(self);
        levels_of(self.name, OCCUPANT_CREASE_RAD, OCCUPANTS_TO_M, move |level| {
            let mut surface = of.blueprint.occupants(level);
            of.fit(level).apply(&mut surface);
            surface
        })
    }
}

/// A wheel that turns.
pub(super) fn wheels_of(name: &'static str, radius_m: f32, tyre_width_m: f32, rim: Rim) -> Arc<LodSet> {
    levels_of(name, CREASE_RAD, WHEELS_TO_M, move |level| wheels::wheel(radius_m, tyre_width_m, rim, level))
}

/// The levels of detail of a shape, as many as begin before `to_m`.
fn levels_of(
    name: &'static str,
    crease_rad: f32,
    to_m: f32,
    draw: impl Fn(usize) -> Surface + Send + Sync + 'static,
) -> Arc<LodSet> {
    let (bounds, draw) = (draw(0).builder.bounds(), Arc::new(draw));
    let count = 1 + LEVEL_LIMITS_M.iter().take_while(|limit| **limit < to_m).count();
    let level = |k: usize| {
        // Of few large faces, panes and panels would run into each other.
        let crease_rad = if k == DISTANT { 0.5 * crease_rad } else { crease_rad };
        let draw = Arc::clone(&draw);
        (LEVEL_LIMITS_M[k].min(to_m), LazyMesh::new(move || draw(k).builder.build(name, crease_rad)))
    };
    Arc::new(LodSet { bounds, levels: (0..count).map(level).collect(), coarse_shadow_proxies: 2 })
}

/// Maps a built shell onto its box; the numbers are within a percent of the identity.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    scale: Vec3,
    shift_x: f32,
}

impl Fit {
    fn of(shell: &Surface, size_lwh: Vec3) -> Self {
        let bounds = Bounds::of(shell.builder.positions().iter().copied());
        let size = bounds.size();
        let scale = Vec3::new(size_lwh.x / size.x, size_lwh.y / size.y, size_lwh.z / bounds.max.z);
        Self { scale, shift_x: -bounds.center().x * scale.x }
    }

    pub fn point(self, p: Vec3) -> Vec3 {
        p * self.scale + Vec3::X * self.shift_x
    }

    fn apply(self, surface: &mut Surface) {
        for p in surface.builder.positions_mut() {
            *p = self.point(*p);
        }
    }
}
