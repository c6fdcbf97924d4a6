//! Scans of a sensor that moves through a moving world, and of one that does not spin.
//!
//! [`Spin`](super::Spin) or the path of the sensor says when it points where. Points stay in the frame of their own firing,
//! as in KITTI's object frames.
//!
//! All lasers of a column fire at once, at its own moment. Bodies move with steady velocity and angular velocity; wheels
//! don't roll and people's legs don't swing meanwhile.

use std::sync::Arc;

use super::beams::BeamLine;
use super::casting::{BeamHit, Casting, TurnHits, reach_m};
use super::divergence::DivergentBeams;
use super::spec::LidarSpec;
use crate::sense::{FaceTrees, Hits, MovingCaster, PosedScene, RigidMotion};
use cadet_base::math::{DPose3, DVec3};

/// A moving world around a moving sensor.
pub struct SceneInMotion {
    caster: MovingCaster,
    world_from_velo: DPose3,
    sensor: RigidMotion,
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
        let keep = |i: &crate::sense::PosedInstance| {
            (i.center_world - world_from_velo.translation).length() - i.radius_m < reach_m
        };
        let caster = MovingCaster::new(scene, trees, motion_of, span_s, keep);
        Self { caster, world_from_velo, sensor }
    }

    /// The sensor at every column's firing.
    pub(super) fn firings(&self, spec: &LidarSpec) -> Firings<'_> {
        let at = |column: usize| {
            let time_s = spec.firing_time_s(column);
            ColumnFiring { time_s, world_from_velo: self.sensor.displacement(time_s) * self.world_from_velo }
        };
        Firings { caster: &self.caster, columns: (0..spec.num_columns()).map(at).collect() }
    }
}

/// One scan, column by column.
pub(super) struct Firings<'a> {
    caster: &'a MovingCaster,
    columns: Vec<ColumnFiring>,
}

/// When a column fires, and the sensor's pose at that moment.
struct ColumnFiring {
    time_s: f64,
    world_from_velo: DPose3,
}

impl Casting for Firings<'_> {
    fn scene(&self) -> &PosedScene {
        self.caster.scene()
    }

    fn cast(&self, spec: &LidarSpec) -> TurnHits {
        let (rows, columns) = (spec.rings().len(), spec.num_columns());
        let (mut opaque, mut first) = (Hits::new(rows, columns), Hits::new(rows, columns));
        let beams: Vec<_> = (0..rows).map(|ring| spec.beams(ring)).collect();
        for (column, ColumnFiring { time_s, world_from_velo }) in self.columns.iter().enumerate() {
            let moment = self.caster.at(*time_s);
            for (ring, beam) in beams.iter().enumerate() {
                let BeamLine { origin_velo, direction_velo } = beam(column);
                let origin = world_from_velo.transform_point(origin_velo);
                let found = moment.cast(origin, world_from_velo.rotation * direction_velo);
                let at = ring * columns + column;
                for (hits, found) in [(&mut opaque, found.opaque), (&mut first, found.transparent.or(found.opaque))] {
                    if let Some(found) = found {
                        hits.put(at, &found);
                    }
                }
            }
        }
        TurnHits { opaque, first }
    }

    fn cast_sub_beams(&self, spec: &LidarSpec, divergent: &DivergentBeams, beams: &[u32]) -> Vec<[BeamHit; 4]> {
        let columns = spec.num_columns();
        let mut order: Vec<usize> = (0..beams.len()).collect();
        order.sort_by_key(|k| beams[*k] as usize % columns);
        let mut out = vec![[BeamHit::MISS; 4]; beams.len()];
        for of_column in order.chunk_by(|a, b| beams[*a] as usize % columns == beams[*b] as usize % columns) {
            let column = beams[of_column[0]] as usize % columns;
            let ColumnFiring { time_s, world_from_velo } = &self.columns[column];
            let moment = self.caster.at(*time_s);
            for k in of_column {
                let origin_velo = spec.beams(beams[*k] as usize / columns)(column).origin_velo;
                let origin = world_from_velo.transform_point(origin_velo);
                out[*k] = divergent.directions_velo(beams[*k]).map(|direction_velo| {
                    let found = moment.cast(origin, world_from_velo.rotation * direction_velo).opaque;
                    found.map_or(BeamHit::MISS, |f| BeamHit {
                        range_m: f.range_m as f32,
                        instance: f.instance,
                        face: f.face,
                    })
                });
            }
        }
        out
    }

    #[inline]
    fn direction_world(&self, column: usize, instance: u32, direction_velo: DVec3) -> DVec3 {
        let ColumnFiring { time_s, world_from_velo } = &self.columns[column];
        self.caster.direction_at_instant(instance, world_from_velo.rotation * direction_velo, *time_s)
    }

    #[inline]
    fn place_world(&self, column: usize, place_velo: DVec3) -> DVec3 {
        self.columns[column].world_from_velo.transform_point(place_velo)
    }
}
