//! An actor's outline alone, as the camera would see it with nothing else in the world.

use std::ops::Range;

use crate::camera::{CameraModel, Visibility};
use crate::sense::{PinholeGrid, PosedInstance, PosedScene, VisibilityBuffer, rasterize_instances};
use cadet_base::actor::ActorState;
use cadet_base::math::{DPose3, DVec3};

use super::box_cam::Rect;

/// Samples a pixel, where the camera has them ([`PinholeGrid::quincunx`]).
pub(super) const SAMPLES_PER_PIXEL: usize = 2;

/// How much of an actor there is in the image, seen or hidden.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Silhouette {
    /// Samples of the outline inside the image.
    pub samples: usize,
    /// Rectangle round the outline inside the image.
    pub bounds: Option<Rect>,
}

impl Silhouette {
    /// What two pinholes see, of which each has images of its own.
    pub fn together(self, other: Self) -> Self {
        Self { samples: self.samples + other.samples, bounds: None }
    }
}

/// What one of a camera's pinholes sees ([`CameraModel::pinholes`]).
pub struct PinholeLook<'a> {
    /// The pinhole camera.
    pub camera: &'a CameraModel,
    /// The pose of its frame in the world.
    pub world_from_cam: &'a DPose3,
    /// What it sees.
    pub seen: &'a Visibility,
}

/// The instances of every actor, by the actor's id.
pub(super) struct ActorInstances(Vec<(i32, usize)>);

impl ActorInstances {
    pub fn new(scene: &PosedScene) -> Self {
        let actors = scene.instances.iter().enumerate().filter(|(_, i)| i.actor_id > 0);
        let mut pairs: Vec<_> = actors.map(|(index, i)| (i.actor_id, index)).collect();
        pairs.sort_unstable();
        Self(pairs)
    }

    /// Indices into [`PosedScene::instances`], rising.
    fn of(&self, actor_id: i32) -> impl Iterator<Item = usize> {
        let start = self.0.partition_point(|(id, _)| *id < actor_id);
        self.0[start..].iter().take_while(move |(id, _)| *id == actor_id).map(|(_, index)| *index)
    }
}

/// The part of a camera's samples that an actor's bounds cover, and what of the actor is seen there.
pub(super) struct ActorWindow<'a> {
    look: &'a PinholeLook<'a>,
    actor_id: i32,
    rows: Range<usize>,
    columns: Range<usize>,
    /// Samples that see the actor.
    pub visible_samples: usize,
}

impl<'a> ActorWindow<'a> {
    /// Finds the window; `None` where the actor's bounds are out of the image.
    pub fn of(
        scene: &PosedScene,
        instances: &ActorInstances,
        actor_id: i32,
        look: &'a PinholeLook<'a>,
    ) -> Option<Self> {
        let PinholeLook { camera, world_from_cam, seen } = look;
        let of_actor = instances.of(actor_id).map(|i| &scene.instances[i]);
        let [u1, v1, u2, v2] = pixel_bounds(of_actor, camera, world_from_cam)?;
        // Sample (r, c) lies at v = r / 2 and u = c, in odd rows u = c + 1/2. Windows begin at even rows.
        let lo = |p: f64| p.floor().max(0.0) as usize;
        let hi = |p: f64, end: usize| (p.ceil() + 1.0).clamp(0.0, end as f64) as usize;
        let (rows, columns) = (2 * lo(v1)..2 * hi(v2, camera.height), lo(u1)..hi(u2, camera.width));
        if rows.is_empty() || columns.is_empty() {
            return None;
        }
        let visible_samples = seen.samples_of_actor(actor_id, rows.clone(), columns.clone());
        Some(Self { look, actor_id, rows, columns, visible_samples })
    }

