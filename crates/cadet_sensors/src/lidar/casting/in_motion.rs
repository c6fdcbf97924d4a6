//! Scans of a sensor that moves through a moving world, and of one that does not spin.
//!
//! [`Spin`](crate::lidar::Spin) or the path of the sensor says when it points where. Points stay in the frame of their own
//! firing, as in KITTI's object frames.
//!
//! All lasers of a column fire at once, at its own moment. Bodies move with steady velocity and angular velocity; wheels
//! don't roll and people's legs don't swing meanwhile.

use std::sync::Arc;

use super::{BeamHit, Casting, TurnHits, reach_m};
use crate::lidar::scan_pattern::HalfScan;
use crate::lidar::sensor::{BeamLine, DivergentBeams, LidarSpec};
use crate::sense::{
    FaceHit, FaceTrees, MetWhileTurning, Moment, MovingCaster, PosedInstance, PosedScene, RigidMotion, SurfaceHits,
    cast_layers,
};
use cadet_base::math::{DPose3, DVec3};

/// A moving world around a moving sensor.
pub struct SceneInMotion {
    caster: MovingCaster,
    world_from_velo: DPose3,
    sensor: RigidMotion,
    /// Distance from the sensor beyond which nothing is met.
    reach_m: f64,
}

impl SceneInMotion {
    /// Makes ready for scans of sensors like `spec`. `world_from_velo` is the sensor's pose at the instant at which
    /// `scene` was posed, `sensor` its motion, `motion_of` says how an actor moves, by its id.
    pub fn new(
        scene: Arc<PosedScene>,
        trees: &mut FaceTrees,
        spec: &LidarSpec,
        world_from_velo: DPose3,
        sensor: RigidMotion,
        motion_of: impl Fn(i32) -> RigidMotion,
    ) -> Self {
        let span_s = spec.span_s().map(f64::abs).into_iter().fold(0.0, f64::max);
        let sensor_m = sensor.reach_m((world_from_velo.translation - sensor.pivot_world).length(), span_s);
        // Whoever is faster than 100 m/s may be missed at the edge of the range.
        let reach_m = reach_m(spec) + sensor_m + 100.0 * span_s;
        let keep = |i: &PosedInstance| i.is_within(world_from_velo.translation, reach_m);
        let caster = MovingCaster::new(scene, trees, motion_of, span_s, keep);
        Self { caster, world_from_velo, sensor, reach_m }
    }

    /// The sensor at every column's firing.
    pub(crate) fn firings(&self, spec: &LidarSpec) -> Firings<'_> {
        let at = |column: usize| {
            let time_s = spec.firing_time_s(column);
            ColumnFiring { time_s, world_from_velo: self.sensor.displacement(time_s) * self.world_from_velo }
        };
        Firings { scene: self, columns: (0..spec.num_columns()).map(at).collect() }
    }
}

/// One scan, column by column.
pub(crate) struct Firings<'a> {
    scene: &'a SceneInMotion,
    columns: Vec<ColumnFiring>,
}

/// When a column fires, and the sensor's pose at that moment.
struct ColumnFiring {
    time_s: f64,
    world_from_velo: DPose3,
}

