//! A picture of a posed scene: colour from four samples a pixel, depth and identity from the pixels' centres.

use std::cell::RefCell;

use super::ambient::SkyView;
use super::exposure::{add_veiling_glare, gain_for_mean_luma};
use super::look::{Rays, Seen, View, look, seen_points};
use super::noise::{MIDDLE_PX, blur, expose};
use super::pattern::hash2;
use super::shade::{Around, Light, Surface};
use super::shadow::Shadows;
use super::sky::Sky;
use crate::error::Result;
use crate::material::Material;
use crate::math::{DVec3, Mat3, Vec3};
use crate::rng::Stream;
use crate::sense::{Hits, NO_HIT, PosedScene};
use crate::weather::Weather;

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
    /// As `instance`, at twice the width and height: samples at each pixel's centre and 0.5 px to the right and below.
    pub super_instance: Vec<i32>,
}

/// Share of the mean radiance that lens and housing scatter over the image.
const VEILING_GLARE: f32 = 0.05;
/// Mean luma that the exposure aims at, and its spread from frame to frame.
const MEAN_LUMA: (f64, f64) = (91.0, 1.8);

/// Memory that a thread keeps from frame to frame: touching fresh pages costs as much as the casting.
#[derive(Default)]
struct Scratch {
    seen_world: Vec<Vec3>,
    rgb: Vec<f32>,
    blurred: Vec<f32>,
    shadows: Vec<Vec<f32>>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Renders a scene: [`look`], then [`paint`].
///
/// # Determinism
/// A function of its arguments; one thread. `stream` feeds the exposure and the noise alone.
///
/// # Errors
/// Those of [`PinholeGrid::new`]: a camera that is none.
pub fn render(scene: &PosedScene, view: &View, weather: &Weather, stream: &mut Stream) -> Result<Rendered> {
    Ok(paint(scene, view, weather, look(scene, view)?, stream))
}

/// Gives what is seen its light and colour, and takes the picture.
#[must_use]
pub fn paint(scene: &PosedScene, view: &View, weather: &Weather, seen: Seen, stream: &mut Stream) -> Rendered {
    let (width, height) = (view.width, view.height);
    let mut scratch = SCRATCH.take();
    let rays = Rays::new(view);
    seen_points(&rays, &seen.samples.opaque, &seen.samples.glass, &mut scratch.seen_world);
    let light = light_of(scene, view, weather, &scratch.seen_world, std::mem::take(&mut scratch.shadows));
    let mut rgb = std::mem::take(&mut scratch.rgb);
    Painter::new(scene, view, &rays, &light).paint(&seen.samples.opaque, &seen.samples.glass, &mut rgb);
    blur(&mut rgb, width, height, &mut scratch.blurred);
    add_veiling_glare(&mut rgb, VEILING_GLARE, 2.0 * light.sky.sky_on_level.y);
    let target = stream.clipped_normal(MEAN_LUMA.0, MEAN_LUMA.1) as f32;
    let gain = gain_for_mean_luma(&rgb, target, 19);
    let image = expose(&rgb, width, height, gain, stream);
    let shadows = light.shadows.map(Shadows::into_buffers).unwrap_or_default();
    SCRATCH.set(Scratch { rgb, shadows, ..scratch });
    let Seen { depth, instance, semantic, super_instance, samples } = seen;
    samples.recycle();
    Rendered { image, depth, instance, semantic, super_instance }
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
    /// As it was found for this image point.
    around: Option<(f32, f32, Around)>,
}

/// Faces that were just seen: most will be seen again a pixel further or a row below.
struct FaceCache<'a>(Vec<Option<Face<'a>>>);

impl<'a> FaceCache<'a> {
    const SIZE: usize = 256;

    fn new() -> Self {
        Self((0..Self::SIZE).map(|_| None).collect())
    }

    #[inline]
    fn get(&mut self, instance: u32, face: u32, make: impl FnOnce() -> Face<'a>) -> &mut Face<'a> {
        let slot = &mut self.0[(face ^ instance.wrapping_mul(97)) as usize % Self::SIZE];
        if slot.as_ref().is_none_or(|f| f.key != (instance, face)) {
            *slot = Some(make());
        }
        slot.get_or_insert_with(|| unreachable!("just filled"))
    }
}

/// The sky's radiance on a coarse lattice of the image, filled where it is asked for.
struct SkyLattice {
    columns: usize,
    /// NaN where nobody has asked.
    radiance: Vec<Vec3>,
}

impl SkyLattice {
    /// Pixels between its points; clouds are smooth over so few.
    const STEP: f32 = 4.0;

