//! Which faces were seen lately: neighboring pixels mostly show the same one.

use super::ambient_cache::{AmbientCache, FlatSurface, NOWHERE, SurfacePoint};
use super::face::{FaceVertices, InstanceTransform, ShadingFace};
use crate::camera::light::Light;
use crate::camera::surfaces::hash2;
use crate::camera::visibility::{ImageRays, View};
use crate::sense::{DrawnFace, PosedScene, VisibilityBuffer};
use cadet_base::geometry::Mesh;
use cadet_base::material::{Material, Pattern};
use cadet_base::math::Vec3;

/// What binning needs of a face that was made ready.
#[derive(Debug, Clone, Copy)]
struct BinningInfo {
    variant: u32,
    instance: u32,
    /// Material and normal, in so many steps that the eye sees none.
    appearance: u32,
    is_leaf: bool,
    /// Of a leaf card, relative to the eye.
    middle: Vec3,
    /// Number of the block for which the ambient terms were last found, and where it is kept; leaves have one for all
    /// blocks.
    block: u32,
    ambient: u32,
}

/// Place of a drawn face in the cache, and its plant.
#[derive(Debug, Clone, Copy)]
struct Made {
    /// Index in [`FaceCache::faces`], or [`NOT_MADE`].
    index: u32,
    /// The plant of which it is a part, or [`NO_PLANT`].
    plant: u32,
}

const NOT_MADE: u32 = u32::MAX;
/// The block of leaves whose ambient terms are known.
const EVERYWHERE: u32 = u32::MAX - 1;

/// What shading needs of an instance, in single precision.
struct CachedInstance<'a> {
    mesh: &'a Mesh,
    materials: &'a [Material],
    transform: InstanceTransform,
}

/// Faces that were made lately, and their ambient terms. Faces go by their numbers in the visibility buffer.
pub struct FaceCache<'a> {
    light: &'a Light,
    rays: &'a ImageRays,
    intrinsics: [f64; 4],
    drawn: &'a [DrawnFace],
    instances: Vec<CachedInstance<'a>>,
    made: Vec<Made>,
    /// Drawn faces that are to be made, and how many they are.
    requested: Vec<u32>,
    requested_count: usize,
    raw: Vec<FaceVertices>,
    /// All since the last `clear`.
    pub faces: Vec<ShadingFace>,
    /// As `faces`.
    info: Vec<BinningInfo>,
    /// As `faces`; see [`DrawnFace::inverse_depth_per_m_on_image`].
    planes: Vec<[f64; 3]>,
    pub ambient: AmbientCache<'a>,
}

/// An instance's place is hashed in steps of a part of a meter.
const PLACES_PER_M: f64 = 8.0;
const PLACE_SALT: u32 = 0x97AC;
/// Components of normals are compared in so many steps from 0 to 1; each takes so many bits.
const FINE_STEPS: f32 = 14.0;
const FINE_ZERO: f32 = 15.5;
const FINE_BITS: u32 = 5;
/// Above a normal's bits.
const REST_SHIFT: u32 = 16;
/// No leaf.
const NO_PLANT: u32 = u32::MAX;
/// Faces and ambient terms are forgotten when there are so many faces.
const MAX_FACES: usize = 2500;
/// More than the samples of 64 x 8 pixels, of both layers.
const MAX_REQUESTED: usize = 4096;

impl<'a> FaceCache<'a> {
    pub fn new(
        scene: &'a PosedScene,
        view: &View,
        rays: &'a ImageRays,
        light: &'a Light,
        buffer: &'a VisibilityBuffer,
    ) -> Self {
        let drawn = &buffer.faces;
        let eye = view.world_from_cam.translation;
        let placed = scene.instances.iter().map(|i| CachedInstance {
            mesh: &i.mesh,
            materials: i.palette.materials(),
            transform: InstanceTransform {
                world_from_local: i.placement.rotation.as_mat3(),
                origin: (i.placement.translation - eye).as_vec3(),
                place_hash: hash2(
                    (i.center_world.x * PLACES_PER_M) as i32,
                    (i.center_world.y * PLACES_PER_M) as i32,
                    PLACE_SALT,
                ),
                sheds_snow: i.sheds_snow,
            },
        });
        let plants: Vec<u32> =
            (0..).zip(&scene.instances).map(|(i, of)| if of.palette.is_plant() { i } else { NO_PLANT }).collect();
        let made = |face: &DrawnFace| Made { index: NOT_MADE, plant: plants[face.instance as usize] };
        Self {
            made: drawn.iter().map(made).collect(),
            requested: vec![0; MAX_REQUESTED],
            requested_count: 0,
            raw: Vec::new(),
            drawn,
            instances: placed.collect(),
            light,
            rays,
            faces: Vec::with_capacity(2 * MAX_FACES),
            info: Vec::with_capacity(2 * MAX_FACES),
            planes: Vec::with_capacity(2 * MAX_FACES),
            intrinsics: view.intrinsics_px,
            ambient: AmbientCache::new(light, rays, buffer.blocks_across as u32),
        }
    }

    /// True if so much has been made that it leaves the cache.
    pub fn is_full(&self) -> bool {
        self.faces.len() > MAX_FACES || self.ambient.is_full()
    }

