//! The visibility pass: what a camera's samples meet: depth and identity, before light and color.

use std::cell::RefCell;
use std::ops::Range;

use crate::camera::CameraModel;
use crate::camera::model::{Maps, SurfaceMaps};
use crate::sense::{BLOCK, Block, DrawnFace, PinholeGrid, PosedScene, VisibilityBuffer, rasterize};
use cadet_base::error::Result;
use cadet_base::material::Semantic;
use cadet_base::math::{DPose3, DVec3, Vec3};

/// A pinhole camera at a place.
#[derive(Debug, Clone)]
pub struct View {
    /// fx, fy, cx, cy in pixels; pixel (0, 0) has its center at (0, 0).
    pub intrinsics_px: [f64; 4],
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// x right, y down, z forward, origin in the optical center.
    pub world_from_cam: DPose3,
}

impl View {
    /// The pinhole view of a camera, before its lens; `world_from_cam` is the pose of the camera's frame.
    #[must_use]
    pub fn new(camera: &CameraModel, world_from_cam: &DPose3) -> Self {
        let camera = camera.pinhole();
        let center_world = world_from_cam.rotation * camera.optical_center_cam() + world_from_cam.translation;
        Self {
            intrinsics_px: camera.intrinsics_px(),
            width: camera.width,
            height: camera.height,
            world_from_cam: DPose3 { rotation: world_from_cam.rotation, translation: center_world },
        }
    }

    /// Some rows of the image, of a camera that has moved.
    pub(crate) fn rows(&self, rows: Range<usize>, displacement: &DPose3) -> Self {
        let [fx, fy, cx, cy] = self.intrinsics_px;
        Self {
            intrinsics_px: [fx, fy, cx, cy - rows.start as f64],
            width: self.width,
            height: rows.len(),
            world_from_cam: *displacement * self.world_from_cam,
        }
    }
}

/// What the camera's samples see, before light and color.
#[derive(Debug)]
pub struct Visibility {
    /// Two samples a pixel, in a quincunx: one on its center, one half a pixel to the right and below.
    pub(crate) samples: Samples,
    pub(super) grid: PinholeGrid,
    /// Of the scene's instances.
    actor_ids: Vec<i32>,
}

impl Visibility {
    /// As [`Maps::depth_m`], at the center of a pixel.
    #[must_use]
    pub fn depth_m_at(&self, row: usize, column: usize) -> f32 {
        let (x, y) = (self.grid.columns_x(2 * row)[column], self.grid.rows_y()[2 * row]);
        self.samples.0.front(2 * row, column).map_or(f32::INFINITY, |(face, _)| face.depth_m_at(x, y))
    }

    /// Whether the centers of some pixels, given by their numbers, show a vehicle, a person, or through its panes what is behind.
    pub(crate) fn show_actors(&self, pixels: impl Iterator<Item = usize>) -> impl Iterator<Item = bool> {
        let buffer = &self.samples.0;
        let front = |pixel: usize| buffer.front_number(2 * (pixel / buffer.columns), pixel % buffer.columns);
        // Read step by step, so that the processor waits for the memory of many at once.
        let numbers: Vec<Option<u32>> = pixels.map(|pixel| front(pixel).map(|(number, _)| number)).collect();
        let shows_actor = |number: u32| self.actor_ids[buffer.faces[number as usize].instance as usize] > 0;
        numbers.into_iter().map(move |number| number.is_some_and(shows_actor))
    }

    /// Depth, instances, and classes at the pixels' centers. `scene`: the one that was looked at.
    #[must_use]
    pub fn maps(&self, scene: &PosedScene) -> Maps {
        let mut depth = vec![f32::INFINITY; self.num_pixels()];
        let mut instance = vec![-1; self.num_pixels()];
        let mut semantic = vec![Semantic::Sky as u8; self.num_pixels()];
        // Neighbors mostly show the same face.
        let (mut last_face, mut actor_id, mut class) = ([u32::MAX; 2], -1, Semantic::Sky as u8);
        self.each_center(|at, face, [x, y]| {
            if last_face != [face.instance, face.face] {
                let posed = &scene.instances[face.instance as usize];
                last_face = [face.instance, face.face];
                (actor_id, class) = (posed.actor_id, posed.material(face.face).semantic as u8);
            }
            depth[at] = face.depth_m_at(x, y);
            (instance[at], semantic[at]) = (actor_id, class);
        });
        Maps { depth_m: depth, instance, semantic, surfaces: SurfaceMaps::default() }
    }

    pub(super) fn num_pixels(&self) -> usize {
        self.samples.0.columns * (self.samples.0.rows / 2)
    }

    /// Calls `see` for each pixel whose center shows a face, with the pixel's number, the face, and the slopes of the ray.
    #[inline(always)]
    pub(super) fn each_center(&self, mut see: impl FnMut(usize, &DrawnFace, [f64; 2])) {
        let buffer = &self.samples.0;
        let (width, height) = (buffer.columns, buffer.rows / 2);
        let (columns_x, rows_y) = (self.grid.columns_x(0), self.grid.rows_y());
        for number in 0..buffer.num_blocks() {
            let opaque = buffer.opaque(number);
            let (top, left) = (number / buffer.blocks_across * BLOCK, number % buffer.blocks_across * BLOCK);
            let transparent = buffer.transparent(number);
            // The samples of every other row lie on the pixels' centers.
            for i in (0..BLOCK.min(2 * height - top)).step_by(2) {
                let y = rows_y[top + i];
                let line = (top + i) / 2 * width + left;
                for j in 0..BLOCK.min(width - left) {
                    let Some((id, _)) = Block::front(opaque, transparent, i, j) else { continue };
                    see(line + j, &buffer.faces[id as usize], [columns_x[left + j], y]);
                }
            }
        }
    }