    fn new(width: usize, height: usize) -> Self {
        let points = |n: usize| n / Self::STEP as usize + 3;
        Self { columns: points(width), radiance: vec![Vec3::NAN; points(width) * points(height)] }
    }

    /// The radiance at an image point no further than a pixel outside of the image.
    #[inline]
    fn at(&mut self, u: f32, v: f32, exact: impl Fn(f32, f32) -> Vec3) -> Vec3 {
        let (x, y) = ((u + Self::STEP) * (1.0 / Self::STEP), (v + Self::STEP) * (1.0 / Self::STEP));
        let (ix, iy) = (x as usize, y as usize);
        let (fx, fy) = (x - ix as f32, y - iy as f32);
        let mut corner = |ix: usize, iy: usize| {
            let radiance = &mut self.radiance[iy * self.columns + ix];
            if radiance.x.is_nan() {
                *radiance = exact((ix as f32 - 1.0) * Self::STEP, (iy as f32 - 1.0) * Self::STEP);
            }
            *radiance
        };
        let (a, b, c, d) = (corner(ix, iy), corner(ix + 1, iy), corner(ix, iy + 1), corner(ix + 1, iy + 1));
        let (top, bottom) = (a + (b - a) * fx, c + (d - c) * fx);
        top + (bottom - top) * fy
    }
}

/// What painting remembers from pixel to pixel.
struct Memory<'a> {
    faces: FaceCache<'a>,
    sky: SkyLattice,
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
    rays: &'a Rays,
    placed: Vec<Placed>,
    /// Size of a pixel at 1 m.
    pixel_per_m: f32,
}

/// Pixels of a face so close together share what changes slowly.
const SHARED_PX: f32 = 4.0;
/// From the middle of a pixel's four samples, which lies `MIDDLE_PX` right and below of its centre; `blur` takes that
/// back.
const OFFSETS: [(f32, f32); 4] = [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)];

impl<'a> Painter<'a> {
    fn new(scene: &'a PosedScene, view: &'a View, rays: &'a Rays, light: &'a Light) -> Self {
        let placed = scene.instances.iter().map(|i| Placed {
            world_from_local: i.placement.rotation.as_mat3(),
            place_hash: hash2((i.center_world.x * 8.0) as i32, (i.center_world.y * 8.0) as i32, 0x97AC),
        });
        let pixel_per_m = 1.0 / view.intrinsics[0] as f32;
        Self { scene, light, view, rays, placed: placed.collect(), pixel_per_m }
    }

    fn paint(&self, opaque: &Hits, glass: &Hits, rgb: &mut Vec<f32>) {
        let (width, height) = (self.view.width, self.view.height);
        let mut memory = Memory { faces: FaceCache::new(), sky: SkyLattice::new(width, height) };
        rgb.clear();
        rgb.reserve(width * height * 3);
        for row in 0..height {
            for column in 0..width {
                let first = 2 * row * 2 * width + 2 * column;
                let at = [first, first + 1, first + 2 * width, first + 2 * width + 1];
                let (u, v) = (column as f32 + MIDDLE_PX, row as f32 + MIDDLE_PX);
                let mut sum = Vec3::ZERO;
                if at.iter().any(|i| glass.depth[*i] < opaque.depth[*i]) {
                    let before = |i: &usize| glass.depth[*i] < opaque.depth[*i];
                    if let (Some(solid), Some(pane), true) =
                        (one_group(opaque, &at), one_group(glass, &at), at.iter().all(before))
                    {
                        let depth = solid.depth * 0.25;
                        let behind = self.color(&mut memory, solid.instance, solid.face, u, v, depth);
                        sum = self.through_pane(&mut memory, &pane, u, v, behind);
                    } else {
                        for (i, (du, dv)) in at.into_iter().zip(OFFSETS) {
                            let (u, v) = (u + du, v + dv);
                            let (instance, face, depth) = (opaque.instance[i], opaque.face[i], opaque.depth[i]);
                            let mut seen = self.color(&mut memory, instance, face, u, v, depth);
                            if before(&i) {
                                let (instance, face, depth) = (glass.instance[i], glass.face[i], glass.depth[i]);
                                let pane = Group { instance, face, count: 1.0, du, dv, depth };
                                seen = self.through_pane(&mut memory, &pane, u, v, seen);
                            }
                            sum += seen * 0.25;
                        }
                    }
                } else if let Some(group) = one_group(opaque, &at) {
                    sum = self.color(&mut memory, group.instance, group.face, u, v, group.depth * 0.25);
                } else {
                    for group in groups(opaque, &at).into_iter().flatten() {
                        let share = 1.0 / group.count;
                        let (u, v) = (u + group.du * share, v + group.dv * share);
                        let color = self.color(&mut memory, group.instance, group.face, u, v, group.depth * share);
                        sum += color * (group.count * 0.25);
                    }
                }
                rgb.extend([sum.x, sum.y, sum.z]);
            }
        }
    }

