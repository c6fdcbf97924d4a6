//! The ambient light of faces, found at the corners of blocks and shared by what lies alike.

use super::face::ShaderVariant;
use crate::camera::light::Light;
use crate::camera::surfaces::hash2;
use crate::camera::visibility::ImageRays;
use crate::sense::BLOCK;
use cadet_base::math::Vec3;

/// Where a sample meets a face.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint {
    /// Image point.
    pub u: f32,
    /// See `u`.
    pub v: f32,
    /// 1 / z, 1/m.
    pub inverse_depth_per_m: f32,
    /// So few samples of the block show the face that the light there is theirs.
    pub is_lone: bool,
}

/// What tells whether two flat surfaces share their ambient terms.
#[derive(Debug, Clone, Copy)]
pub struct FlatSurface {
    pub instance: u32,
    pub variant: u32,
}

/// Pixels of a block.
const BLOCK_COLUMNS: u32 = BLOCK as u32;
const BLOCK_ROWS: u32 = BLOCK as u32 / 2;

/// No block.
pub const NOWHERE: u32 = u32::MAX;

/// Sky visibility and ambient light, padded, so that it is one load: the visibility towards the six half axes; for flat faces
/// the ambient irradiance, then the visibility towards the four level half axes.
pub type AmbientTerms = [f32; 8];

/// In a block it changes evenly from corner to corner, so that nothing jumps where blocks meet: its value in the first
/// corner, its changes to the right and downwards, and the change of the former by the latter.
pub const PER_BLOCK: usize = 4;

/// Block or corner of blocks, and instance, normal, depth and nature of a face: faces of one plane share.
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

/// Ambient terms are forgotten when there are so many.
const MAX_AMBIENT: usize = 20_000;
/// Components of normals are compared in so many steps from 0 to 1; each takes so many bits.
const NORMAL_STEPS: f32 = 511.0;
const NORMAL_ZERO: f32 = 511.5;
const NORMAL_BITS: u32 = 10;
/// Bits of a depth that rounding may change.
const ROUNDED_BITS: u32 = 10;
/// Bits of a number that are its sign and its exponent: what is left is a power of two.
const EXPONENT_BITS: u32 = 0xFF80_0000;
/// Ten bits of a hash for each axis.
const ASIDE_BITS: u32 = 10;
const ASIDE_STEPS: u32 = 1 << ASIDE_BITS;
/// Odd factors that mix hashes of slots.
const LEAF_FACTOR: i32 = 0x3D4D;
const INSTANCE_FACTOR: u32 = 37;
const CORNER_FACTORS: [u32; 2] = [0x9E37_79B1, 0x85EB_CA6B];
/// The high bits of a product are the best mixed.
const SLOT_SHIFT: u32 = 20;

/// Ambient terms that were found lately.
pub struct AmbientCache<'a> {
    light: &'a Light,
    rays: &'a ImageRays,
    blocks_across: u32,
    /// Ambient terms: of a leaf one [`AmbientTerms`], of other faces [`PER_BLOCK`] in each block.
    pub terms: Vec<AmbientTerms>,
    /// Of faces of one instance that lie alike within a block, and where it is kept.
    shared: Vec<(SharedKey, u32)>,
    /// As `shared`, at the corners of blocks.
    corners: Vec<(SharedKey, AmbientTerms)>,
    /// Of leaves that are near each other, and where it is kept.
    leaf_cells: Vec<(LeafKey, u32)>,
}

impl<'a> AmbientCache<'a> {
    pub fn new(light: &'a Light, rays: &'a ImageRays, blocks_across: u32) -> Self {
        Self {
            light,
            rays,
            blocks_across,
            terms: Vec::with_capacity(2 * MAX_AMBIENT),
            shared: vec![(NO_KEY, 0); SHARED_SLOTS],
            corners: vec![(NO_KEY, [0.0; 8]); CORNER_SLOTS],
            leaf_cells: vec![(NO_LEAF_KEY, 0); LEAF_SLOTS],
        }
    }

    /// True if so much has been found that it leaves the cache.
    pub fn is_full(&self) -> bool {
        self.terms.len() > MAX_AMBIENT
    }

    /// Drops what has been found, but at the corners of blocks.
    pub fn clear(&mut self) {
        self.terms.clear();
        self.shared.fill((NO_KEY, 0));
        self.leaf_cells.fill((NO_LEAF_KEY, 0));
    }

    /// A leaf's, by its middle relative to the eye. Those of a plant that lie in one cell share it; each is put into a cell
    /// next to its own by chance, the nearer the likelier, so that no cell shows.
    #[inline(never)]
    pub fn of_leaf(&mut self, instance: u32, hash: u32, middle: Vec3) -> u32 {
        let point_world = self.rays.eye + middle;
        // The power of two below, so that cells stay where they are as the camera moves.
        let cell_m = f32::from_bits((middle.length() / LEAF_CELLS_AWAY).max(LEAF_CELL_M).to_bits() & EXPONENT_BITS);
        let aside = |axis: u32| (hash >> (axis * ASIDE_BITS) & (ASIDE_STEPS - 1)) as f32 * (1.0 / ASIDE_STEPS as f32);
        let cell = (point_world / cell_m + Vec3::new(aside(0), aside(1), aside(2))).floor();
        let key = (instance, [cell.x as i32, cell.y as i32, cell.z as i32]);
        let mixed = hash2(key.1[0] ^ key.1[2].wrapping_mul(LEAF_FACTOR), key.1[1], instance);
        let (known, kept) = &mut self.leaf_cells[mixed as usize % LEAF_SLOTS];
        if *known != key {
            // Leaves turn to all sides.
            let [a, b, c, d, e, f] = self.light.sky_probes.sky_visibility(cell * cell_m, Vec3::ZERO);
            (*known, *kept) = (key, self.terms.len() as u32);
            self.terms.push([a, b, c, d, e, f, 0.0, 0.0]);
        }
        *kept
    }