    /// How many samples of a window see an actor: those of row 2 v lie on the centers of the pixels of row v, those of row
    /// 2 v + 1 half a pixel to the right and below.
    #[must_use]
    pub fn samples_of_actor(&self, actor_id: i32, rows: Range<usize>, columns: Range<usize>) -> usize {
        let buffer = &self.samples.0;
        let shows_actor = |number: u32| self.actor_ids[buffer.faces[number as usize].instance as usize] == actor_id;
        // Neighbors mostly show the same face.
        let (mut last_number, mut is_actor) = (u32::MAX, false);
        let mut count = 0;
        for (block, rows, columns) in buffer.blocks_within(rows, columns) {
            if let Some(number) = buffer.only_face(block) {
                count += if shows_actor(number) { rows.len() * columns.len() } else { 0 };
                continue;
            }
            let (opaque, transparent) = (buffer.opaque(block), buffer.transparent(block));
            for row in rows {
                for column in columns.clone() {
                    let Some((number, _)) = Block::front(opaque, transparent, row, column) else { continue };
                    if last_number != number {
                        (last_number, is_actor) = (number, shows_actor(number));
                    }
                    count += usize::from(is_actor);
                }
            }
        }
        count
    }
}

/// What the samples of all pixels see.
#[derive(Debug)]
pub(crate) struct Samples(pub VisibilityBuffer);

thread_local! {
    /// Memory that a thread keeps from frame to frame: touching fresh pages costs as much as the casting.
    static SPARE: RefCell<VisibilityBuffer> = RefCell::default();
}

impl Drop for Samples {
    fn drop(&mut self) {
        // Without the thread's storage, as at its end, there is no next frame either.
        let _ = SPARE.try_with(|spare| spare.replace(std::mem::take(&mut self.0)));
    }
}

/// Casts the camera's samples: all that labels need.
///
/// # Errors
/// Those of [`PinholeGrid::new`]: a camera that is none.
pub fn visibility_pass(scene: &PosedScene, view: &View) -> Result<Visibility> {
    let (width, height) = (view.width, view.height);
    let grid = PinholeGrid::quincunx(view.world_from_cam, view.intrinsics_px, [0.0, 0.0], height * 2, width)?;
    let mut buffer = SPARE.take();
    rasterize(scene, &grid, &mut buffer);
    let actor_ids = scene.instances.iter().map(|i| i.actor_id).collect();
    Ok(Visibility { samples: Samples(buffer), grid, actor_ids })
}

/// World directions of the image's points, of length 1 along the optical axis.
pub(crate) struct ImageRays {
    pub eye: Vec3,
    pub right: Vec3,
    pub down: Vec3,
    /// Unit vectors.
    pub across: Vec3,
    pub downwards: Vec3,
    corner: Vec3,
}

impl ImageRays {
    pub fn new(view: &View) -> Self {
        let [fx, fy, cx, cy] = view.intrinsics_px;
        let turn = |v: DVec3| (view.world_from_cam.rotation * v).as_vec3();
        let (right, down) = (turn(DVec3::X / fx), turn(DVec3::Y / fy));
        Self {
            eye: view.world_from_cam.translation.as_vec3(),
            right,
            down,
            across: right.normalize(),
            downwards: down.normalize(),
            corner: turn(DVec3::new(-cx / fx, -cy / fy, 1.0)),
        }
    }

    #[inline]
    pub fn direction(&self, u: f32, v: f32) -> Vec3 {
        self.corner + self.right * u + self.down * v
    }
}

/// The row of samples at which a block is looked at, by turns.
const POINT_ROWS: [usize; 4] = [0, 4, 2, 6];

/// Points all over what the camera sees, one for every eight pixels; transparent surfaces apart from what stands behind.
pub(crate) fn visible_points(rays: &ImageRays, samples: &Samples, out: &mut Vec<Vec3>) {
    out.clear();
    let buffer = &samples.0;
    let across = buffer.blocks_across.max(1);
    // Blocks look at different rows, so that what is thin is not passed by; one row is one cache line.
    let row_of = |block_column: usize, block_row: usize| POINT_ROWS[(block_column + block_row * 2) % POINT_ROWS.len()];
    let mut rows: Vec<[f32; BLOCK]> = Vec::with_capacity(across);
    for (block_row, first) in (0..buffer.num_blocks()).step_by(across).enumerate() {
        // Read at once, so that the processor waits for many lines together.
        rows.clear();
        rows.extend(
            (0..across).map(|column| buffer.opaque(first + column).inverse_depth_per_m[row_of(column, block_row)]),
        );
        for (block_column, opaque) in rows.iter().enumerate() {
            let (number, i) = (block_row * across + block_column, row_of(block_column, block_row));
            let transparent = buffer.transparent(number).map(|transparent| &transparent.inverse_depth_per_m[i]);
            for j in (block_row % 2..BLOCK).step_by(2) {
                let (column, row) = (block_column * BLOCK + j, block_row * BLOCK + i);
                let direction = rays.direction(column as f32, row as f32 * 0.5);
                if opaque[j] > 0.0 {
                    out.push(rays.eye + direction * (1.0 / opaque[j]));
                }
                if let Some(transparent) = transparent.filter(|transparent| transparent[j] > opaque[j]) {
                    out.push(rays.eye + direction * (1.0 / transparent[j]));
                }
            }
        }
    }
}