    /// Draws the actor alone.
    pub fn silhouette(
        &self,
        scene: &PosedScene,
        instances: &ActorInstances,
        buffer: &mut VisibilityBuffer,
    ) -> Silhouette {
        let PinholeLook { camera, world_from_cam, .. } = self.look;
        let mut found = Silhouette::default();
        let (rows, columns) = (self.rows.len(), self.columns.len());
        let (r1, c1) = (self.rows.start, self.columns.start);
        let (pose, first) = (camera.optical_pose(world_from_cam), [c1 as f64, r1 as f64 / 2.0]);
        let grid = PinholeGrid::quincunx(pose, camera.intrinsics_px(), first, rows, columns)
            .expect("a checked camera and a window that is not empty");
        rasterize_instances(scene, &grid, instances.of(self.actor_id), buffer);
        // Rows and columns by halves of a pixel.
        let (mut of_rows, mut of_columns) = (rows..0, 2 * columns..0);
        for r in 0..rows {
            let (count, span) = buffer.covered(r);
            if count > 0 {
                found.samples += count;
                of_rows = of_rows.start.min(r)..r + 1;
                let halves = 2 * span.start + r % 2..2 * span.end - 1 + r % 2;
                of_columns = of_columns.start.min(halves.start)..of_columns.end.max(halves.end);
            }
        }
        if found.samples > 0 {
            let (u, v) = (|h: usize| (2 * c1 + h) as f64 / 2.0, |r: usize| (r1 + r) as f64 / 2.0);
            let (u1, u2) = (u(of_columns.start), u(of_columns.end - 1));
            found.bounds =
                Some(Rect { left_px: u1, top_px: v(of_rows.start), right_px: u2, bottom_px: v(of_rows.end - 1) });
        }
        found
    }
}

/// Pixels of each actor's outline inside a camera's image, and those of them where nothing is in front: what is counted
/// over several cameras tells how much of an actor any of them sees.
#[must_use]
pub fn pixels_of_actors(
    actors: &[ActorState],
    scene: &PosedScene,
    camera: &CameraModel,
    world_from_cam: &DPose3,
    seen: &Visibility,
) -> Vec<[f64; 2]> {
    let (pinhole, instances) = (camera.pinhole(), ActorInstances::new(scene));
    let look = PinholeLook { camera: &pinhole, world_from_cam, seen };
    let mut buffer = VisibilityBuffer::default();
    let pixels = |samples: usize| samples as f64 / SAMPLES_PER_PIXEL as f64;
    let of = |actor: &ActorState| {
        let window = ActorWindow::of(scene, &instances, actor.id, &look);
        window.map_or([0.0; 2], |window| {
            let outline = window.silhouette(scene, &instances, &mut buffer);
            [pixels(outline.samples), pixels(window.visible_samples)]
        })
    };
    actors.iter().map(of).collect()
}

/// Pixels that hold what of the instances' bounds lies in front of the camera; infinite on a side where they reach
/// beside it. `None` behind.
fn pixel_bounds<'a>(
    instances: impl Iterator<Item = &'a PosedInstance>,
    camera: &CameraModel,
    world_from_cam: &DPose3,
) -> Option<[f64; 4]> {
    let cam_from_world = world_from_cam.inverse();
    let mut bounds: Option<[f64; 4]> = None;
    for instance in instances {
        // Homogeneous pixels: affine in the point.
        let corners = corners_world(instance)
            .map(|corner| camera.homogeneous(cam_from_world.rotation * corner + cam_from_world.translation));
        if corners.iter().all(|h| h.z <= 0.0) {
            continue;
        }
        let [mut u1, mut v1, mut u2, mut v2] =
            bounds.unwrap_or([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY]);
        let mut widen = |u: f64, v: f64| {
            (u1, v1, u2, v2) = (u1.min(u), v1.min(v), u2.max(u), v2.max(v));
        };
        for (i, a) in corners.iter().enumerate() {
            if a.z > 0.0 {
                widen(a.x / a.z, a.y / a.z);
            }
            // Where an edge of the box crosses the plane of the camera, its image runs to infinity.
            for b in (0..3).filter(|axis| i >> axis & 1 == 0).map(|axis| corners[i | 1 << axis]) {
                if (a.z > 0.0) != (b.z > 0.0) {
                    let at = a.truncate() + (b - a).truncate() * (a.z / (a.z - b.z));
                    let least = |p: f64| if p > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
                    let most = |p: f64| if p < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
                    widen(least(at.x), least(at.y));
                    widen(most(at.x), most(at.y));
                }
            }
        }
        bounds = Some([u1, v1, u2, v2]);
    }
    bounds
}

/// The corners of a box round an instance, widened by what rounding vertices to single precision may move them.
fn corners_world(instance: &PosedInstance) -> [DVec3; 8] {
    let bounds = &instance.mesh.bounds;
    let (center, half) = (bounds.center().as_dvec3(), bounds.size().as_dvec3() * 0.5 + 1e-3);
    std::array::from_fn(|i| {
        let side = |axis: usize| if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let local = center + half * DVec3::new(side(0), side(1), side(2));
        instance.placement.rotation * local + instance.placement.translation
    })
}
