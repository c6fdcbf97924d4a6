//! The first step of a scan: what each beam meets.

mod in_motion;
mod still;

pub use in_motion::SceneInMotion;
pub(super) use still::StillCasting;

use crate::lidar::sensor::{DivergentBeams, LidarSpec};
use crate::sense::{Hits, NO_HIT, PosedScene};
use cadet_base::math::DVec3;

/// What a beam or a sub-beam met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BeamHit {
    /// Range from the laser's origin, infinite for a miss.
    pub range_m: f32,
    /// Index into the scene's instances, [`NO_HIT`] for a miss.
    pub instance: u32,
    /// Face of the instance's mesh.
    pub face: u32,
    /// Cosine of the incidence angle, 0..1; NaN for a miss.
    pub cos_incidence: f32,
}

impl BeamHit {
    /// A miss.
    pub(super) const MISS: Self =
        Self { range_m: f32::INFINITY, instance: NO_HIT, face: NO_HIT, cos_incidence: f32::NAN };

    #[inline]
    pub(super) fn of(hits: &Hits, at: usize) -> Self {
        let (range_m, cos_incidence) = (hits.depth_m[at], hits.cos_incidence[at]);
        Self { range_m, instance: hits.instance[at], face: hits.face[at], cos_incidence }
    }

    /// Nearer, or of two equally near ones the earlier instance and face.
    #[inline]
    fn is_before(&self, other: &Self) -> bool {
        (self.range_m, self.instance, self.face) < (other.range_m, other.instance, other.face)
    }

    /// True where something was met.
    #[inline]
    pub(super) fn is_hit(&self) -> bool {
        self.instance != NO_HIT
    }
}

/// What the beams of a turn meet, row-major.
pub(super) struct TurnHits {
    /// The first opaque surface.
    pub opaque: Hits,
    /// The first transparent surface; some that stand behind the opaque one are left out.
    pub transparent: Hits,
}

/// Finds what beams meet: the kernel for a sensor that spins at rest, parry for one that moves meanwhile or does not spin.
pub(super) trait Casting {
    /// The scene, as it stands at the scan's instant.
    fn scene(&self) -> &PosedScene;

    /// Casts the middle of every beam.
    fn cast(&self, spec: &LidarSpec) -> TurnHits;

    /// Casts the sub-beams of some beams at opaque surfaces.
    fn cast_sub_beams(&self, spec: &LidarSpec, divergent: &DivergentBeams, beams: &[u32]) -> Vec<[BeamHit; 4]>;

    /// A direction of a column's firing as it stands to an instance's triangles where [`Casting::scene`] has them.
    fn direction_world(&self, column: usize, instance: u32, direction_velo: DVec3) -> DVec3;

    /// Where a place in the sensor's frame at a column's firing lies in the world.
    fn place_world(&self, column: usize, place_velo: DVec3) -> DVec3;
}

/// How far from the frame's origin anything may be seen: what lies beyond the longest range is never reported.
pub(super) fn reach_m(spec: &LidarSpec) -> f64 {
    spec.max_range_m + spec.rings().iter().map(|r| r.height_m.abs() + r.left_m.abs()).fold(0.0, f64::max) + 1.0
}

impl TurnHits {
    /// No hit yet.
    pub(super) fn none(rings: usize, columns: usize) -> Self {
        let [opaque, transparent] = [(); 2].map(|()| Hits::new(rings, columns));
        Self { opaque, transparent }
    }

    /// The transparent surface before a beam's opaque one.
    #[inline]
    pub(super) fn transparent(&self, at: usize) -> Option<BeamHit> {
        let hit = BeamHit::of(&self.transparent, at);
        (hit.is_hit() && hit.is_before(&self.opaque(at))).then_some(hit)
    }

    /// A beam's opaque surface.
    #[inline]
    pub(super) fn opaque(&self, at: usize) -> BeamHit {
        BeamHit::of(&self.opaque, at)
    }
}