    fn color(&self, memory: &mut Memory<'a>, instance: u32, face: u32, u: f32, v: f32, depth: f32) -> Vec3 {
        if instance == NO_HIT {
            // The lattice is too coarse for the edge at the horizon.
            let is_low = self.rays.direction(u, v).z < 0.015;
            return if is_low { self.sky(u, v) } else { memory.sky.at(u, v, |u, v| self.sky(u, v)) };
        }
        let direction = self.rays.direction(u, v);
        let length = direction.length();
        let view_world = direction * (1.0 / length);
        let face = memory.faces.get(instance, face, || self.face(instance, face));
        let surface = self.surface(face, view_world, depth * length, depth);
        let around = self.around(face, &surface, u, v);
        self.light.opaque(&surface, &around)
    }

    fn sky(&self, u: f32, v: f32) -> Vec3 {
        let view_world = self.rays.direction(u, v).normalize();
        let radiance = self.light.sky.visible_radiance(view_world);
        // Fog hides the sky as it hides what is far.
        let fog = self.light.extinction_per_m > 0.004;
        if fog { self.light.through_air(radiance, view_world, 400.0) } else { radiance }
    }

    /// What lies around a surface, from a near pixel of the same face where there is one.
    #[inline]
    fn around(&self, face: &mut Face<'a>, surface: &Surface, u: f32, v: f32) -> Around {
        match face.around {
            Some((u0, v0, around)) if (u - u0).abs() < SHARED_PX && (v - v0).abs() < SHARED_PX => around,
            _ => {
                let around = self.light.around(surface);
                face.around = Some((u, v, around));
                around
            }
        }
    }

    fn through_pane(&self, memory: &mut Memory<'a>, pane: &Group, u: f32, v: f32, behind: Vec3) -> Vec3 {
        let direction = self.rays.direction(u, v);
        let length = direction.length();
        let view_world = direction * (1.0 / length);
        let depth = pane.depth / pane.count;
        let face = memory.faces.get(pane.instance, pane.face, || self.face(pane.instance, pane.face));
        let surface = self.surface(face, view_world, depth * length, depth);
        let around = self.around(face, &surface, u, v);
        self.light.pane(&surface, &around, behind)
    }

    /// What all hits of a face share.
    fn face(&self, instance: u32, face: u32) -> Face<'a> {
        let posed = &self.scene.instances[instance as usize];
        let placed = &self.placed[instance as usize];
        let mesh = &posed.mesh;
        let corners = mesh.faces[face as usize].map(|i| i as usize);
        let [origin, b_world, c_world] = posed.corners_world(face);
        let (e1, e2) = (b_world - origin, c_world - origin);
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
            around: None,
        }
    }

    fn surface(&self, face: &Face<'a>, view_world: Vec3, distance_m: f32, depth_m: f32) -> Surface<'a> {
        let point_world = self.rays.eye + view_world * distance_m;
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

/// A pixel's samples where all show the same.
#[inline]
fn one_group(hits: &Hits, at: &[usize; 4]) -> Option<Group> {
    let (instance, face) = (hits.instance[at[0]], hits.face[at[0]]);
    let same = at[1..].iter().all(|i| hits.face[*i] == face && hits.instance[*i] == instance);
    let depth = at.iter().map(|i| hits.depth[*i]).sum();
    same.then_some(Group { instance, face, count: 4.0, du: 0.0, dv: 0.0, depth })
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
