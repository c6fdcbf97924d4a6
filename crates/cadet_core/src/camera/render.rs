//! A picture of a posed scene: colour from four samples a pixel, depth and identity from the pixels' centres.

use std::cell::RefCell;

use super::CameraModel;
use super::ambient::SkyView;
use super::exposure::{add_veiling_glare, gain_for_mean_luma};
use super::noise::{blur, expose};
use super::pattern::hash2;
use super::shade::{Light, Surface};
use super::shadow::Shadows;
use super::sky::Sky;

use crate::error::Result;
use crate::material::{Material, Semantic};
use crate::math::{DPose3, DVec3, Mat3, Vec3};
use crate::rng::Stream;
use crate::sense::{Hits, Layer, NO_HIT, PinholeGrid, PosedScene, cast};
use crate::weather::Weather;

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

/// What the camera writes; every array is row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// RGB, 8 bits, almost linear in the light.
    pub image: Vec<u8>,
    /// z along the optical axis at the pixels' centres, metres; infinite for the sky.
    pub depth: Vec<f32>,
    /// -1 sky, 0 static world, actors from 1; panes carry their car's id.
    pub instance: Vec<i32>,
    /// [`Semantic`] as a byte.
    pub semantic: Vec<u8>,
    /// As `instance`, at twice the width and height: samples at -0.25 and +0.25 px about each centre.
    pub super_instance: Vec<i32>,
}

/// Share of the mean radiance that lens and housing scatter over the image.
const VEILING_GLARE: f32 = 0.05;
/// Mean luma that the exposure aims at, and its spread from frame to frame.
const MEAN_LUMA: (f64, f64) = (91.0, 1.8);

/// Memory that a thread keeps from frame to frame: touching fresh pages costs as much as the casting.
#[derive(Default)]
struct Scratch {
    opaque: Option<Hits>,
    glass: Option<Hits>,
    seen_world: Vec<Vec3>,
    rgb: Vec<f32>,
    blurred: Vec<f32>,
    shadows: Vec<Vec<f32>>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Renders a scene.
///
/// # Determinism
/// A function of its arguments; one thread. `stream` feeds the exposure and the noise alone.
///
/// # Errors
/// Those of [`PinholeGrid::new`]: a camera that is none.
pub fn render(scene: &PosedScene, view: &View, weather: &Weather, stream: &mut Stream) -> Result<Rendered> {
    let (width, height) = (view.width, view.height);
    let grid = |origin: f64, step: f64, n: usize| {
        PinholeGrid::new(view.world_from_cam, view.intrinsics, [origin, origin, step, step], height * n, width * n)
    };
    let (centers, samples) = (grid(0.0, 1.0, 1)?, grid(-0.25, 0.5, 2)?);
    let mut scratch = SCRATCH.take();
    let cast_layer = |grid: &PinholeGrid, layer: Layer, old: Option<Hits>| {
        let mut hits = old.unwrap_or_else(|| Hits::new(0, 0));
        hits.clear();
        cast(scene, grid, layer, |_| true, &mut hits);
        hits
    };
    let opaque = cast_layer(&samples, Layer::Opaque, scratch.opaque.take());
    let glass = cast_layer(&samples, Layer::Glass, scratch.glass.take());
    let mut nearest = cast_layer(&centers, Layer::Opaque, None);
    cast(scene, &centers, Layer::Glass, |_| true, &mut nearest);

    let rays = Rays::new(view);
    seen_points(&rays, &opaque, &glass, &mut scratch.seen_world);
    let light = light_of(scene, view, weather, &scratch.seen_world, std::mem::take(&mut scratch.shadows));
    let mut rgb = std::mem::take(&mut scratch.rgb);
    Painter::new(scene, view, &light).paint(&opaque, &glass, &mut rgb);
    blur(&mut rgb, width, height, &mut scratch.blurred);
    add_veiling_glare(&mut rgb, VEILING_GLARE, 2.0 * light.sky.sky_on_level.y);
    let target = stream.clipped_normal(MEAN_LUMA.0, MEAN_LUMA.1) as f32;
    let gain = gain_for_mean_luma(&rgb, target, 19);
    let image = expose(&rgb, width, height, gain, stream);

    let id = |instance: u32| if instance == NO_HIT { -1 } else { scene.instances[instance as usize].actor_id };
    let semantic = nearest.instance.iter().zip(&nearest.face).map(|(instance, face)| match *instance {
        NO_HIT => Semantic::Sky as u8,
        i => scene.instances[i as usize].material(*face).semantic as u8,
    });
    let super_instance = (0..opaque.depth.len())
        .map(|i| id(if glass.depth[i] < opaque.depth[i] { glass.instance[i] } else { opaque.instance[i] }));
    let rendered = Rendered {
        image,
        instance: nearest.instance.iter().map(|i| id(*i)).collect(),
        semantic: semantic.collect(),
        super_instance: super_instance.collect(),
        depth: nearest.depth,
    };
    let shadows = light.shadows.map(Shadows::into_buffers).unwrap_or_default();
    SCRATCH.set(Scratch { opaque: Some(opaque), glass: Some(glass), rgb, shadows, ..scratch });
    Ok(rendered)
}

/// Sun, sky, shadows and openness around a view.
fn light_of(scene: &PosedScene, view: &View, weather: &Weather, seen_world: &[Vec3], buffers: Vec<Vec<f32>>) -> Light {
    let sky = Sky::new(weather);
    let eye = view.world_from_cam.translation;
    let forward = view.world_from_cam.rotation * DVec3::Z;
    let shadows =
        sky.has_shadows().then(|| Shadows::new(scene, eye, forward, sky.sun_world, Some(seen_world), buffers));
    let sky_view = SkyView::new(scene, eye, forward, seen_world);
    Light::new(weather, sky, shadows, sky_view)
}

/// World directions of the image's points, of length 1 along the optical axis.
struct Rays {
    eye: Vec3,
    right: Vec3,
    down: Vec3,
    corner: Vec3,
}

impl Rays {
    fn new(view: &View) -> Self {
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
    fn direction(&self, u: f32, v: f32) -> Vec3 {
        self.corner + self.right * u + self.down * v
    }
}

/// Points all over what the camera sees, one for every other pixel; panes apart from what stands behind.
fn seen_points(rays: &Rays, opaque: &Hits, glass: &Hits, out: &mut Vec<Vec3>) {
    out.clear();
    for row in (0..opaque.rows).step_by(2) {
        let start = row * opaque.columns;
        // Like the squares of one colour on a chessboard.
        for column in (row & 2..opaque.columns).step_by(4) {
            let (solid, pane) = (opaque.depth[start + column], glass.depth[start + column]);
            let direction = rays.direction(column as f32 * 0.5 - 0.25, row as f32 * 0.5 - 0.25);
            if solid < f32::INFINITY {
                out.push(rays.eye + direction * solid);
            }
            if pane < solid {
                out.push(rays.eye + direction * pane);
            }
        }
    }
}

/// What shading needs of an instance, in single precision.
struct Placed {
    world_from_local: Mat3,
    place_hash: u32,
}

/// A face made ready for its hits: neighbouring pixels mostly show the same one.
struct Face<'a> {
    key: (u32, u32),
    origin: Vec3,
    /// Dual edges: their products with a hit's offset are its weights of the second and third corner.
    to_b: Vec3,
    to_c: Vec3,
    normal_world: Vec3,
    normal_local: Vec3,
    corner_normals_world: [Vec3; 3],
    corners_local: [Vec3; 3],
    material: &'a Material,
    face_hash: u32,
    place_hash: u32,
}

/// Samples of one pixel that show the same face.
struct Group {
    instance: u32,
    face: u32,
    count: f32,
    du: f32,
    dv: f32,
    depth: f32,
}

struct Painter<'a> {
    scene: &'a PosedScene,
    light: &'a Light,
    view: &'a View,
    eye: Vec3,
    /// World directions: of a column at row 0, and what a row adds.
    right: Vec3,
    down: Vec3,
    corner: Vec3,
    placed: Vec<Placed>,
    /// Size of a pixel at 1 m.
    pixel_per_m: f32,
}