impl Casting for Firings<'_> {
    fn scene(&self) -> &PosedScene {
        self.scene.caster.scene()
    }

    fn cast(&self, spec: &LidarSpec) -> TurnHits {
        let (rows, columns) = (spec.rings().len(), spec.num_columns());
        let nearly = spec.half_scans().map(|halves| self.cast_nearly(rows, columns, &halves));
        let mut exact = TurnHits::none(rows, columns);
        let beams: Vec<_> = (0..rows).map(|ring| spec.beams(ring)).collect();
        for (column, ColumnFiring { time_s, world_from_velo }) in self.columns.iter().enumerate() {
            let moment = self.scene.caster.at(*time_s);
            for (ring, beam) in beams.iter().enumerate() {
                let BeamLine { origin_velo, direction_velo } = beam(column);
                let ray_world =
                    [world_from_velo.transform_point(origin_velo), world_from_velo.rotation * direction_velo];
                let at = ring * columns + column;
                let expected = nearly.as_ref().and_then(|nearly| met_as_expected(nearly, at, &moment, ray_world));
                let found = expected.unwrap_or_else(|| moment.cast(ray_world[0], ray_world[1]));
                let TurnHits { opaque, transparent } = &mut exact;
                for (hits, found) in [(opaque, found.opaque), (transparent, found.transparent)] {
                    if let Some(found) = found {
                        hits.put(at, &found);
                    }
                }
            }
        }
        exact
    }

    fn cast_sub_beams(&self, spec: &LidarSpec, divergent: &DivergentBeams, beams: &[u32]) -> Vec<[BeamHit; 4]> {
        let columns = spec.num_columns();
        let mut order: Vec<usize> = (0..beams.len()).collect();
        order.sort_by_key(|k| beams[*k] as usize % columns);
        let mut out = vec![[BeamHit::MISS; 4]; beams.len()];
        for of_column in order.chunk_by(|a, b| beams[*a] as usize % columns == beams[*b] as usize % columns) {
            let column = beams[of_column[0]] as usize % columns;
            let ColumnFiring { time_s, world_from_velo } = &self.columns[column];
            let moment = self.scene.caster.at(*time_s);
            for k in of_column {
                let origin_velo = spec.beams(beams[*k] as usize / columns)(column).origin_velo;
                let origin = world_from_velo.transform_point(origin_velo);
                out[*k] = divergent.directions_velo(beams[*k]).map(|direction_velo| {
                    let found = moment.cast(origin, world_from_velo.rotation * direction_velo).opaque;
                    found.map_or(BeamHit::MISS, |hit| {
                        let FaceHit { range_m, instance, face, cos_incidence } = hit;
                        BeamHit { range_m: range_m as f32, instance, face, cos_incidence }
                    })
                });
            }
        }
        out
    }

    #[inline]
    fn direction_world(&self, column: usize, instance: u32, direction_velo: DVec3) -> DVec3 {
        let ColumnFiring { time_s, world_from_velo } = &self.columns[column];
        self.scene.caster.direction_at_instant(instance, world_from_velo.rotation * direction_velo, *time_s)
    }

    #[inline]
    fn place_world(&self, column: usize, place_velo: DVec3) -> DVec3 {
        self.columns[column].world_from_velo.transform_point(place_velo)
    }
}

impl Firings<'_> {
    /// What beams meet, found by the kernel among points that have moved to where beams meet them: right but for those that
    /// pass an edge by less than what is left out, as points of a triangle between its corners move a little otherwise.
    fn cast_nearly(&self, rows: usize, columns: usize, halves: &[HalfScan]) -> TurnHits {
        let SceneInMotion { caster, world_from_velo, sensor, reach_m } = self.scene;
        let mut all = TurnHits::none(rows, columns);
        for HalfScan { half, grid, columns } in halves {
            let as_met =
                MetWhileTurning::new(*half, caster.scene(), (world_from_velo, sensor), |index| caster.motion_of(index));
            let grid = grid.at(*world_from_velo);
            let keep = |i: &PosedInstance| i.is_within(world_from_velo.translation, *reach_m);
            let [opaque, transparent] = cast_layers(caster.scene(), &grid, &as_met, keep);
            all.opaque.put_columns(&opaque, columns);
            all.transparent.put_columns(&transparent, columns);
        }
        all
    }
}

/// Where a ray meets the very triangles that it is expected to meet; None where it misses one.
fn met_as_expected(nearly: &TurnHits, at: usize, moment: &Moment<'_>, ray_world: [DVec3; 2]) -> Option<SurfaceHits> {
    let exact = |hit: BeamHit| moment.cast_at(ray_world, hit.instance, hit.face);
    let opaque = nearly.opaque(at);
    let opaque = if opaque.is_hit() { Some(exact(opaque)?) } else { None };
    let transparent = match nearly.transparent(at) {
        Some(hit) => Some(exact(hit)?),
        None => None,
    };
    let is_behind = opaque.zip(transparent).is_some_and(|(o, t)| o.range_m <= t.range_m);
    (!is_behind).then_some(SurfaceHits { opaque, transparent })
}
