//! What a camera's samples meet: depth and identity, before light and colour.

use std::cell::RefCell;

use super::CameraModel;
use crate::error::Result;
use crate::material::Semantic;
use crate::math::{DPose3, DVec3, Vec3};
use crate::sense::{Hits, Layer, NO_HIT, PinholeGrid, PosedScene, cast};

/// A pinhole camera at a place.
#[derive(Debug, Clone)]
pub struct View {
    /// fx, fy, cx, cy in pixels; pixel (0, 0) has its centre at (0, 0).
    pub intrinsics: [f64; 4],
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// x right, y down, z forward, origin in the optical centre.
    pub world_from_cam: DPose3,
}

impl View {
    /// The view of a camera's P2, whose optical centre lies beside that of camera 0.
    ///
    /// `world_from_cam`: the pose of camera 0.
    #[must_use]
    pub fn new(camera: &CameraModel, world_from_cam: &DPose3) -> Self {
        let center_world = world_from_cam.rotation * camera.optical_center_cam() + world_from_cam.translation;
        Self {
            intrinsics: camera.intrinsics(),
            width: camera.width,
            height: camera.height,
            world_from_cam: DPose3 { rotation: world_from_cam.rotation, translation: center_world },
        }
    }
}

/// What the camera looks at, before light and colour; every array is row-major.
#[derive(Debug)]
pub struct Seen {
    /// z along the optical axis at the pixels' centres, metres; infinite for the sky.
    pub depth: Vec<f32>,
    /// -1 sky, 0 static world, actors from 1; panes carry their car's id.
    pub instance: Vec<i32>,
    /// [`Semantic`] as a byte.
    pub semantic: Vec<u8>,
    /// As `instance`, at twice the width and height: samples at each pixel's centre and 0.5 px to the right and below.
    pub super_instance: Vec<i32>,
    /// Four samples a pixel.
    pub(super) samples: Samples,
}

/// What the samples of all pixels meet, two by two a pixel.
#[derive(Debug)]
pub(super) struct Samples {
    /// What is solid.
    pub opaque: Hits,
    /// The panes before it, and what is solid where there are none.
    pub glass: Hits,
}

thread_local! {
    /// Memory that a thread keeps from frame to frame: touching fresh pages costs as much as the casting.
    static SPARE: RefCell<Option<Samples>> = const { RefCell::new(None) };
}

impl Samples {
    fn spare() -> Self {
        SPARE.take().unwrap_or_else(|| Self { opaque: Hits::new(0, 0), glass: Hits::new(0, 0) })
    }

    /// Keeps the memory for the thread's next frame.
    pub fn recycle(self) {
        SPARE.set(Some(self));
    }
}

/// Casts the camera's samples: all that labels need.
///
/// # Errors
/// Those of [`PinholeGrid::new`]: a camera that is none.
pub fn look(scene: &PosedScene, view: &View) -> Result<Seen> {
    let (width, height) = (view.width, view.height);
    let samples = PinholeGrid::new(view.world_from_cam, view.intrinsics, [0.0, 0.0, 0.5, 0.5], height * 2, width * 2)?;
    let Samples { mut opaque, mut glass } = Samples::spare();
    opaque.clear();
    cast(scene, &samples, Layer::Opaque, |_| true, &mut opaque);
    // Only panes before what is solid matter: they alone replace it.
    (glass.rows, glass.columns) = (opaque.rows, opaque.columns);
    glass.depth.clone_from(&opaque.depth);
    glass.instance.clone_from(&opaque.instance);
    glass.face.clone_from(&opaque.face);
    cast(scene, &samples, Layer::Glass, |_| true, &mut glass);
    let id = |instance: u32| if instance == NO_HIT { -1 } else { scene.instances[instance as usize].actor_id };
    let super_instance: Vec<i32> = glass.instance.iter().map(|i| id(*i)).collect();
    // Every other sample of every other row lies on a pixel's centre.
    let centers = (0..height).flat_map(|row| (0..width).map(move |column| (2 * row * width + column) * 2));
    let semantic = |at: usize| match glass.instance[at] {
        NO_HIT => Semantic::Sky as u8,
        i => scene.instances[i as usize].material(glass.face[at]).semantic as u8,
    };
    Ok(Seen {
        depth: centers.clone().map(|at| glass.depth[at]).collect(),
        instance: centers.clone().map(|at| super_instance[at]).collect(),
        semantic: centers.map(semantic).collect(),
        super_instance,
        samples: Samples { opaque, glass },
    })
}

/// World directions of the image's points, of length 1 along the optical axis.
pub(super) struct Rays {
    pub eye: Vec3,
    pub right: Vec3,
    pub down: Vec3,
    corner: Vec3,
}

impl Rays {
    pub fn new(view: &View) -> Self {
        let [fx, fy, cx, cy] = view.intrinsics;
        let turn = |v: DVec3| (view.world_from_cam.rotation * v).as_vec3();
        Self {
            eye: view.world_from_cam.translation.as_vec3(),
            right: turn(DVec3::X / fx),
            down: turn(DVec3::Y / fy),
            corner: turn(DVec3::new(-cx / fx, -cy / fy, 1.0)),
        }
    }

    #[inline]
    pub fn direction(&self, u: f32, v: f32) -> Vec3 {
        self.corner + self.right * u + self.down * v
    }
}

/// Points all over what the camera sees, one for every other pixel; panes apart from what stands behind.
pub(super) fn seen_points(rays: &Rays, opaque: &Hits, glass: &Hits, out: &mut Vec<Vec3>) {
    out.clear();
    for row in (0..opaque.rows).step_by(2) {
        let start = row * opaque.columns;
        // Like the squares of one colour on a chessboard.
        for column in (row & 2..opaque.columns).step_by(4) {
            let (solid, pane) = (opaque.depth[start + column], glass.depth[start + column]);
            let direction = rays.direction(column as f32 * 0.5, row as f32 * 0.5);
            if solid < f32::INFINITY {
                out.push(rays.eye + direction * solid);
            }
            if pane < solid {
                out.push(rays.eye + direction * pane);
            }
        }
    }
}
