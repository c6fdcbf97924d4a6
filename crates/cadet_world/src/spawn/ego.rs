//! The ego: its measures and where it starts.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::driven::chassis_on;
use crate::agents::Car;
use crate::arena::Arena;
use crate::body::{Chassis, settle};
use crate::driving::IdmParameters;
use crate::params::EGO;
use crate::streets::{EGO_STRAIGHT_WEIGHT, LaneGraph, LanePosition, Route};
use cadet_assets::vehicle::{Livery, VehicleModel};
use cadet_base::actor::{AnnotatedBox, ObjectClass};
use cadet_base::error::{Error, Result};
use cadet_base::geometry::{Bounds, LodSet, MeshBuilder};
use cadet_base::material::{Material, Palette, Pattern, Semantic};
use cadet_base::math::{DVec2, DVec3, Vec3};
use cadet_base::rng::{Stream, StreamKey};
use cadet_town::{LaneId, LaneKind, Town};

/// The ego's own measures: an estate car of 2006, like the one that recorded KITTI. Nobody sees it, so it has no shape
/// but a box.
fn ego_model() -> VehicleModel {
    let (size_lwh, wheel_radius_m) = (DVec3::new(4.77, 1.82, 1.52), 0.316);
    let (front, rear, side) = (1.44, -1.27, 0.78);
    let mut block = MeshBuilder::new();
    let half = (size_lwh / 2.0).as_vec3();
    block.cuboid(Vec3::new(-half.x, -half.y, 0.2), Vec3::new(half.x, half.y, size_lwh.z as f32), 0);
    let shape = Arc::new(LodSet::single(block.build("ego", 0.5)));
    let paint = Material::matt(Semantic::Car, [0.3; 3], Pattern::Plain, 0.3);
    VehicleModel {
        name: "ego".to_owned(),
        class: ObjectClass::Car,
        size_lwh,
        annotated: AnnotatedBox::exact(size_lwh),
        body: Arc::clone(&shape),
        driver: None,
        wheel: Some(shape),
        wheel_centers: [(front, side), (front, -side), (rear, side), (rear, -side)]
            .map(|(x, y)| Vec3::new(x, y, wheel_radius_m as f32)),
        wheel_radius_m,
        palette: Arc::new(Palette::new(vec![paint])),
        has_lenses: false,
        openings: None,
        livery: Livery::Private,
    }
}

/// How much likelier the ego starts on a street with tracks than on another: KITTI was recorded along the tram lines of
/// Karlsruhe more often than across them.
const BESIDE_TRACKS: f64 = 20.0;

/// The ego starts on a lane that is longer than this, if there is one, and where it can drive so far at least.
const LONG_LANE_M: f64 = 16.0;
const LEAST_WAY_M: f64 = 8.0;

/// The lanes that the ego may start on: those from which it can drive far.
pub(crate) struct EgoStarts {
    lanes: Vec<LaneId>,
    weights: Vec<f64>,
}

impl EgoStarts {
    pub fn of(graph: &LaneGraph) -> Self {
        let longer_than = |least_m: f64| -> Vec<LaneId> {
            graph.open_lanes().filter(|l| l.length_m() > least_m).map(|l| l.id).collect()
        };
        let mut lanes = longer_than(LONG_LANE_M);
        if lanes.is_empty() {
            lanes = longer_than(0.0);
        }
        let farthest = lanes.iter().map(|l| graph.reach_m(*l)).fold(0.0, f64::max);
        lanes.retain(|l| graph.reach_m(*l) >= farthest.clamp(LEAST_WAY_M, 350.0));
        let with_tracks: BTreeSet<_> =
            graph.lanes().iter().filter(|l| l.kind == LaneKind::Tram).map(|l| l.road).collect();
        let weight = |id: &LaneId| {
            let lane = graph.lane(*id);
            lane.length_m() * if with_tracks.contains(&lane.road) { BESIDE_TRACKS } else { 1.0 }
        };
        let weights = lanes.iter().map(weight).collect();
        Self { lanes, weights }
    }

    /// A lane, and how far along it; `None` where there is none.
    pub fn draw(&self, stream: &mut Stream, graph: &LaneGraph) -> Option<(LaneId, f64)> {
        if self.lanes.is_empty() {
            return None;
        }
        let id = self.lanes[stream.weighted(&self.weights)];
        let length_m = graph.lane(id).length_m();
        let s_m = stream.range(4.0, (length_m - 8.0).max(5.0));
        Some((id, s_m.min((length_m - 4.0).max(length_m / 2.0))))
    }
}

/// The ego on a lane from which it can drive far, or in the middle of the ground where there is no lane.
///
/// # Errors
/// [`Error::Scene`] for a ground on which it finds no place.
pub(crate) fn place_ego(arena: &mut Arena, town: &Town, key: StreamKey) -> Result<Car> {
    let model = Arc::new(ego_model());
    let mut stream = key.stream("ego place");
    let Arena { physics, streets, .. } = arena;
    let graph = &streets.graph;
    let starts = EgoStarts::of(graph);
    let idm = IdmParameters::draw(&EGO, &mut key.stream("ego habits"));
    for _ in 0..50 {
        let Some((lane, s_m)) = starts.draw(&mut stream, graph) else { break };
        let at = LanePosition { lane, s_m, left_m: stream.clipped_normal(0.0, 0.08) };
        let route = Route::new(at, EGO_STRAIGHT_WEIGHT, key.stream("ego route"), graph);
        if let Some(chassis) = chassis_on(&route, &model, 0.0, physics, graph) {
            return Ok(Car::new(chassis, Some(route), idm));
        }
    }
    let middle = Bounds::of(town.ground.vertices.iter().copied()).center().as_dvec3();
    let settled = settle(physics, &model, physics.uppermost(DVec2::ZERO), 0.0)
        .or_else(|_| settle(physics, &model, physics.uppermost(middle.truncate()), 0.0))
        .map_err(|_| Error::Scene {
            reason: "the ego finds no place: no drivable lane, no ground in the middle".into(),
        })?;
    let chassis = Chassis::new(physics, model, &settled.world_from_box, 0.0);
    Ok(Car::new(chassis, None, idm))
}

/// The error of a town without a lane to drive along.
pub(crate) fn too_short(town: &Town, graph: &LaneGraph) -> Error {
    let longest_m = town.network.driving().map(|l| graph.reach_m(l.id)).fold(0.0, f64::max);
    let reason = format!(
        "too short to drive: no way along its driving lanes is longer than {longest_m:.1} m, expected {LEAST_WAY_M} m or more"
    );
    Error::Map { map: town.name.clone(), reason }
}
