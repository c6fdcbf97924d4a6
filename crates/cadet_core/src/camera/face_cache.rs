//! Which faces were seen lately, and their ambient light: neighboring pixels mostly show the same one.

use super::face::{Face, FaceVertices, InstanceTransform, ShaderVariant};
use super::light::Light;
use super::pattern::hash2;
use super::visibility_pass::{Rays, View};
use crate::geometry::Mesh;
use crate::material::{Material, Pattern};
use crate::math::Vec3;
use crate::sense::{BLOCK, DrawnFace, PosedScene, VisibilityBuffer};

/// What binning needs of a face that was made ready.
#[derive(Debug, Clone, Copy)]
struct BinningInfo {
    variant: u32,
    instance: u32,
    /// Material and normal, in so many steps that the eye sees none.
    appearance: u32,
    is_leaf: bool,
    /// Number of the block for which the ambient terms were last found, and where it is kept; leaves have one for all
    /// blocks.
    block: u32,
    ambient: u32,
}

/// What is known of a drawn face.
#[derive(Debug, Clone, Copy)]
struct Made {
    /// Index in [`FaceCache::faces`], or [`NOT_MADE`].
    index: u32,
    /// The plant of which it is a part, or [`NO_PLANT`].
    plant: u32,
}

/// Where a sample meets a face.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint {
    /// Image point.
    pub u: f32,
    /// See `u`.
    pub v: f32,
    /// 1 / z, 1/m.
    pub inverse_depth: f32,
    /// So few samples of the block show the face that the light there is theirs.
    pub is_lone: bool,
}

/// Pixels of a block.
const BLOCK_COLUMNS: u32 = BLOCK as u32;
const BLOCK_ROWS: u32 = BLOCK as u32 / 2;

const NOT_MADE: u32 = u32::MAX;
/// No block.
const NOWHERE: u32 = u32::MAX;
/// The block of leaves whose ambient terms are known.
const EVERYWHERE: u32 = u32::MAX - 1;

/// What shading needs of an instance, in single precision.
struct CachedInstance<'a> {
    mesh: &'a Mesh,
    materials: &'a [Material],
    transform: InstanceTransform,
}

/// Faces and ambient terms that were made lately. Faces go by their numbers in the visibility buffer.
pub struct FaceCache<'a> {
    light: &'a Light,
    rays: &'a Rays,
    intrinsics: [f64; 4],
    drawn: &'a [DrawnFace],
    blocks_across: u32,
    instances: Vec<CachedInstance<'a>>,
    made: Vec<Made>,
    /// Drawn faces that are to be made, and how many they are.
    requested: Vec<u32>,
    requested_count: usize,
    raw: Vec<FaceVertices>,
    /// All since the last `clear`.
    pub faces: Vec<Face>,
    /// As `faces`.
    info: Vec<BinningInfo>,
    /// As `faces`; see [`DrawnFace::inverse_depth_on_image`].
    planes: Vec<[f64; 3]>,
    /// Ambient terms: of a leaf one [`AmbientTerms`], of other faces [`PER_BLOCK`] in each block.
    pub ambient: Vec<AmbientTerms>,
    /// Of faces of one instance that lie alike within a block, and where it is kept.
    shared: Vec<(SharedKey, u32)>,
    /// As `shared`, at the corners of blocks.
    corners: Vec<(SharedKey, AmbientTerms)>,
    /// Of leaves that are near each other, and where it is kept.
    leaf_cells: Vec<(LeafKey, u32)>,
}

/// Sky visibility and ambient light, padded, so that it is one load: the visibility towards the six half axes; for flat faces
/// the ambient irradiance, then the visibility towards the four level half axes.
pub type AmbientTerms = [f32; 8];

/// In a block it changes evenly from corner to corner, so that nothing jumps where blocks meet: its value in the first
/// corner, its changes to the right and downwards, and the change of the former by the latter.
pub const PER_BLOCK: usize = 4;