const OFFSETS: [(f32, f32); 4] = [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)];

impl<'a> Painter<'a> {
    fn new(scene: &'a PosedScene, view: &'a View, light: &'a Light) -> Self {
        let [fx, fy, cx, cy] = view.intrinsics;
        let turn = |v: DVec3| (view.world_from_cam.rotation * v).as_vec3();
        let placed = scene.instances.iter().map(|i| Placed {
            world_from_local: i.world_from_local.as_mat3(),
            place_hash: hash2((i.center_world.x * 8.0) as i32, (i.center_world.y * 8.0) as i32, 0x97AC),
        });
        Self {
            scene,
            light,
            view,
            eye: view.world_from_cam.translation.as_vec3(),
            right: turn(DVec3::X / fx),
            down: turn(DVec3::Y / fy),
            corner: turn(DVec3::new(-cx / fx, -cy / fy, 1.0)),
            placed: placed.collect(),
            pixel_per_m: 1.0 / fx as f32,
        }
    }

    fn paint(&self, opaque: &Hits, glass: &Hits, rgb: &mut Vec<f32>) {
        let (width, height) = (self.view.width, self.view.height);
        let mut cache = None;
        rgb.clear();
        rgb.reserve(width * height * 3);
        for row in 0..height {
            for column in 0..width {
                let first = 2 * row * 2 * width + 2 * column;
                let at = [first, first + 1, first + 2 * width, first + 2 * width + 1];
                let (u, v) = (column as f32, row as f32);
                let mut sum = Vec3::ZERO;
                if at.iter().any(|i| glass.depth[*i] < opaque.depth[*i]) {
                    for (i, (du, dv)) in at.into_iter().zip(OFFSETS) {
                        let (instance, face, depth) = (opaque.instance[i], opaque.face[i], opaque.depth[i]);
                        let behind = self.color(&mut cache, instance, face, u + du, v + dv, depth);
                        let seen = if glass.depth[i] < opaque.depth[i] {
                            self.through_pane(glass, i, u + du, v + dv, behind)
                        } else {
                            behind
                        };
                        sum += seen * 0.25;
                    }
                } else {
                    for group in groups(opaque, &at).into_iter().flatten() {
                        let share = 1.0 / group.count;
                        let (u, v) = (u + group.du * share, v + group.dv * share);
                        let color = self.color(&mut cache, group.instance, group.face, u, v, group.depth * share);
                        sum += color * (group.count * 0.25);
                    }
                }
                rgb.extend([sum.x, sum.y, sum.z]);
            }
        }
    }