    /// Index of the ambient terms of a surface in a block; see [`super::face_cache::FaceCache::ambient_index`].
    #[inline(never)]
    pub fn of_block(
        &mut self,
        surface: &FlatSurface,
        normal: Vec3,
        block: u32,
        (u, v): (f32, f32),
        inverse_depth_per_m: [f32; 3],
        hit: &SurfacePoint,
    ) -> u32 {
        let &FlatSurface { instance, variant } = surface;
        let found = self.terms.len() as u32;
        let step = |n: f32| (n * NORMAL_STEPS + NORMAL_ZERO) as u32;
        let (x, y, z) = (step(normal.x), step(normal.y), step(normal.z));
        let bearing = x | y << NORMAL_BITS | z << (2 * NORMAL_BITS);
        let in_cell = bearing ^ bearing >> 7 ^ instance.wrapping_mul(INSTANCE_FACTOR) ^ variant;
        let is_flat = ShaderVariant::of(variant as usize).is_flat();
        // Near by, where faces are large in the image and coats mirror clearly, each face looks for itself.
        if hit.inverse_depth_per_m < 1.0 / SHARED_FROM_M {
            let rest = depth_step(inverse_depth_per_m[0]) | u32::from(hit.is_lone) << 1 | u32::from(is_flat);
            let key = (block, instance, bearing, rest);
            let (known, index) = &mut self.shared[in_cell as usize % SHARED_SLOTS];
            if *known == key {
                return *index;
            }
            (*known, *index) = (key, found);
        }
        if hit.is_lone {
            let point_world = self.rays.eye + self.rays.direction(hit.u, hit.v) * (1.0 / hit.inverse_depth_per_m);
            let even = [0.0; 8];
            self.terms.extend([ambient_of(self.light, point_world, normal, is_flat), even, even, even]);
            return found;
        }
        let (column, row) = (block % self.blocks_across, block / self.blocks_across);
        // Between two pixels a face that is seen edge-on may leave the world: its plane is behind the eye there.
        let at_hit = hit.inverse_depth_per_m.max(MIN_INVERSE_DEPTH);
        let mut corners = [[0.0; 8]; PER_BLOCK];
        for (k, ambient) in (0..).zip(&mut corners) {
            let (i, j) = (k % 2, k / 2);
            let (du, dv) = ((i * BLOCK_COLUMNS) as f32, (j * BLOCK_ROWS) as f32);
            // The plane may end, or rise to the eye, before the corner.
            let inverse_depth = inverse_depth_per_m[0] + inverse_depth_per_m[1] * du + inverse_depth_per_m[2] * dv;
            let inverse_depth = inverse_depth.clamp(0.5 * at_hit, 2.0 * at_hit);
            let corner = (row + j) * (self.blocks_across + 1) + column + i;
            let key = (corner, instance, bearing, depth_step(inverse_depth) | u32::from(is_flat));
            let slot = corner.wrapping_mul(CORNER_FACTORS[0]) ^ in_cell.wrapping_mul(CORNER_FACTORS[1]);
            let (known, kept) = &mut self.corners[(slot >> SLOT_SHIFT) as usize % CORNER_SLOTS];
            if *known != key {
                let point_world = self.rays.eye + self.rays.direction(u + du, v + dv) * (1.0 / inverse_depth);
                (*known, *kept) = (key, ambient_of(self.light, point_world, normal, is_flat));
            }
            *ambient = *kept;
        }
        let [first, right, below, across] = &mut corners;
        for k in 0..8 {
            let further = across[k] - below[k];
            right[k] -= first[k];
            below[k] -= first[k];
            across[k] = further - right[k];
        }
        self.terms.extend(corners);
        found
    }
}

/// The depth of a plane in steps of 0.02 percent, which leave room for two more bits.
fn depth_step(inverse_depth: f32) -> u32 {
    inverse_depth.to_bits() >> ROUNDED_BITS << 2
}

/// The ambient terms of a point of a surface.
#[inline(always)]
fn ambient_of(light: &Light, point_world: Vec3, normal: Vec3, is_flat: bool) -> AmbientTerms {
    let sky_visibility = light.sky_probes.sky_visibility(point_world, normal);
    let [a, b, c, d, e, f] = sky_visibility;
    if is_flat {
        let ambient = light.sky.ambient(normal, &sky_visibility);
        [ambient.x, ambient.y, ambient.z, a, b, c, d, 0.0]
    } else {
        [a, b, c, d, e, f, 0.0, 0.0]
    }
}