/// Block or corner of blocks, instance, and normal of a face, coarse or with its material.
type SharedKey = (u32, u32, u32, u32);
const SHARED_SLOTS: usize = 256;
const CORNER_SLOTS: usize = 1024;
const SHARED_FROM_M: f32 = 15.0;
/// One over the farthest that a corner of a block is taken to be, 1/m.
const MIN_INVERSE_DEPTH: f32 = 1e-4;
const NO_KEY: SharedKey = (NOWHERE, 0, 0, 0);

/// Instance and cell of leaves that share what they see of the sky.
type LeafKey = (u32, [i32; 3]);
const LEAF_SLOTS: usize = 512;
const NO_LEAF_KEY: LeafKey = (u32::MAX, [0; 3]);
/// Least side of such a cell, and how many of their sides they are away, at least: 45 pixels of KITTI's camera at most.
const LEAF_CELL_M: f32 = 0.5;
const LEAF_CELLS_AWAY: f32 = 16.0;

/// No leaf.
const NO_PLANT: u32 = u32::MAX;
/// Faces and ambient terms are forgotten when there are so many.
const MAX_FACES: usize = 2500;
const MAX_AMBIENT: usize = 20_000;
/// More than the samples of 64 x 8 pixels, of both layers.
const MAX_REQUESTED: usize = 4096;