    fn color(&self, cache: &mut Option<Face<'a>>, instance: u32, face: u32, u: f32, v: f32, depth: f32) -> Vec3 {
        let direction = self.corner + self.right * u + self.down * v;
        let length = direction.length();
        let view_world = direction * (1.0 / length);
        if instance == NO_HIT {
            let radiance = self.light.sky.visible_radiance(view_world);
            // Fog hides the sky as it hides what is far.
            let fog = self.light.extinction_per_m > 0.004;
            return if fog { self.light.through_air(radiance, view_world, 400.0) } else { radiance };
        }
        if cache.as_ref().is_none_or(|f| f.key != (instance, face)) {
            *cache = Some(self.face(instance, face));
        }
        let Some(face) = cache else { return Vec3::ZERO };
        let surface = self.surface(face, view_world, depth * length, depth);
        self.light.through_air(self.light.opaque(&surface), view_world, surface.distance_m)
    }

    fn through_pane(&self, glass: &Hits, i: usize, u: f32, v: f32, behind: Vec3) -> Vec3 {
        let direction = self.corner + self.right * u + self.down * v;
        let length = direction.length();
        let view_world = direction * (1.0 / length);
        let depth = glass.depth[i];
        let face = self.face(glass.instance[i], glass.face[i]);
        let surface = self.surface(&face, view_world, depth * length, depth);
        self.light.pane(&surface, behind)
    }

    /// What all hits of a face share.
    fn face(&self, instance: u32, face: u32) -> Face<'a> {
        let posed = &self.scene.instances[instance as usize];
        let placed = &self.placed[instance as usize];
        let mesh = &posed.mesh;
        let corners = mesh.faces[face as usize].map(|i| i as usize);
        let world = &self.scene.vertices_world[posed.vertices.clone()];
        let origin = world[corners[0]];
        let (e1, e2) = (world[corners[1]] - origin, world[corners[2]] - origin);
        let (d11, d12, d22) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
        let inverse = 1.0 / (d11 * d22 - d12 * d12).max(1e-20);
        let corners_local = corners.map(|i| mesh.vertices[i]);
        let [a, b, c] = corners_local;
        Face {
            key: (instance, face),
            origin,
            to_b: (e1 * d22 - e2 * d12) * inverse,
            to_c: (e2 * d11 - e1 * d12) * inverse,
            normal_world: e1.cross(e2).normalize_or_zero(),
            normal_local: (b - a).cross(c - a).normalize_or_zero(),
            corner_normals_world: corners.map(|i| placed.world_from_local * mesh.normals[i]),
            corners_local,
            material: posed.material(face),
            face_hash: hash2(face as i32, 0, placed.place_hash),
            place_hash: placed.place_hash,
        }
    }

    fn surface(&self, face: &Face<'a>, view_world: Vec3, distance_m: f32, depth_m: f32) -> Surface<'a> {
        let point_world = self.eye + view_world * distance_m;
        let d = point_world - face.origin;
        let wb = d.dot(face.to_b).clamp(0.0, 1.0);
        let wc = d.dot(face.to_c).clamp(0.0, 1.0 - wb);
        let wa = 1.0 - wb - wc;
        let [na, nb, nc] = face.corner_normals_world;
        let [a, b, c] = face.corners_local;
        let smooth = (na * wa + nb * wb + nc * wc).normalize_or_zero();
        let side = if face.normal_world.dot(view_world) > 0.0 { -1.0 } else { 1.0 };
        Surface {
            point_world,
            point_local: a * wa + b * wb + c * wc,
            normal_world: smooth * side,
            face_normal_world: face.normal_world * side,
            face_normal_local: face.normal_local,
            view_world,
            distance_m,
            pixel_m: depth_m * self.pixel_per_m,
            material: face.material,
            face_hash: face.face_hash,
            place_hash: face.place_hash,
        }
    }
}

/// Collects a pixel's samples by face: one shading each.
#[inline]
fn groups(hits: &Hits, at: &[usize; 4]) -> [Option<Group>; 4] {
    let mut out = [const { None }; 4];
    'samples: for (i, (du, dv)) in at.iter().zip(OFFSETS) {
        let (instance, face, depth) = (hits.instance[*i], hits.face[*i], hits.depth[*i]);
        for slot in &mut out {
            match slot {
                Some(group) => {
                    let group: &mut Group = group;
                    if group.instance == instance && group.face == face {
                        group.count += 1.0;
                        group.du += du;
                        group.dv += dv;
                        group.depth += depth;
                        continue 'samples;
                    }
                }
                None => {
                    *slot = Some(Group { instance, face, count: 1.0, du, dv, depth });
                    continue 'samples;
                }
            }
        }
    }
    out
}
