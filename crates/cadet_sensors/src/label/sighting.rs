//! What a camera sees of an actor.

use super::box_cam::{BoxCam, Boxes, Rect, truncation};
use crate::camera::CameraModel;
use cadet_base::actor::{ActorState, ObjectClass};
use cadet_base::math::{DPose3, DVec3};

/// An actor that a camera sees: what its label is made of, if it gets one.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// The actor.
    pub actor_id: i32,
    /// Its class.
    pub class: ObjectClass,
    /// Its model.
    pub model: String,
    /// Whether it gets a label. What gets none is seen all the same: a detector should not be scored there.
    pub is_labeled: bool,
    /// Share of the box's projection outside the image.
    pub truncation: f64,
    /// 0 visible, 1 partly hidden, 2 mostly hidden.
    pub occlusion_level: u8,
    /// Heading of the box less its bearing from the camera, radians.
    pub observation_angle_rad: f64,
    /// The box's projection inside the image.
    pub bbox: Rect,
    /// Visible samples / samples of the silhouette inside the image, times `contrast`.
    pub visible_fraction: f64,
    /// Visible pixels (half of the visible samples).
    pub visible_px: f64,
    /// Share of its contrast that is left through fog, rain and snow; 1 in clear air.
    pub contrast: f64,
    /// Returns of the scan from the actor.
    pub num_points: usize,
    /// Returns that an annotator of KITTI would have needed.
    pub least_points: usize,
    /// World velocity, m/s.
    pub velocity_world: DVec3,
    /// Rectangle round the silhouette inside the image; `None` where nothing is seen and behind a lens that bends.
    pub silhouette_bbox: Option<Rect>,
    /// Whether each corner of the 3D box is in view and not hidden.
    pub corner_visible: [bool; 8],
    /// The box.
    pub box_cam: BoxCam,
}

/// An actor's box and what the image holds of its projection.
pub(super) struct Placed {
    pub box_cam: BoxCam,
    /// The projection inside the image.
    pub bbox: Rect,
    /// Share of the projection outside it.
    pub truncation: f64,
}

impl Placed {
    /// `None` out of the image.
    pub fn new(actor: &ActorState, boxes: Boxes, camera: &CameraModel, cam_from_world: &DPose3) -> Option<Self> {
        let box_cam = BoxCam::of(actor, boxes, cam_from_world);
        let whole = box_cam.project(camera)?;
        let bbox = whole.clipped(camera.width, camera.height)?;
        Some(Self { box_cam, bbox, truncation: truncation(&whole, &bbox) })
    }
}
