//! What grows beside country roads: tall grass and herbs of the verges, rows of maize.

use super::draw::{direction, range};
use super::leaves::Leaves;
use super::materials::{herbs_palette, maize_palette, plant_slot as slot};
use super::{Detail, Mesh, SceneryModel};
use cadet_base::geometry::{Memo, MeshBuilder};
use cadet_base::math::Vec3;
use cadet_base::rng::Stream;

/// How many variants of each there are.
pub const CROP_VARIANTS: usize = 4;
/// Length of a patch of herbs, and how far it reaches to both sides.
pub const HERBS_M: (f64, f64) = (2.4, 0.55);
/// Length of a piece of a row of maize, and how far it reaches to both sides.
pub const MAIZE_M: (f64, f64) = (2.4, 0.45);
/// Height of the herbs of each variant.
const HERB_HEIGHTS_M: [f32; CROP_VARIANTS] = [0.28, 0.38, 0.5, 0.68];
/// Width of all blades of a patch together.
const BLADES_WIDTH_M: f32 = 10.0;
/// Height up to which a row of maize can't be looked through, and of its highest leaves.
const MAIZE_DENSE_M: f32 = 1.55;
const MAIZE_TOP_M: (f32, f32) = (2.1, 2.65);

/// A patch of tall grass and herbs along +x, y = 0 its middle.
#[must_use]
pub fn herbs(variant: usize) -> SceneryModel {
    static MODELS: Memo<usize, SceneryModel> = Memo::new();
    let variant = variant % CROP_VARIANTS;
    MODELS.get(variant, || {
        let palette = herbs_palette(&mut Stream::from_seed("herbs", variant as u64));
        let shape = Detail::levels([12.0, 28.0, 75.0], move |d| herbs_mesh(variant, d));
        SceneryModel::along_x(format!("herbs/{variant}"), shape, palette, HERBS_M, HERB_HEIGHTS_M[variant].into())
    })
}

/// A piece of a row of maize along +x, y = 0 its middle.
#[must_use]
pub fn maize(variant: usize) -> SceneryModel {
    static MODELS: Memo<usize, SceneryModel> = Memo::new();
    let variant = variant % CROP_VARIANTS;
    MODELS.get(variant, || {
        let palette = maize_palette(&mut Stream::from_seed("maize", variant as u64));
        let shape = Detail::levels([18.0, 40.0, 180.0], move |d| maize_mesh(variant, d));
        SceneryModel::along_x(format!("maize/{variant}"), shape, palette, MAIZE_M, MAIZE_TOP_M.1.into())
    })
}

/// Blades in clumps, with a few broad leaves between.
fn herbs_mesh(variant: usize, detail: Detail) -> Mesh {
    let s = &mut Stream::from_seed("herbs mesh", variant as u64);
    let (length, half, height) = (HERBS_M.0 as f32, HERBS_M.1 as f32, HERB_HEIGHTS_M[variant]);
    // The same covered share at every level: fewer blades, as much wider.
    let num_blades: usize = detail.pick(420, 150, 50);
    let width = BLADES_WIDTH_M / num_blades as f32;
    let clumps: Vec<(f32, f32, f32)> =
        (0..9).map(|_| (range(s, 0.0, length), range(s, -half, half), range(s, 0.35, 1.0))).collect();
    let mut leaves = Leaves::default();
    for blade in 0..num_blades {
        let (x, y, tall) = clumps[s.below(clumps.len())];
        let at = |s: &mut Stream, within: f32| {
            let (dx, dy) = (range(s, -within, within), range(s, -within, within));
            Vec3::new((x + dx).clamp(0.0, length), (y + dy).clamp(-half, half), 0.0)
        };
        let foot = at(s, 0.24);
        let reach = height * tall * range(s, 0.5, 1.0);
        let lean = direction(s) * (0.4 * reach);
        let outward = Vec3::Z + direction(s) * 0.5;
        if blade % 7 == 0 {
            let middle = foot + Vec3::Z * (0.6 * reach);
            let facing = direction(s);
            leaves.card(s, middle, facing, outward, 1.3 * width.max(0.045));
        } else {
            leaves.blade(s, foot - Vec3::Z * 0.06, foot + lean + Vec3::Z * reach, width, outward);
        }
    }
    leaves.build("herbs", &MeshBuilder::new())
}

/// A dark inside that nobody sees through, and long leaves all over it and above.
fn maize_mesh(variant: usize, detail: Detail) -> Mesh {
    let s = &mut Stream::from_seed("maize mesh", variant as u64);
    let (length, half) = (MAIZE_M.0 as f32, MAIZE_M.1 as f32);
    let mut core = MeshBuilder::new();
    core.cuboid(Vec3::new(0.0, -half * 0.35, -0.2), Vec3::new(length, half * 0.35, MAIZE_DENSE_M), slot::DARK_LEAF);
    let size: f32 = detail.pick(0.16, 0.26, 0.6);
    let coverage: f32 = detail.pick(1.5, 1.3, 0.8);
    let plants: Vec<(f32, f32)> =
        (0..13).map(|i| (length * (i as f32 + 0.5) / 13.0, range(s, MAIZE_TOP_M.0, MAIZE_TOP_M.1))).collect();
    let mut leaves = Leaves::default();
    for _ in 0..(coverage * 2.0 * length * MAIZE_TOP_M.1 / (size * size)) as usize {
        let (x, top) = plants[s.below(plants.len())];
        let side = if s.chance(0.5) { 1.0 } else { -1.0 };
        let z = range(s, 0.1, top);
        // Leaves hang out farthest halfway up.
        let reach = half * (1.0 - (2.0 * z / top - 1.0).abs() * 0.55);
        let p = Vec3::new((x + range(s, -0.14, 0.14)).clamp(0.0, length), side * range(s, 0.25, 1.0) * reach, z);
        let facing = (direction(s) + Vec3::Y * (0.6 * side)).normalize_or(Vec3::Y);
        leaves.card(s, p, facing, Vec3::Y * side + Vec3::Z * 0.4, size);
    }
    leaves.build("maize", &core)
}
