//! What each beam meets where nothing moves during a turn.

use super::{BeamHit, Casting, TurnHits, reach_m};
use crate::lidar::sensor::{DivergentBeams, LidarSpec};
use crate::sense::{Hits, PosedInstance, PosedScene, SpinningGrid, Still, SurfaceFilter, cast, cast_layers};
use cadet_base::error::{Error, Result};
use cadet_base::math::{DMat3, DPose3, DVec3};

/// A spinning sensor that stands still in a world that stands still.
pub(crate) struct StillCasting<'a> {
    scene: &'a PosedScene,
    world_from_velo: &'a DPose3,
    rotation: DMat3,
    grid: SpinningGrid,
}

impl<'a> StillCasting<'a> {
    /// Refuses sensors that do not spin: the kernel casts grids alone.
    pub(crate) fn new(scene: &'a PosedScene, world_from_velo: &'a DPose3, spec: &LidarSpec) -> Result<Self> {
        let grid = spec.grid(*world_from_velo).ok_or_else(|| Error::OutOfRange {
            what: "firing pattern",
            value: spec.name().to_owned(),
            expected: "a sensor that spins, or a scan in motion".to_owned(),
        })?;
        Ok(Self { scene, world_from_velo, rotation: DMat3::from_quat(world_from_velo.rotation), grid })
    }

    fn in_range(&self, spec: &LidarSpec) -> impl Fn(&PosedInstance) -> bool {
        let (sensor_world, reach_m) = (self.world_from_velo.translation, reach_m(spec));
        move |i| i.is_within(sensor_world, reach_m)
    }
}

impl Casting for StillCasting<'_> {
    fn scene(&self) -> &PosedScene {
        self.scene
    }

    fn cast(&self, spec: &LidarSpec) -> TurnHits {
        let [opaque, transparent] = cast_layers(self.scene, &self.grid, &Still, self.in_range(spec));
        TurnHits { opaque, transparent }
    }

    fn cast_sub_beams(&self, spec: &LidarSpec, divergent: &DivergentBeams, beams: &[u32]) -> Vec<[BeamHit; 4]> {
        let (rows, columns) = (2 * spec.rings().len(), spec.num_columns());
        let mut out = vec![[BeamHit::MISS; 4]; beams.len()];
        for (side, grid) in divergent.grids(*self.world_from_velo).iter().enumerate() {
            // The kernel keeps what is nearer: a depth below 0 switches a beam off.
            let mut hits = Hits::new(rows, columns);
            hits.depth_m.fill(-1.0);
            for at in beams.iter().flat_map(|beam| DivergentBeams::cells(*beam, columns)) {
                hits.depth_m[at] = f32::INFINITY;
            }
            cast(self.scene, grid, SurfaceFilter::Opaque, self.in_range(spec), &mut hits);
            for (quarters, beam) in out.iter_mut().zip(beams) {
                for (up, at) in DivergentBeams::cells(*beam, columns).into_iter().enumerate() {
                    quarters[2 * side + up] = BeamHit::of(&hits, at);
                }
            }
        }
        out
    }

    #[inline]
    fn direction_world(&self, _column: usize, _instance: u32, direction_velo: DVec3) -> DVec3 {
        self.rotation * direction_velo
    }

    #[inline]
    fn place_world(&self, _column: usize, place_velo: DVec3) -> DVec3 {
        self.rotation * place_velo + self.world_from_velo.translation
    }
}
