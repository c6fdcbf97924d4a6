//! Trees and shrubs: trunk, limbs and a crown of leaf clusters with real gaps.

use strum::{AsRefStr, VariantArray};

use std::sync::Arc;

use super::Mesh;
use super::draw::{direction, range};
use super::leaves::Leaves;
use super::materials::plant_slot as slot;
use super::tree_levels::{self, Level};
use cadet_base::geometry::{LazyMesh, LodSet, MeshBuilder};
use cadet_base::math::{Vec3, cosf, sinf};
use cadet_base::rng::Stream;

/// What kind of plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, AsRefStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum TreeKind {
    /// Broad-leaved, 8-14 m, first branch at 2.6 m or more.
    #[strum(serialize = "street-tree")]
    Street,
    /// Broad-leaved or fruit tree of a garden, 4.5-9.5 m.
    #[strum(serialize = "garden-tree")]
    Garden,
    /// A spruce or a cypress, 6-16 m.
    Conifer,
    /// A large tree of a wood's edge, leaves down to the ground.
    #[strum(serialize = "wood-tree")]
    Wood,
    /// A shrub, 0.6-2.5 m.
    Shrub,
}

impl TreeKind {
    /// True for needles: darker palettes.
    #[must_use]
    pub fn is_evergreen(self) -> bool {
        self == Self::Conifer
    }
}

/// A ball of leaves: part of a crown.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blob {
    pub center: Vec3,
    pub radius_m: f32,
}

impl Blob {
    fn volume(&self) -> f32 {
        self.radius_m * self.radius_m * self.radius_m * 4.19
    }
}

/// The drawn measures of one tree.
#[derive(Debug, Clone)]
pub(super) struct TreeDesign {
    pub kind: TreeKind,
    pub height_m: f32,
    pub crown_radius_m: f32,
    pub crown_base_m: f32,
    trunk_radius_m: f32,
    pub blobs: Vec<Blob>,
    seed: u64,
}

/// A crown's extent is measured with so many triangles of leaves, at most.
const MEASURED_LEAVES: f32 = 2600.0;
/// Beside the ego larger cards look like plates, not like leaves.
const LARGEST_M: f32 = 0.3;
/// Leaf area in a crown's cubic meter: with cards turned every way a beam meets half of it, exp(-0.5 x 1.8) = 0.41.
const LEAF_AREA_PER_M3: f32 = 1.8;

impl TreeDesign {
    /// Draws the measures of a variant.
    pub fn new(kind: TreeKind, variant: usize) -> Self {
        let s = &mut Stream::from_seed(kind.as_ref(), variant as u64);
        // From and to: the height, and the crown's radius as a share of it.
        let (heights_m, spread) = match kind {
            TreeKind::Street => ((8.0, 14.0), (0.29, 0.38)),
            TreeKind::Garden => ((4.5, 9.5), (0.30, 0.40)),
            TreeKind::Conifer => ((6.0, 15.0), (0.16, 0.24)),
            TreeKind::Wood => ((10.0, 16.0), (0.30, 0.38)),
            TreeKind::Shrub => ((0.7, 2.4), (0.45, 0.65)),
        };
        let height_m = range(s, heights_m.0, heights_m.1);
        let crown_radius_m = range(s, spread.0, spread.1) * height_m;
        let crown_base_m = match kind {
            TreeKind::Street => range(s, 2.6, 3.6),
            TreeKind::Garden => range(s, 0.25, 0.36) * height_m,
            TreeKind::Conifer => range(s, 0.2, 0.9),
            TreeKind::Wood => range(s, 0.6, 1.4),
            TreeKind::Shrub => 0.0,
        };
        let trunk_radius_m = (0.012 * height_m + 0.03) * range(s, 0.85, 1.3);
        let (blobs, seed) = (Vec::new(), s.next_u64());
        let mut design = Self { kind, height_m, crown_radius_m, crown_base_m, trunk_radius_m, blobs, seed };
        if kind != TreeKind::Conifer {
            design.blobs = design.draw_blobs(s);
        }
        design
    }

    fn draw_blobs(&self, s: &mut Stream) -> Vec<Blob> {
        let crown_height = self.height_m - self.crown_base_m;
        let middle = Vec3::Z * (self.crown_base_m + crown_height * 0.5);
        let half = Vec3::new(self.crown_radius_m, self.crown_radius_m, crown_height * 0.5);
        let count = if self.kind == TreeKind::Shrub { 4 } else { 8 + s.below(6) };
        let mut blobs = vec![Blob { center: middle, radius_m: half.min_element() * 0.62 }];
        for k in 0..count {
            let radius_m = half.min_element() * range(s, 0.34, 0.55);
            // Spread by the golden angle, so that no side stays bare.
            let a = 2.399_963 * k as f32 + range(s, -0.4, 0.4);
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / count as f32;
            let r = (1.0 - z * z).sqrt();
            let reach = (half - Vec3::splat(radius_m * 0.9)).max(Vec3::splat(0.1));
            blobs.push(Blob { center: middle + Vec3::new(r * cosf(a), r * sinf(a), z) * reach, radius_m });
        }
        blobs
    }

