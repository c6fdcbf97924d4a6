//! An actor's box in the camera frame, and its projection.

use strum::{AsRefStr, VariantArray};

use crate::camera::CameraModel;
use cadet_base::actor::{ActorState, AnnotatedBox};
use cadet_base::error::{Result, variant};
use cadet_base::math::{self, DPose3, DVec2, DVec3};

/// Boxes are clipped at this depth before they are projected.
const NEAR_M: f64 = 0.1;

/// An axis-aligned rectangle in pixels; (0, 0) is the center of the top-left pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Left.
    pub left_px: f64,
    /// Top.
    pub top_px: f64,
    /// Right.
    pub right_px: f64,
    /// Bottom.
    pub bottom_px: f64,
}

impl Rect {
    /// Area in square pixels; 0 for an empty rectangle.
    #[must_use]
    pub fn area_px2(&self) -> f64 {
        (self.right_px - self.left_px).max(0.0) * (self.bottom_px - self.top_px).max(0.0)
    }

    /// The part inside the image: within [0, width - 1] x [0, height - 1]. `None` where nothing is left.
    #[must_use]
    pub fn clipped(&self, width: usize, height: usize) -> Option<Self> {
        let (right, bottom) = ((width - 1) as f64, (height - 1) as f64);
        let inside = Self {
            left_px: self.left_px.clamp(0.0, right),
            top_px: self.top_px.clamp(0.0, bottom),
            right_px: self.right_px.clamp(0.0, right),
            bottom_px: self.bottom_px.clamp(0.0, bottom),
        };
        (inside.area_px2() > 0.0).then_some(inside)
    }
}

/// Which boxes labels hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, AsRefStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Boxes {
    /// What KITTI's annotators would have drawn: a little shorter than the vehicle, its bottom over the ground.
    Kitti,
    /// The extents of the body.
    Exact,
}

impl Boxes {
    /// The box of an actor.
    #[must_use]
    pub fn of(self, actor: &ActorState) -> AnnotatedBox {
        match self {
            Self::Kitti => actor.annotated,
            Self::Exact => AnnotatedBox::exact(actor.size_lwh),
        }
    }

    /// The boxes of that name.
    ///
    /// # Errors
    /// [`cadet_base::Error::Unknown`], listing the names that exist.
    pub fn from_name(name: &str) -> Result<Self> {
        variant("boxes", name, |known| known == name)
    }
}

/// KITTI's box: upright in the camera frame, turned about the camera's y axis only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxCam {
    /// Bottom center in the frame of camera 0.
    pub location_cam: DVec3,
    /// Length, width, height.
    pub size_lwh: DVec3,
    /// Heading about the camera's y axis, in [-pi, pi]; 0 looks along x, -pi/2 along z.
    pub rotation_y: f64,
}

impl BoxCam {
    /// One of an actor's boxes in the camera frame: its center and heading. Pitch and roll relative to the camera are
    /// lost, as KITTI's format has no room for them.
    #[must_use]
    pub fn of(actor: &ActorState, boxes: Boxes, cam_from_world: &DPose3) -> Self {
        let own = boxes.of(actor);
        let center = cam_from_world.rotation * actor.world_of(&own) + cam_from_world.translation;
        let forward = cam_from_world.rotation * (actor.world_from_box.rotation * DVec3::X);
        Self {
            location_cam: center + DVec3::new(0.0, own.size_lwh.z / 2.0, 0.0),
            size_lwh: own.size_lwh,
            rotation_y: math::atan2(-forward.z, forward.x),
        }
    }

    /// Observation angle: `rotation_y` less the bearing of the object, in [-pi, pi).
    #[must_use]
    pub fn alpha(&self) -> f64 {
        math::wrap_angle(self.rotation_y - math::atan2(self.location_cam.x, self.location_cam.z))
    }

