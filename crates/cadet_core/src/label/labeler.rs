//! Decides what gets a label, what becomes DontCare and what is left out.

use crate::actor::{ActorState, ObjectClass};
use crate::camera::{CameraModel, Seen};
use crate::error::{Error, Result};
use crate::math::{DPose3, DVec3};
use crate::sense::{PosedScene, VisibilityBuffer};

use super::box_cam::{BoxCam, Rect, truncation};
use super::corners::visible_corners;
use super::silhouette::{ActorInstances, SAMPLES_PER_PIXEL, silhouette};

/// How occlusion is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OcclusionMethod {
    /// Visible over silhouette pixels (default).
    Pixels,
    /// The 2019 paper's: corners of the box against the depth map.
    Corners,
}

/// Every number of the labels' definitions.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelConfig {
    /// How occlusion is measured.
    pub method: OcclusionMethod,
    /// A label's box is at least this high.
    pub min_height_px: f64,
    /// A label's object shows at least this fraction of its silhouette.
    pub min_visible_fraction: f64,
    /// A label's object is at most this deep.
    pub max_depth_m: f64,
    /// An object without a label becomes DontCare if it shows at least this many pixels.
    pub dontcare_min_pixels: f64,
    /// Visible fractions from which the occlusion level is 0 and 1; below, it is 2.
    pub occlusion_levels: [f64; 2],
    /// A corner is hidden by what is nearer than it by more than this.
    pub corner_tolerance_m: f64,
    /// With this many hidden corners the object is occluded.
    pub max_hidden_corners: usize,
}

impl Default for LabelConfig {
    fn default() -> Self {
        Self {
            method: OcclusionMethod::Pixels,
            min_height_px: 15.0,
            min_visible_fraction: 0.1,
            max_depth_m: 80.0,
            dontcare_min_pixels: 8.0,
            occlusion_levels: [0.8, 0.5],
            corner_tolerance_m: 0.1,
            max_hidden_corners: 4,
        }
    }
}

impl LabelConfig {
    /// Refuses numbers that mean nothing.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], naming the field.
    pub fn validated(self) -> Result<Self> {
        let fail = |what, value: f64, expected: &str| {
            Err(Error::OutOfRange { what, value: value.to_string(), expected: expected.to_owned() })
        };
        let fraction = |v: f64| (0.0..=1.0).contains(&v);
        let not_negative = |v: f64| v.is_finite() && v >= 0.0;
        for (what, value) in [
            ("min_height_px", self.min_height_px),
            ("max_depth_m", self.max_depth_m),
            ("dontcare_min_pixels", self.dontcare_min_pixels),
            ("corner_tolerance_m", self.corner_tolerance_m),
        ] {
            if !not_negative(value) {
                return fail(what, value, "a finite number that is not negative");
            }
        }
        let [level0, level1] = self.occlusion_levels;
        for (what, value) in
            [("min_visible_fraction", self.min_visible_fraction), ("occlusion level 0", level0), ("level 1", level1)]
        {
            if !fraction(value) {
                return fail(what, value, "0 to 1");
            }
        }
        if level0 < level1 {
            return fail("occlusion level 0", level0, "at least level 1's threshold");
        }
        Ok(self)
    }
}

/// One line of a label file.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// KITTI's class.
    pub class: ObjectClass,
    /// 0 (whole) to 1 (outside the image), -1 for DontCare.
    pub truncated: f64,
    /// 0 to 2, -1 for DontCare.
    pub occluded: i32,
    /// Observation angle, -10 for DontCare.
    pub alpha: f64,
    /// Pixels.
    pub bbox: Rect,
    /// The box; `None` for DontCare.
    pub box_cam: Option<BoxCam>,
}

/// What is known of a labelled object beyond the label's line.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectMeta {
    /// The actor.
    pub actor_id: i32,
    /// Its class, for DontCare too.
    pub class: ObjectClass,
    /// Its model.
    pub model: String,
    /// Visible samples / samples of the silhouette inside the image.
    pub visible_fraction: f64,
    /// Visible pixels (half of the visible samples).
    pub visible_pixels: f64,
    /// Returns of the scan from the actor.
    pub num_points: usize,
    /// World velocity, m/s.
    pub velocity_world: DVec3,
    /// Rectangle round the silhouette inside the image.
    pub silhouette_bbox: Option<Rect>,
    /// Whether each corner of the 3D box is in view and not hidden.
    pub corner_visible: [bool; 8],
    /// The box, for DontCare too.
    pub box_cam: BoxCam,
}

