//! A sensor that turns while it and the world move.
//!
//! [`Spin`](super::Spin) says when it looks where. Points stay in the frame of their own firing, as in KITTI's object
//! frames.
//!
//! All lasers of a column fire at once, at its own moment. Bodies move with steady velocity and angular velocity; wheels
//! don't roll and people's legs don't swing meanwhile.

use std::sync::Arc;

use super::casting::{BeamHit, Casting, TurnHits, reach_m};
use super::divergence::DivergentBeams;
use super::spec::LidarSpec;
use crate::sense::{FaceHit, FaceTrees, Hits, Moment, MovingCaster, PosedScene, RigidMotion};
use cadet_base::math::{DPose3, DVec3};

/// A moving world around a moving sensor.
pub struct Turning {
    caster: MovingCaster,
    world_from_velo: DPose3,
    sensor: RigidMotion,
}

impl Turning {
    /// Makes ready for turns of sensors like `spec`. `world_from_velo` is the sensor's pose at the instant at which
    /// `scene` was posed, `sensor` its motion, `motion_of` says how an actor moves, by its id.
    pub fn new(
        scene: Arc<PosedScene>,
        trees: &mut FaceTrees,
        spec: &LidarSpec,
        world_from_velo: DPose3,
        sensor: RigidMotion,
        motion_of: impl Fn(i32) -> RigidMotion,
    ) -> Self {
        let span_s = spec.spin.span_s().map(f64::abs).into_iter().fold(0.0, f64::max);
        let sensor_m = sensor.reach_m((world_from_velo.translation - sensor.pivot_world).length(), span_s);
        // Whoever is faster than 100 m/s may be missed at the edge of the range.
        let reach_m = reach_m(spec) + sensor_m + 100.0 * span_s;
        let keep = |i: &crate::sense::PosedInstance| {
            (i.center_world - world_from_velo.translation).length() - i.radius_m < reach_m
        };
        let caster = MovingCaster::new(scene, trees, motion_of, span_s, keep);
        Self { caster, world_from_velo, sensor }
    }

    /// The world and the sensor at every column's firing.
    pub(super) fn firings(&self, spec: &LidarSpec) -> Firings<'_> {
        let at = |azimuth: &f64| {
            let time_s = spec.spin.firing_time_s(*azimuth);
            let world_from_velo = self.sensor.displacement(time_s) * self.world_from_velo;
            ColumnFiring { moment: self.caster.at(time_s), world_from_velo }
        };
        Firings { scene: self.caster.scene(), columns: spec.azimuths_rad().iter().map(at).collect() }
    }
}

/// One turn, column by column.
pub(super) struct Firings<'a> {
    scene: &'a PosedScene,
    columns: Vec<ColumnFiring<'a>>,
}

/// The world and the sensor's pose at the moment at which a column fires.
struct ColumnFiring<'a> {
    moment: Moment<'a>,
    world_from_velo: DPose3,
}

impl Casting for Firings<'_> {
    fn scene(&self) -> &PosedScene {
        self.scene
    }

    fn cast(&self, spec: &LidarSpec) -> TurnHits {
        let (rows, columns) = (spec.rings().len(), spec.azimuths_rad().len());
        let (mut opaque, mut first) = (Hits::new(rows, columns), Hits::new(rows, columns));
        for (ring, laser) in spec.rings().iter().enumerate() {
            let direction_velo = laser.directions_velo();
            for (column, (heading, firing)) in spec.headings(ring).iter().zip(&self.columns).enumerate() {
                let ColumnFiring { moment, world_from_velo } = firing;
                let origin = world_from_velo.transform_point(laser.origin_velo(*heading));
                let direction = world_from_velo.rotation * direction_velo(*heading);
                let found = moment.cast(origin, direction);
                let at = ring * columns + column;
                put(&mut opaque, at, found.opaque);
                put(&mut first, at, found.transparent.or(found.opaque));
            }
        }
        TurnHits { opaque, first }
    }

    fn cast_sub_beams(&self, spec: &LidarSpec, divergent: &DivergentBeams, beams: &[u32]) -> Vec<[BeamHit; 4]> {
        let columns = spec.azimuths_rad().len();
        let cast = |beam: &u32| {
            let (ring, column) = (*beam as usize / columns, *beam as usize % columns);
            let ColumnFiring { moment, world_from_velo } = &self.columns[column];
            let origin_velo = spec.rings()[ring].origin_velo(spec.headings(ring)[column]);
            let origin = world_from_velo.transform_point(origin_velo);
            divergent.directions_velo(*beam).map(|direction_velo| {
                let found = moment.cast(origin, world_from_velo.rotation * direction_velo).opaque;
                found.map_or(BeamHit::MISS, |f| BeamHit {
                    range_m: f.range_m as f32,
                    instance: f.instance,
                    face: f.face,
                })
            })
        };
        beams.iter().map(cast).collect()
    }

    #[inline]
    fn direction_world(&self, column: usize, instance: u32, direction_velo: DVec3) -> DVec3 {
        let ColumnFiring { moment, world_from_velo } = &self.columns[column];
        moment.direction_now(instance, world_from_velo.rotation * direction_velo)
    }

    #[inline]
    fn place_world(&self, column: usize, place_velo: DVec3) -> DVec3 {
        self.columns[column].world_from_velo.transform_point(place_velo)
    }
}

fn put(hits: &mut Hits, at: usize, found: Option<FaceHit>) {
    if let Some(found) = found {
        hits.depth_m[at] = found.range_m as f32;
        hits.instance[at] = found.instance;
        hits.face[at] = found.face;
    }
}