impl<'a> FaceCache<'a> {
    pub fn new(
        scene: &'a PosedScene,
        view: &View,
        rays: &'a Rays,
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
                place_hash: hash2((i.center_world.x * 8.0) as i32, (i.center_world.y * 8.0) as i32, 0x97AC),
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
            blocks_across: buffer.blocks_across as u32,
            instances: placed.collect(),
            light,
            rays,
            faces: Vec::with_capacity(2 * MAX_FACES),
            info: Vec::with_capacity(2 * MAX_FACES),
            planes: Vec::with_capacity(2 * MAX_FACES),
            intrinsics: view.intrinsics,
            ambient: Vec::with_capacity(2 * MAX_AMBIENT),
            shared: vec![(NO_KEY, 0); SHARED_SLOTS],
            corners: vec![(NO_KEY, [0.0; 8]); CORNER_SLOTS],
            leaf_cells: vec![(NO_LEAF_KEY, 0); LEAF_SLOTS],
        }
    }

    /// True if so much has been made that it leaves the cache.
    pub fn is_full(&self) -> bool {
        self.faces.len() > MAX_FACES || self.ambient.len() > MAX_AMBIENT
    }

    /// Drops what has been made.
    pub fn clear(&mut self) {
        self.faces.clear();
        self.info.clear();
        self.planes.clear();
        self.ambient.clear();
        self.shared.fill((NO_KEY, 0));
        self.leaf_cells.fill((NO_LEAF_KEY, 0));
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
        let [a, b] = [first, second].map(|number| self.made[number as usize].plant);
        a == b && a != NO_PLANT
    }

    /// Makes the faces that were requested. They are read step by step, so that the processor waits for the memory of
    /// many at once.
    pub fn make_requested(&mut self) {
        let (mut raw, requested) = (std::mem::take(&mut self.raw), &self.requested[..self.requested_count]);
        raw.clear();
        let (none, unread) = ([Vec3::ZERO; 3], [0; 3]);
        raw.extend(requested.iter().map(|number| {
            let DrawnFace { instance, face, is_quad, .. } = self.drawn[*number as usize];
            FaceVertices { instance, face, is_quad, slot: 0, corners: unread, vertices: none, normals: none }
        }));
        for r in &mut raw {
            let mesh = self.instances[r.instance as usize].mesh;
            (r.slot, r.corners) = (mesh.slots[r.face as usize], mesh.faces[r.face as usize]);
        }
        for r in &mut raw {
            let mesh = self.instances[r.instance as usize].mesh;
            r.vertices = r.corners.map(|i| mesh.vertices[i as usize]);
            r.normals = r.corners.map(|i| mesh.normals[i as usize]);
        }
        self.planes.extend(requested.iter().map(|n| self.drawn[*n as usize].inverse_depth_on_image(self.intrinsics)));
        for raw in &raw {
            let placed = &self.instances[raw.instance as usize];
            let material = &placed.materials[usize::from(raw.slot)];
            let (face, variant) = Face::make(raw, &placed.transform, material, self.rays, self.light.wetness > 0.0);
            let is_leaf = variant.pattern == Pattern::Leaves;
            let [x, y, z] = face.face_normal.to_array().map(|n| (n * 14.0 + 15.5) as u32);
            let appearance = x | y << 5 | z << 10 | u32::from(raw.slot) << 16;
            self.info.push(BinningInfo {
                variant: variant.index() as u32,
                instance: raw.instance,
                appearance,
                is_leaf,
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
        let [a, b] = [first, second].map(|number| &self.info[self.made[number as usize].index as usize]);
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
    pub fn inverse_depth_at(&self, index: u32, u: f32, v: f32) -> [f32; 3] {
        let [first, by_column, by_row] = self.planes[index as usize];
        let here = first + by_column * f64::from(u) + by_row * f64::from(v);
        [here, by_column, by_row].map(|n| n as f32)
    }

    /// Index of the ambient terms of a face in a block. The block's first corner is the image point (u, v) with the
    /// inverse depth `inverse_depth`; see [`FaceCache::inverse_depth_at`]. `there`: the inverse depth at a hit.
    #[inline]
    pub fn ambient_index(
        &mut self,
        index: u32,
        block: u32,
        (u, v): (f32, f32),
        inverse_depth: [f32; 3],
        there: SurfacePoint,
    ) -> u32 {
        let info = &self.info[index as usize];
        if info.block == block || info.block == EVERYWHERE {
            return info.ambient;
        }
        if info.is_leaf {
            self.find_leaf_ambient(index, &there)
        } else {
            self.find_ambient(index, block, (u, v), inverse_depth, &there)
        }
    }

    /// A leaf's. Those of a plant that lie in one cell share it; each is put into a cell next to its own by chance, the
    /// nearer the likelier, so that no cell shows.
    #[inline(never)]
    fn find_leaf_ambient(&mut self, index: u32, hit: &SurfacePoint) -> u32 {
        let depth = 1.0 / hit.inverse_depth;
        let point_world = self.rays.eye + self.rays.direction(hit.u, hit.v) * depth;
        // The power of two below, so that cells stay where they are as the camera moves.
        let cell_m = f32::from_bits((depth / LEAF_CELLS_AWAY).max(LEAF_CELL_M).to_bits() & 0xFF80_0000);
        let hash = self.faces[index as usize].face_hash;
        let aside = [hash, hash >> 10, hash >> 20].map(|h| (h & 0x3FF) as f32 * (1.0 / 1024.0));
        let cell = (point_world / cell_m + Vec3::from(aside)).floor();
        let info = &mut self.info[index as usize];
        let key = (info.instance, cell.to_array().map(|c| c as i32));
        let mixed = hash2(key.1[0] ^ key.1[2].wrapping_mul(0x3D4D), key.1[1], info.instance);
        let (known, kept) = &mut self.leaf_cells[mixed as usize % LEAF_SLOTS];
        if *known != key {
            // Leaves turn to all sides.
            let [a, b, c, d, e, f] = self.light.sky_probes.sky_visibility(cell * cell_m, Vec3::ZERO);
            (*known, *kept) = (key, self.ambient.len() as u32);
            self.ambient.push([a, b, c, d, e, f, 0.0, 0.0]);
        }
        (info.block, info.ambient) = (EVERYWHERE, *kept);
        *kept
    }

    #[inline(never)]
    fn find_ambient(
        &mut self,
        index: u32,
        block: u32,
        (u, v): (f32, f32),
        inverse_depth: [f32; 3],
        hit: &SurfacePoint,
    ) -> u32 {
        let info = &mut self.info[index as usize];
        let found = self.ambient.len() as u32;
        let normal = self.faces[index as usize].face_normal;
        let [coarse, in_cell] = {
            let coarse = normal.to_array().map(|n| (n * 7.0 + 8.0) as u32);
            let coarse = coarse[0] | coarse[1] << 4 | coarse[2] << 8;
            [coarse | info.variant << 16, coarse ^ coarse >> 3 ^ info.instance.wrapping_mul(37) ^ info.variant]
        };
        // Near by, where faces are large in the image and coats mirror clearly, each face looks for itself.
        if hit.inverse_depth < 1.0 / SHARED_FROM_M {
            let key = (block, info.instance, coarse, u32::from(hit.is_lone));
            let (known, index) = &mut self.shared[in_cell as usize % SHARED_SLOTS];
            if *known == key {
                (info.block, info.ambient) = (block, *index);
                return *index;
            }
            (*known, *index) = (key, found);
        }
        (info.block, info.ambient) = (block, found);
        let info = *info;
        let is_flat = ShaderVariant::of(info.variant as usize).is_flat();
        if hit.is_lone {
            let point_world = self.rays.eye + self.rays.direction(hit.u, hit.v) * (1.0 / hit.inverse_depth);
            let even = [0.0; 8];
            self.ambient.extend([ambient_of(self.light, point_world, normal, is_flat), even, even, even]);
            return found;
        }
        let (column, row) = (block % self.blocks_across, block / self.blocks_across);
        // Between two pixels a face that is seen edge-on may leave the world: its plane is behind the eye there.
        let at_hit = hit.inverse_depth.max(MIN_INVERSE_DEPTH);
        let [first, right, below, across] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| {
            let (du, dv) = ((i * BLOCK_COLUMNS) as f32, (j * BLOCK_ROWS) as f32);
            // The plane may end, or rise to the eye, before the corner.
            let inverse_depth = inverse_depth[0] + inverse_depth[1] * du + inverse_depth[2] * dv;
            let inverse_depth = inverse_depth.clamp(0.5 * at_hit, 2.0 * at_hit);
            let corner = (row + j) * (self.blocks_across + 1) + column + i;
            let is_far = inverse_depth < 1.0 / SHARED_FROM_M;
            let key = (corner, info.instance, if is_far { coarse } else { info.appearance }, u32::from(is_far));
            let slot = corner.wrapping_mul(0x9E37_79B1) ^ in_cell.wrapping_mul(0x85EB_CA6B);
            let (known, ambient) = &mut self.corners[(slot >> 20) as usize % CORNER_SLOTS];
            if *known != key {
                let point_world = self.rays.eye + self.rays.direction(u + du, v + dv) * (1.0 / inverse_depth);
                (*known, *ambient) = (key, ambient_of(self.light, point_world, normal, is_flat));
            }
            *ambient
        });
        let change =
            |from: &AmbientTerms, to: &AmbientTerms| -> AmbientTerms { std::array::from_fn(|k| to[k] - from[k]) };
        let (rightwards, further) = (change(&first, &right), change(&below, &across));
        self.ambient.extend([first, rightwards, change(&first, &below), change(&rightwards, &further)]);
        found
    }
}

/// The ambient terms of a point of a surface.
#[inline(always)]
fn ambient_of(light: &Light, point_world: Vec3, normal: Vec3, is_flat: bool) -> AmbientTerms {
    let sky_visibility = light.sky_probes.sky_visibility(point_world, normal);
    let [a, b, c, d, e, f] = sky_visibility;
    if is_flat {
        let ambient = light.sky.ambient_with_bounce(normal, &sky_visibility);
        [ambient.x, ambient.y, ambient.z, a, b, c, d, 0.0]
    } else {
        [a, b, c, d, e, f, 0.0, 0.0]
    }
}