    /// The tree, each level made when it is needed.
    pub fn shape(self) -> LodSet {
        let levels = match self.kind {
            TreeKind::Shrub => tree_levels::of_shrub(),
            // Towards the tip large cards are cut down to fit, and the trunk would show.
            TreeKind::Conifer => tree_levels::of_tree(16_800.0, |leaves| {
                let width_m = self.card_width_m(leaves);
                width_m * (width_m / (0.2 * self.crown_radius_m)).max(1.0)
            }),
            _ => {
                let mut most = 20_800.0;
                while self.card_width_m(most) > LARGEST_M {
                    most *= 2.0;
                }
                tree_levels::of_tree(most, |leaves| self.card_width_m(leaves))
            }
        };
        // The finest ones are for the few trees beside the ego.
        let measured =
            levels.iter().position(|level| level.leaf_triangles <= MEASURED_LEAVES).unwrap_or(levels.len() - 1);
        let (mesh, design) = (self.mesh(&levels[measured]), Arc::new(self));
        let bounds = mesh.bounds;
        let mut levels: Vec<(f32, LazyMesh)> = levels
            .into_iter()
            .map(|level| {
                let design = Arc::clone(&design);
                (level.to_m, LazyMesh::new(move || design.mesh(&level)))
            })
            .collect();
        levels[measured].1 = LazyMesh::new(|| mesh);
        LodSet { bounds, levels, coarse_shadow_proxies: 0 }
    }

    /// Area of all leaves, m^2.
    fn leaf_area(&self) -> f32 {
        let (volume, share) = match self.kind {
            TreeKind::Conifer => {
                let span = self.height_m - self.crown_base_m;
                (1.05 * self.crown_radius_m * self.crown_radius_m * span, 1.9)
            }
            // Blobs overlap, so the area is spread over less than the sum of their volumes.
            kind => (self.blobs.iter().map(Blob::volume).sum(), if kind == TreeKind::Shrub { 3.0 } else { 0.8 }),
        };
        volume * LEAF_AREA_PER_M3 * share
    }

    /// The side of a square as large as a card, which is two triangles, if there are so many of them.
    fn card_width_m(&self, leaves: f32) -> f32 {
        let smallest: f32 = match self.kind {
            TreeKind::Conifer => 0.12,
            TreeKind::Shrub => 0.09,
            _ => 0.13,
        };
        (2.0 * self.leaf_area() / leaves).sqrt().max(smallest)
    }

    /// A card's width, and how many cards there are.
    fn cards(&self, level: &Level) -> (f32, usize) {
        let size = self.card_width_m(level.leaf_triangles);
        let triangles = ((2.0 * self.leaf_area() / (size * size)) as usize).min(level.leaf_triangles as usize);
        (size, triangles / 2)
    }

    fn mesh(&self, level: &Level) -> Mesh {
        let mut wood = MeshBuilder::new();
        let mut leaves = Leaves::default();
        let mut s = Stream::from_seed("crown", self.seed);
        match self.kind {
            TreeKind::Conifer => self.conifer(&mut wood, &mut leaves, &mut s, level),
            _ => self.broad_leaved(&mut wood, &mut leaves, &mut s, level),
        }
        leaves.build(self.kind.as_ref(), &wood)
    }