    /// Drops what has been made.
    pub fn clear(&mut self) {
        self.faces.clear();
        self.info.clear();
        self.planes.clear();
        self.ambient.clear();
        for made in &mut self.made {
            made.index = NOT_MADE;
        }
    }

    /// Notes a drawn face for [`FaceCache::make_requested`], unless it is made.
    ///
    /// Without branches: else the processor would wait for the memory of one face after the other.
    #[inline]
    pub fn request(&mut self, number: u32) {
        let made = &mut self.made[number as usize];
        let is_new = made.index == NOT_MADE;
        let next = (self.faces.len() + self.requested_count) as u32;
        made.index = if is_new { next } else { made.index };
        self.requested[self.requested_count % MAX_REQUESTED] = number;
        self.requested_count += usize::from(is_new);
    }

    /// True if two drawn faces are of one plant.
    #[inline]
    pub fn are_of_one_plant(&self, first: u32, second: u32) -> bool {
        let plant = |number: u32| self.made[number as usize].plant;
        plant(first) == plant(second) && plant(first) != NO_PLANT
    }

    /// Makes the faces that were requested. They are read step by step, so that the processor waits for the memory of
    /// many at once.
    pub fn make_requested(&mut self) {
        let (mut raw, requested) = (std::mem::take(&mut self.raw), &self.requested[..self.requested_count]);
        raw.clear();
        raw.extend(requested.iter().map(|number| {
            let DrawnFace { instance, face, is_quad, .. } = self.drawn[*number as usize];
            let slot = self.instances[instance as usize].mesh.face(face).slot;
            FaceVertices { instance, face, is_quad, slot, vertices: [Vec3::ZERO; 3], normals: [Vec3::ZERO; 3] }
        }));
        for r in &mut raw {
            let mesh = self.instances[r.instance as usize].mesh;
            (r.vertices, r.normals) = (mesh.corners(r.face), mesh.corner_normals(r.face));
        }
        self.planes
            .extend(requested.iter().map(|n| self.drawn[*n as usize].inverse_depth_per_m_on_image(self.intrinsics)));
        for raw in &raw {
            let placed = &self.instances[raw.instance as usize];
            let material = &placed.materials[usize::from(raw.slot)];
            let (face, variant) =
                ShadingFace::make(raw, &placed.transform, material, self.rays, self.light.wetness > 0.0);
            let is_leaf = variant.pattern == Pattern::Leaves;
            let step = |n: f32| (n * FINE_STEPS + FINE_ZERO) as u32;
            let (x, y, z) = (step(face.face_normal.x), step(face.face_normal.y), step(face.face_normal.z));
            let appearance = x | y << FINE_BITS | z << (2 * FINE_BITS) | u32::from(raw.slot) << REST_SHIFT;
            self.info.push(BinningInfo {
                variant: variant.index() as u32,
                instance: raw.instance,
                appearance,
                is_leaf,
                middle: placed.transform.world_from_local * ((raw.vertices[0] + raw.vertices[2]) * 0.5)
                    + placed.transform.origin,
                block: NOWHERE,
                ambient: 0,
            });
            self.faces.push(face);
        }
        self.raw = raw;
        self.requested_count = 0;
    }

    /// True if two made faces of one instance show the same where they meet: the halves of a wall, neighbors on a rounded
    /// body.
    #[inline]
    pub fn are_alike(&self, first: u32, second: u32) -> bool {
        let info = |number: u32| &self.info[self.made[number as usize].index as usize];
        let (a, b) = (info(first), info(second));
        (a.instance, a.appearance) == (b.instance, b.appearance)
    }

    /// Index in `faces` of a drawn face that was requested and made, and the number of its shader variant.
    #[inline]
    pub fn made(&self, number: u32) -> (u32, u32) {
        let index = self.made[number as usize].index;
        (index, self.info[index as usize].variant)
    }

    /// 1 / z of a made face's plane at an image point, 1/m, and its change by column and by row.
    #[inline]
    pub fn inverse_depth_per_m_at(&self, index: u32, u: f32, v: f32) -> [f32; 3] {
        let [first, by_column, by_row] = self.planes[index as usize];
        let here = first + by_column * f64::from(u) + by_row * f64::from(v);
        [here as f32, by_column as f32, by_row as f32]
    }

    /// Index of the ambient terms of a face in a block. The block's first corner is the image point (u, v) with the
    /// inverse depth `inverse_depth_per_m`; see [`FaceCache::inverse_depth_per_m_at`]. `there`: the inverse depth at a hit.
    #[inline]
    pub fn ambient_index(
        &mut self,
        index: u32,
        block: u32,
        (u, v): (f32, f32),
        inverse_depth_per_m: [f32; 3],
        there: SurfacePoint,
    ) -> u32 {
        let info = &mut self.info[index as usize];
        if info.block == block || info.block == EVERYWHERE {
            return info.ambient;
        }
        let face = &self.faces[index as usize];
        (info.block, info.ambient) = if info.is_leaf {
            (EVERYWHERE, self.ambient.of_leaf(info.instance, face.face_hash, info.middle))
        } else {
            let surface = FlatSurface { instance: info.instance, variant: info.variant };
            (block, self.ambient.of_block(&surface, face.face_normal, block, (u, v), inverse_depth_per_m, &there))
        };
        info.ambient
    }
}