    /// The corners: bottom front left, front right, rear right, rear left, then the top in the same order.
    #[must_use]
    pub fn corners_cam(&self) -> [DVec3; 8] {
        let (s, c) = (math::sin(self.rotation_y), math::cos(self.rotation_y));
        // A heading of (c, 0, -s) has its left hand at (s, 0, c): y points down.
        let (forward, left) = (DVec3::new(c, 0.0, -s), DVec3::new(s, 0.0, c));
        let (l, w) = (self.size_lwh.x / 2.0, self.size_lwh.y / 2.0);
        let base = [(l, w), (l, -w), (-l, -w), (-l, w)];
        std::array::from_fn(|i| {
            let (a, b) = base[i % 4];
            let up = if i < 4 { 0.0 } else { self.size_lwh.z };
            self.location_cam + forward * a + left * b - DVec3::new(0.0, up, 0.0)
        })
    }

    /// The rectangle round the projection of the part beyond 0.1 m depth, of a fisheye inside its rim, not clipped to the
    /// image. `None` where the whole box is behind that.
    #[must_use]
    pub fn project(&self, camera: &CameraModel) -> Option<Rect> {
        const EDGES: [(usize, usize); 12] =
            [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)];
        let corners = self.corners_cam();
        let crossings = EDGES.iter().filter_map(|(i, j)| {
            let (a, b) = (corners[*i], corners[*j]);
            ((a.z < NEAR_M) != (b.z < NEAR_M)).then(|| a + (b - a) * ((NEAR_M - a.z) / (b.z - a.z)))
        });
        // A lens bends the edges, so that their ends do not bound them.
        let num_between = if camera.warp().is_some() || camera.fisheye().is_some() { 15 } else { 0 };
        let between = EDGES.iter().flat_map(|(i, j)| {
            let (a, b) = (corners[*i], corners[*j]);
            (1..=num_between).map(move |k| a + (b - a) * (f64::from(k) / f64::from(num_between + 1)))
        });
        let points = corners.into_iter().chain(between);
        if let Some(fisheye) = camera.fisheye() {
            let optical_center = camera.optical_center_cam();
            return rect_round(points.filter_map(|p| fisheye.pixel_within_rim(p - optical_center)));
        }
        let points = points.filter(|p| p.z >= NEAR_M).chain(crossings);
        rect_round(points.filter_map(|p| camera.project(p)).map(|p| p.uv))
    }
}

fn rect_round(pixels: impl Iterator<Item = DVec2>) -> Option<Rect> {
    pixels.fold(None, |rect, p| {
        let r: Rect = rect.unwrap_or(Rect { left_px: p.x, top_px: p.y, right_px: p.x, bottom_px: p.y });
        Some(Rect {
            left_px: r.left_px.min(p.x),
            top_px: r.top_px.min(p.y),
            right_px: r.right_px.max(p.x),
            bottom_px: r.bottom_px.max(p.y),
        })
    })
}