/// A label and what stands behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Labeled {
    /// The line.
    pub label: Label,
    /// The sidecar.
    pub meta: ObjectMeta,
}

/// An actor's box and its projection, whole and inside the image. `None` out of the image.
fn in_image(actor: &ActorState, camera: &CameraModel, cam_from_world: &DPose3) -> Option<(BoxCam, Rect, Rect)> {
    let box_cam = BoxCam::of(actor, cam_from_world);
    let whole = box_cam.project(camera)?;
    let bbox = whole.clipped(camera.width, camera.height)?;
    Some((box_cam, whole, bbox))
}

impl LabelConfig {
    fn is_near_enough(&self, box_cam: &BoxCam, bbox: &Rect) -> bool {
        bbox.v2 - bbox.v1 >= self.min_height_px && box_cam.location_cam.z <= self.max_depth_m
    }
}

/// Whether some actor would get a label if nothing hid it: cheap, and `false` means that there is none to label.
#[must_use]
pub fn may_label(config: &LabelConfig, actors: &[ActorState], camera: &CameraModel, world_from_cam: &DPose3) -> bool {
    let cam_from_world = world_from_cam.inverse();
    let mut boxes = actors.iter().filter_map(|actor| in_image(actor, camera, &cam_from_world));
    boxes.any(|(box_cam, _, bbox)| config.is_near_enough(&box_cam, &bbox))
}

/// Counts the returns of each labelled actor; `point_actor_ids` names the actor of each return.
pub fn count_points(labels: &mut [Labeled], point_actor_ids: &[i32]) {
    for labeled in labels {
        labeled.meta.num_points = point_actor_ids.iter().filter(|id| **id == labeled.meta.actor_id).count();
    }
}

/// Labels every actor that the camera sees, objects first and then `DontCare`, each in the order of their ids;
/// [`count_points`] adds the returns.
///
/// # Frames and units
/// `world_from_cam` is the pose of the rectified camera 0.
#[must_use]
pub fn label_actors(
    config: &LabelConfig,
    actors: &[ActorState],
    scene: &PosedScene,
    camera: &CameraModel,
    world_from_cam: &DPose3,
    seen: &Seen,
) -> Vec<Labeled> {
    let cam_from_world = world_from_cam.inverse();
    let mut labels = Vec::new();
    // By default what is hidden altogether gets nothing.
    let even_if_hidden = config.min_visible_fraction == 0.0 || config.dontcare_min_pixels == 0.0;
    let instances = ActorInstances::new(scene);
    let mut buffer = VisibilityBuffer::default();
    for actor in actors {
        let Some((box_cam, whole, bbox)) = in_image(actor, camera, &cam_from_world) else { continue };
        let outline =
            silhouette(scene, &instances, actor.id, camera, world_from_cam, seen, even_if_hidden, &mut buffer);
        let visible_fraction =
            if outline.samples == 0 { 0.0 } else { outline.visible_samples as f64 / outline.samples as f64 };
        let visible_pixels = outline.visible_samples as f64 / SAMPLES_PER_PIXEL as f64;
        let corner_visible = visible_corners(&box_cam.corners_cam(), camera, seen, config.corner_tolerance_m);
        let hidden_corners = corner_visible.iter().filter(|v| !**v).count();
        let in_reach = config.is_near_enough(&box_cam, &bbox) && visible_fraction >= config.min_visible_fraction;
        let occluded = match config.method {
            OcclusionMethod::Pixels => {
                Some(config.occlusion_levels.iter().filter(|limit| visible_fraction < **limit).count() as i32)
            }
            OcclusionMethod::Corners => (hidden_corners < config.max_hidden_corners).then_some(0),
        };
        let label = match occluded {
            Some(occluded) if in_reach => Label {
                class: actor.class,
                truncated: truncation(&whole, &bbox),
                occluded,
                alpha: box_cam.alpha(),
                bbox,
                box_cam: Some(box_cam),
            },
            _ if visible_pixels >= config.dontcare_min_pixels => {
                Label { class: ObjectClass::DontCare, truncated: -1.0, occluded: -1, alpha: -10.0, bbox, box_cam: None }
            }
            _ => continue,
        };
        let meta = ObjectMeta {
            actor_id: actor.id,
            class: actor.class,
            model: actor.model.clone(),
            visible_fraction,
            visible_pixels,
            num_points: 0,
            velocity_world: actor.velocity_world,
            silhouette_bbox: outline.bounds,
            corner_visible,
            box_cam,
        };
        labels.push(Labeled { label, meta });
    }
    // Stable, so ids go on rising.
    labels.sort_by_key(|l| l.label.class == ObjectClass::DontCare);
    labels
}