    fn broad_leaved(&self, wood: &mut MeshBuilder, leaves: &mut Leaves, s: &mut Stream, level: &Level) {
        let sides = level.sides;
        let fork = self.crown_base_m + (self.height_m - self.crown_base_m) * 0.35;
        if self.kind == TreeKind::Shrub {
            let top = Vec3::Z * self.height_m * 0.6;
            wood.tube(&[(Vec3::Z * -0.2, 0.03), (top, 0.015)], 3, slot::BARK);
        } else {
            let lean = direction(s) * self.height_m * 0.02;
            let bend = |z: f32| Vec3::new(lean.x, lean.y, 0.0) * (z / self.height_m) + Vec3::Z * z;
            let r = self.trunk_radius_m;
            let stations =
                [(bend(-0.4), r * 1.35), (bend(0.25), r * 1.08), (bend(fork * 0.6), r * 0.85), (bend(fork), r * 0.6)];
            if level.is_bent {
                wood.tube(&stations, sides, slot::BARK);
            } else {
                wood.tube(&[stations[0], stations[3]], sides, slot::BARK);
            }
            for blob in self.blobs.iter().take(level.limbs) {
                let start = bend(fork * range(s, 0.72, 0.98));
                let knee = start.lerp(blob.center, 0.5) + Vec3::Z * 0.25;
                wood.tube(&[(start, r * 0.45), (knee, r * 0.3), (blob.center, r * 0.1)], 5, slot::BARK);
            }
        }
        let (size, count) = self.cards(level);
        let per_cluster = level.per_cluster;
        let middle = Vec3::Z * (self.crown_base_m + self.height_m) * 0.5;
        let clusters = count.div_ceil(per_cluster);
        let volume: f32 = self.blobs.iter().map(Blob::volume).sum();
        // Each blob gets its share to one cluster: drawn by chance, some would hang in the air as a few leaves.
        let (mut blobs, mut filled) = (self.blobs.iter().peekable(), 0.0);
        for k in 0..clusters {
            let at = (k as f32 + 0.5) / clusters as f32 * volume;
            while let Some(blob) = blobs.next_if(|blob| filled + blob.volume() < at) {
                filled += blob.volume();
            }
            let blob = blobs.peek().copied().or(self.blobs.last()).expect("a crown has blobs");
            // Cubic root for an even fill, a little denser at the outside where the light is.
            let rho = cadet_base::math::powf(s.unit() as f32, 0.28);
            let out = direction(s);
            let spread = (0.9 * size * (per_cluster as f32).sqrt() * 0.5).min(blob.radius_m * 0.4);
            let cluster = blob.center + out * (blob.radius_m * rho);
            for _ in 0..per_cluster {
                let p = cluster + direction(s) * (spread * range(s, 0.2, 1.0));
                let p = p.max(Vec3::new(f32::NEG_INFINITY, f32::NEG_INFINITY, 0.03));
                let outward = ((p - blob.center).normalize_or(Vec3::Z) + (p - middle).normalize_or(Vec3::Z)) * 0.5
                    + Vec3::Z * 0.15;
                let facing = direction(s);
                let within = (blob.center, blob.radius_m * 1.08);
                leaves.card_within(s, p, facing, outward, size, within, self.openness(p));
            }
        }
    }

    /// How open to the sky a place of a broad crown is, 0 to 1: half by its height, half by how far out it is.
    fn openness(&self, p: Vec3) -> f32 {
        let half_height = 0.5 * (self.height_m - self.crown_base_m);
        let z = (p.z - self.crown_base_m - half_height) / half_height;
        let out = Vec3::new(p.x / self.crown_radius_m, p.y / self.crown_radius_m, z).length_squared();
        (0.5 * out + 0.25 * (1.0 + z)).clamp(0.0, 1.0)
    }

    fn conifer(&self, wood: &mut MeshBuilder, leaves: &mut Leaves, s: &mut Stream, level: &Level) {
        let foot = (Vec3::new(0.0, 0.0, -0.4), self.trunk_radius_m * 1.2);
        wood.tube(&[foot, (Vec3::Z * self.height_m * 0.95, 0.02)], level.sides, slot::BARK);
        let span = self.height_m - self.crown_base_m;
        let (size, count) = self.cards(level);
        let layers = (span / 0.55).ceil();
        for _ in 0..count {
            // A cone has most of its volume low; layers droop outwards.
            let t = 1.0 - cadet_base::math::powf(s.unit() as f32, 0.45);
            let t = ((t * layers).floor() + range(s, 0.15, 0.85)) / layers;
            let reach = self.crown_radius_m * (1.0 - t) * range(s, 0.82, 1.05);
            let rho = reach * s.unit().sqrt() as f32;
            let a = range(s, 0.0, std::f32::consts::TAU);
            let out = Vec3::new(cosf(a), sinf(a), 0.0);
            let droop = 0.35 * rho * rho / self.crown_radius_m.max(0.1);
            let z = (self.crown_base_m + t * span - droop).max(0.05);
            let facing = (direction(s) + Vec3::Z * 0.6 + out * 0.3).normalize_or(Vec3::Z);
            let within = (Vec3::Z * z, self.crown_radius_m * (1.0 - t) * 1.08 + 0.12);
            let openness = 0.7 * (rho / reach.max(0.05)).min(1.0) + 0.3 * t;
            leaves.card_within(s, out * rho + Vec3::Z * z, facing, out + Vec3::Z * 0.45, size, within, openness);
        }
    }
}