/// 1 - visible area / whole area of a projected box.
#[must_use]
pub(super) fn truncation(whole: &Rect, inside: &Rect) -> f64 {
    (1.0 - inside.area_px2() / whole.area_px2()).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::kitti_like;
    use cadet_base::actor::ObjectClass;
    use cadet_base::frames;
    use cadet_base::math::{DQuat, PI};

    fn level_camera() -> DPose3 {
        // Camera at the world's origin, 1.65 m up, looking along world x.
        let world_from_cam = DPose3 {
            rotation: DQuat::from_mat3(&frames::cam_axes_from_velo_axes().transpose()),
            translation: DVec3::new(0.0, 0.0, 1.65),
        };
        world_from_cam.inverse()
    }

    fn actor(position: DVec3, yaw: f64) -> ActorState {
        ActorState {
            id: 1,
            class: ObjectClass::Car,
            model: "test".to_owned(),
            size_lwh: DVec3::new(4.0, 1.6, 1.5),
            annotated: AnnotatedBox {
                size_lwh: DVec3::new(3.9, 1.62, 1.44),
                bottom_center_in_box: DVec3::new(0.03, -0.02, 0.05),
                farthest_m: 60.0,
                least_points: 0,
            },
            world_from_box: frames::upright(position, yaw),
            velocity_world: DVec3::ZERO,
            angular_velocity_world: DVec3::ZERO,
            brakes_for: None,
        }
    }

    #[test]
    fn a_car_ahead_driving_away_has_kittis_angles() {
        let away = BoxCam::of(&actor(DVec3::new(20.0, 0.0, 0.0), 0.0), Boxes::Exact, &level_camera());
        assert!((away.location_cam - DVec3::new(0.0, 1.65, 20.0)).length() < 1e-12);
        assert!((away.rotation_y + PI / 2.0).abs() < 1e-12 && (away.alpha() + PI / 2.0).abs() < 1e-12);
        let left = BoxCam::of(&actor(DVec3::new(20.0, 20.0, 0.0), PI / 2.0), Boxes::Exact, &level_camera());
        assert!((left.rotation_y.abs() - PI).abs() < 1e-12, "drives along -x: {}", left.rotation_y);
        assert!((left.location_cam.x + 20.0).abs() < 1e-12);
    }

    #[test]
    fn corners_are_those_of_the_upright_actor() {
        for yaw in [-3.0, -1.1, 0.2, 1.0, 2.5] {
            let a = actor(DVec3::new(15.0, -4.0, 0.3), yaw);
            let cam = level_camera();
            let corners = BoxCam::of(&a, Boxes::Exact, &cam).corners_cam();
            for (i, (x, y)) in [(2.0, 0.8), (2.0, -0.8), (-2.0, -0.8), (-2.0, 0.8)].into_iter().enumerate() {
                for (k, z) in [(i, 0.0), (i + 4, 1.5)] {
                    let world = a.world_from_box.rotation * DVec3::new(x, y, z) + a.world_from_box.translation;
                    let expected = cam.rotation * world + cam.translation;
                    assert!((corners[k] - expected).length() < 1e-9, "corner {k}: {} {expected}", corners[k]);
                }
            }
        }
    }

    #[test]
    fn boxes_go_by_their_names() {
        for boxes in [Boxes::Kitti, Boxes::Exact] {
            assert_eq!(Boxes::from_name(boxes.as_ref()).unwrap(), boxes);
        }
        assert!(Boxes::from_name("Kitti").unwrap_err().to_string().contains("kitti, exact"));
    }

    #[test]
    fn annotated_boxes_turn_with_the_actor() {
        // 0.03 m ahead and 0.02 m to the right of the middle, 0.05 m over the ground; the camera is 1.65 m up.
        let ahead = BoxCam::of(&actor(DVec3::new(20.0, 0.0, 0.0), 0.0), Boxes::Kitti, &level_camera());
        assert!((ahead.location_cam - DVec3::new(0.02, 1.60, 20.03)).length() < 1e-12, "{ahead:?}");
        assert_eq!(ahead.size_lwh, DVec3::new(3.9, 1.62, 1.44));
        // Heading to the left, its right side is farther away.
        let left = BoxCam::of(&actor(DVec3::new(20.0, 0.0, 0.0), PI / 2.0), Boxes::Kitti, &level_camera());
        assert!((left.location_cam - DVec3::new(-0.03, 1.60, 20.02)).length() < 1e-12, "{left:?}");
        assert!((left.rotation_y.abs() - PI).abs() < 1e-12);
    }

    #[test]
    fn boxes_cut_by_the_camera_plane_stay_finite() {
        let camera = kitti_like();
        let beside = BoxCam::of(&actor(DVec3::new(1.0, 2.5, 0.0), 0.0), Boxes::Exact, &level_camera());
        let whole = beside.project(&camera).expect("partly in front");
        let inside = whole.clipped(camera.width, camera.height).expect("partly in view");
        let t = truncation(&whole, &inside);
        assert!(whole.left_px < 0.0 && t > 0.9 && t < 1.0, "{whole:?} {t}");
        let behind = BoxCam::of(&actor(DVec3::new(-10.0, 0.0, 0.0), 0.0), Boxes::Exact, &level_camera());
        assert!(behind.project(&camera).is_none());
    }

    #[test]
    fn truncation_of_a_box_half_outside_is_a_half() {
        let whole = Rect { left_px: -50.0, top_px: 10.0, right_px: 50.0, bottom_px: 20.0 };
        let inside = whole.clipped(100, 100).expect("in view");
        assert!((truncation(&whole, &inside) - 0.5).abs() < 1e-12);
    }
}
