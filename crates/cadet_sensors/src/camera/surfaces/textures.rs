//! Procedural textures: the few patterns of a street, faded where a pixel can't hold them.
//!
//! Contrasts are shares of the albedo, lengths meters, frequencies cells of noise per meter. They were fitted by eye and to the
//! local contrast of KITTI's frames (docs/measurements/fidelity.md).

use super::value_noise::{centered, grain, hash2, split, unit, value_noise};
use cadet_base::material::Pattern;
use cadet_base::math::Vec3;
use cadet_base::road_paint::WornPaint;

/// Where a pattern is evaluated.
#[derive(Debug, Clone, Copy)]
pub struct PatternPoint {
    /// Along the surface: world x and y on the ground, else meters along and up a wall.
    pub u: f32,
    /// See `u`.
    pub v: f32,
    /// Size of a pixel on the surface, meters (the geometric mean of its two extents).
    pub footprint_m: f32,
    /// Width of a pixel there square to the view, meters.
    pub pixel_m: f32,
    /// Hash of the face, for what varies leaf by leaf.
    pub face_hash: u32,
    /// Hash of the instance's place, for what varies tree by tree.
    pub place_hash: u32,
}

/// A feature is drawn in full where it spans so many pixels and 1 / [`KEEP_RISE`], and not at all where it spans fewer.
const KEEP_FROM_PX: f32 = 0.7;
const KEEP_RISE: f32 = 0.8;

/// 1 where a feature of `size_m` spans pixels enough to be drawn, 0 where it would flicker.
#[inline(always)]
fn keep(size_m: f32, footprint_m: f32) -> f32 {
    ((size_m / footprint_m - KEEP_FROM_PX) * KEEP_RISE).clamp(0.0, 1.0)
}

/// Patches, stains, and dirt: value noise about 0.
struct Mottle {
    contrast: f32,
    /// Along u and along v.
    cells_per_m: [f32; 2],
    /// Of u, in cells: two mottles of one surface have their nodes in different places.
    shift: Option<f32>,
    salt: u32,
}

impl Mottle {
    const fn even(contrast: f32, cells_per_m: f32, salt: u32) -> Self {
        Self::stretched(contrast, [cells_per_m; 2], salt)
    }

    const fn stretched(contrast: f32, cells_per_m: [f32; 2], salt: u32) -> Self {
        Self { contrast, cells_per_m, shift: None, salt }
    }

    /// Noise in [0, 1).
    #[inline(always)]
    fn noise(&self, u: f32, v: f32) -> f32 {
        let x = u * self.cells_per_m[0];
        let x = if let Some(shift) = self.shift { x + shift } else { x };
        value_noise(x, v * self.cells_per_m[1], self.salt)
    }

    #[inline(always)]
    fn at(&self, u: f32, v: f32) -> f32 {
        self.contrast * (self.noise(u, v) - 0.5)
    }
}

/// Grain that is as fine as the pixels.
struct Grain {
    contrast: f32,
    finest_m: f32,
    salt: u32,
}

impl Grain {
    #[inline(always)]
    fn at(&self, u: f32, v: f32, pixel_m: f32) -> f32 {
        self.contrast * grain(u, v, pixel_m, self.finest_m, self.salt)
    }
}

/// Stones or tiles in rows.
struct Courses {
    length_m: f32,
    width_m: f32,
    joint_m: f32,
    /// Every other row is shifted by half a stone.
    is_running: bool,
}

/// A joint thinner than this share of the pixel darkens by its share of the pixel.
const JOINT_PER_PIXEL: f32 = 0.7;
const STONE_SALT: u32 = 0x57A1;

impl Courses {
    /// A stone's hash and the darkening of the joints.
    #[inline(always)]
    fn at(&self, u: f32, v: f32, footprint_m: f32) -> (u32, f32) {
        let &Self { length_m, width_m, joint_m, is_running } = self;
        let (row, in_row) = split(v * (1.0 / width_m));
        let shift = if is_running && row & 1 == 1 { 0.5 } else { 0.0 };
        let (column, in_column) = split(u * (1.0 / length_m) + shift);
        let (du, dv) = (in_column * length_m, in_row * width_m);
        let edge = du.min(length_m - du).min(dv.min(width_m - dv));
        let soft = joint_m.max(footprint_m * JOINT_PER_PIXEL);
        let line = (1.0 - edge / soft).clamp(0.0, 1.0) * (joint_m / soft).min(1.0);
        (hash2(column, row, STONE_SALT), line * keep(width_m, footprint_m))
    }
}

/// The albedo of a pattern at a point.
#[inline(always)]
#[must_use]
pub fn albedo(pattern: Pattern, base: Vec3, at: &PatternPoint) -> Vec3 {
    match pattern {
        Pattern::Plain | Pattern::Lamp | Pattern::Reflector | Pattern::Window => base,
        Pattern::Asphalt => asphalt(base, at),
        Pattern::Slabs => paving(&SLABS, base, at),
        Pattern::Blocks => paving(&BLOCKS, base, at),
        Pattern::Bricks => bricks(base, at),
        Pattern::Render => render(base, at),
        Pattern::Tiles => tiles(base, at),
        Pattern::Grass => grass(base, at),
        Pattern::Leaves => leaves(base, at),
        Pattern::Wood => wood(base, at),
        Pattern::Cloth => cloth(base, at),
        Pattern::Paint => paint(base, at),
    }
}

const ASPHALT_GRAIN: Grain = Grain { contrast: 0.60, finest_m: 0.008, salt: 0xA5F1 };
/// Width of the pixels that average half of the stones' contrast away, meters.
const ASPHALT_AVERAGED_M: f32 = 0.04;
const ASPHALT_PATCHES: Mottle = Mottle::even(0.16, 0.45, 7);
const ASPHALT_PATCH_M: f32 = 2.2;
const ASPHALT_SPOTS: Mottle = Mottle { contrast: 0.09, cells_per_m: [1.9, 1.9], shift: Some(3.3), salt: 8 };
const ASPHALT_SPOT_M: f32 = 0.5;
/// Lighter stretches are warmer: red over blue from 0.94 to 1.06.
const ASPHALT_STRETCHES: Mottle = Mottle::even(0.16, 0.06, 9);
const ASPHALT_WARMTH: f32 = 0.4;

#[inline(always)]
fn asphalt(base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px, fine) = (at.u, at.v, at.footprint_m, at.pixel_m);
    // Far stones are averaged, but patches of them remain.
    let Grain { contrast, finest_m, salt } = ASPHALT_GRAIN;
    let grain = contrast / (1.0 + fine * (1.0 / ASPHALT_AVERAGED_M)) * grain(u, v, fine, finest_m, salt);
    let stretch = ASPHALT_STRETCHES.at(u, v);
    let patches = ASPHALT_PATCHES.at(u, v) * keep(ASPHALT_PATCH_M, px)
        + ASPHALT_SPOTS.at(u, v) * keep(ASPHALT_SPOT_M, px)
        + stretch;
    let tint = Vec3::new(1.0 + ASPHALT_WARMTH * stretch, 1.0, 1.0 - ASPHALT_WARMTH * stretch);
    base * tint * (1.0 + grain + patches)
}

/// Where paint has gone: noise in two sizes, cells per meter and share of the finer one; how soft the edges are.
const COARSE_GONE_PER_M: f32 = 7.0;
const FINE_GONE_PER_M: f32 = 26.0;
const GONE_FINE: f32 = 0.45;
const GONE_SALT: u32 = 0x9A17;
const GONE_SOFT: f32 = 0.22;
const GONE_PATCH_M: f32 = 0.07;
const PAINT_DIRT: Mottle = Mottle::even(0.16, 2.3, 0x9A18);

/// The noise above which paint is left so that a share of it is: that of a bell about one half.
#[inline(always)]
fn gone_below(left: f32) -> f32 {
    let d = left - 0.5;
    0.5 - 0.14 * (2.4 * d + 6.0 * d * d * d)
}

#[inline(always)]
fn paint(base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v) = (at.u, at.v);
    let WornPaint { left_share: left, asphalt_albedo: asphalt } = WornPaint::of_albedo(base);
    let coarse = value_noise(u * COARSE_GONE_PER_M, v * COARSE_GONE_PER_M, GONE_SALT);
    let fine = value_noise(u * FINE_GONE_PER_M, v * FINE_GONE_PER_M, GONE_SALT + 1);
    let noise = coarse + (fine - coarse) * GONE_FINE;
    let here = ((noise - gone_below(left)) * (1.0 / GONE_SOFT) + 0.5).clamp(0.0, 1.0);
    let here = left + (here - left) * keep(GONE_PATCH_M, at.footprint_m);
    let under = Vec3::splat(asphalt);
    let fresh = under + (base - under) * (1.0 / left);
    (under + (fresh - under) * here) * (1.0 + PAINT_DIRT.at(u, v))
}

const SLABS: Courses = Courses { length_m: 0.40, width_m: 0.40, joint_m: 0.006, is_running: true };
const BLOCKS: Courses = Courses { length_m: 0.20, width_m: 0.10, joint_m: 0.006, is_running: true };
const PAVING_EACH: f32 = 0.13;
const PAVING_DIRT: Mottle = Mottle::even(0.30, 1.7, 21);
const PAVING_GRAIN: Grain = Grain { contrast: 0.21, finest_m: 0.008, salt: 22 };
const PAVING_JOINT: f32 = 0.55;

#[inline(always)]
fn paving(stones: &Courses, base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px, fine) = (at.u, at.v, at.footprint_m, at.pixel_m);
    let (stone, line) = stones.at(u, v, px);
    let each = PAVING_EACH * centered(stone) * keep(stones.width_m, px);
    let dirt = PAVING_DIRT.at(u, v) + PAVING_GRAIN.at(u, v, fine);
    base * ((1.0 + each + dirt) * (1.0 - PAVING_JOINT * line))
}

const BRICKS: Courses = Courses { length_m: 0.25, width_m: 0.077, joint_m: 0.010, is_running: true };
const BRICK_EACH: f32 = 0.18;
const BRICK_GRAIN: Grain = Grain { contrast: 0.22, finest_m: 0.008, salt: 31 };
/// Mortar has so much of the bricks' albedo, and so much of its own.
const MORTAR_OF_BRICK: f32 = 0.3;
const MORTAR_ALBEDO: f32 = 0.25;
const MORTAR_COVER: f32 = 0.8;

#[inline(always)]
fn bricks(base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px, fine) = (at.u, at.v, at.footprint_m, at.pixel_m);
    let (stone, line) = BRICKS.at(u, v, px);
    let each = BRICK_EACH * centered(stone) * keep(BRICKS.width_m, px);
    let mortar = base * MORTAR_OF_BRICK + Vec3::splat(MORTAR_ALBEDO);
    let brick = base * (1.0 + each + BRICK_GRAIN.at(u, v, fine));
    brick + (mortar - brick) * (MORTAR_COVER * line)
}

/// Stains run down a wall: stretched noise.
const STREAKS: Mottle = Mottle::stretched(0.16, [2.9, 0.5], 41);
const STREAK_M: f32 = 0.34;
/// Rain splashes soil on a wall's foot: how dark, how fast that ends upwards (1/m), and how much of it even without streaks.
const SPLASH: f32 = 0.30;
const SPLASH_PER_M: f32 = 0.9;
const SPLASH_EVEN: f32 = 0.6;
/// The trowel leaves it uneven, over so many pixels at any distance; sand is finer.
const TROWEL_GRAIN: Grain = Grain { contrast: 0.08, finest_m: 0.05, salt: 42 };
const TROWEL_PX: f32 = 3.0;
const SAND_GRAIN: Grain = Grain { contrast: 0.11, finest_m: 0.006, salt: 43 };

#[inline(always)]
fn render(base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px, fine) = (at.u, at.v, at.footprint_m, at.pixel_m);
    let streak = STREAKS.noise(u, v) - 0.5;
    let stains = STREAKS.contrast * streak * keep(STREAK_M, px);
    let low = (1.0 - v * SPLASH_PER_M).clamp(0.0, 1.0);
    let splashed = SPLASH * low * low * (SPLASH_EVEN + streak);
    let uneven = TROWEL_GRAIN.at(u, v, TROWEL_PX * fine);
    base * (1.0 + stains - splashed + uneven + SAND_GRAIN.at(u, v, fine))
}

/// A tile's visible length down the roof and its width.
const TILE_M: f32 = 0.33;
const TILE_WIDTH_M: f32 = 0.22;
const TILE_EACH: f32 = 0.16;
const TILE_EACH_M: f32 = 0.25;
const TILE_SALT: u32 = 51;
/// The shadow below the upper row's edge.
const TILE_SHADOW_M: f32 = 0.03;
const TILE_SHADOW: f32 = 0.6;
/// How much the arch of a tile brightens its middle over its mean, a parabola's two thirds.
const TILE_ROLL: f32 = 0.25;
const TILE_ROLL_MEAN: f32 = 0.66;
const MOSS: Mottle = Mottle::stretched(0.24, [0.5, 0.35], 52);
const TILE_GRAIN: Grain = Grain { contrast: 0.22, finest_m: 0.01, salt: 53 };

#[inline(always)]
fn tiles(base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px, fine) = (at.u, at.v, at.footprint_m, at.pixel_m);
    let (row, in_row) = split(v * (1.0 / TILE_M));
    let dv = in_row * TILE_M;
    let (column, du) = split(u * (1.0 / TILE_WIDTH_M));
    let each = TILE_EACH * centered(hash2(column, row, TILE_SALT)) * keep(TILE_EACH_M, px);
    let soft = (px * JOINT_PER_PIXEL).max(TILE_SHADOW_M);
    let shadow = (1.0 - dv / soft).clamp(0.0, 1.0) * (TILE_SHADOW_M / soft).min(1.0) * TILE_SHADOW;
    let roll = TILE_ROLL * (du * (1.0 - du) * 4.0 - TILE_ROLL_MEAN) * keep(TILE_WIDTH_M, px);
    let rough = TILE_GRAIN.at(u, v, fine);
    base * ((1.0 + each + roll + MOSS.at(u, v) + rough) * (1.0 - shadow))
}

const BLADES: Grain = Grain { contrast: 0.55, finest_m: 0.008, salt: 61 };
/// Bundles of blades, so much coarser.
const BUNDLES: Grain = Grain { contrast: 0.35, finest_m: 0.04, salt: 64 };
const BUNDLES_COARSER: f32 = 0.37;
const TUFTS: Mottle = Mottle::even(0.7, 4.1, 62);
const TUFT_M: f32 = 0.25;
/// Patches that dry out are yellower and lighter.
const DRY: Mottle = Mottle::even(0.9, 0.8, 63);
const DRY_M: f32 = 1.2;
const GRASS_RED: f32 = 0.96;
const DRY_RED: f32 = 0.45;
const GRASS_BLUE: f32 = 1.25;
const DRY_BLUE: f32 = 0.2;
const DARKEST_GRASS: f32 = 0.15;

#[inline(always)]
fn grass(base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px, fine) = (at.u, at.v, at.footprint_m, at.pixel_m);
    let blades = BLADES.at(u, v, fine) + BUNDLES.at(u * BUNDLES_COARSER, v * BUNDLES_COARSER, px);
    let tufts = TUFTS.at(u, v) * keep(TUFT_M, px);
    let dry = DRY.noise(u, v);
    let tint = Vec3::new(GRASS_RED + DRY_RED * dry * dry, 1.0, GRASS_BLUE - DRY_BLUE * dry);
    base * tint * (1.0 + blades + tufts + DRY.contrast * (dry - 0.5) * keep(DRY_M, px)).max(DARKEST_GRASS)
}

/// How bright a card of leaves is: least, and by its hash.
const CARD_LEAST: f32 = 0.70;
const CARD_RANGE: f32 = 0.75;
/// A card holds many leaves, a few of them bright before the shade between them.
const LEAF_GRAIN_FINEST_M: f32 = 0.035;
const LEAF_GRAIN_PX: f32 = 1.7;
const LEAF_SHADE: f32 = 0.38;
const LEAF_BRIGHT: f32 = 1.9;
/// Cards above this rank among their tree's are the yellower.
const YELLOW_FROM: f32 = 0.55;
/// Red, green, and blue: of all leaves, by the tree, and by how yellow the card is.
const LEAF_TINT: [f32; 3] = [0.85, 0.95, 1.12];
const TREE_RED: f32 = 0.4;
const TREE_BLUE: f32 = 0.2;
const YELLOW_RED: f32 = 0.5;
const YELLOW_GREEN: f32 = 0.25;
const LOW_BYTE: u32 = 0xFF;

#[inline(always)]
fn leaves(base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px) = (at.u, at.v, at.footprint_m);
    let (leaf, tree) = (unit(at.face_hash), unit(at.place_hash));
    let yellow = ((at.face_hash & LOW_BYTE) as i32 as f32 / LOW_BYTE as f32 - YELLOW_FROM).max(0.0);
    let card = CARD_LEAST + CARD_RANGE * leaf * leaf;
    let grain = grain(u, v, LEAF_GRAIN_PX * px, LEAF_GRAIN_FINEST_M, at.face_hash | 1);
    let bright = (0.5 + 1.0 * grain).clamp(0.0, 1.0);
    let inside = LEAF_SHADE + LEAF_BRIGHT * bright * bright;
    let [red, green, blue] = LEAF_TINT;
    let tint =
        Vec3::new(red + TREE_RED * tree + YELLOW_RED * yellow, green + YELLOW_GREEN * yellow, blue + TREE_BLUE * tree);
    base * tint * (card * inside)
}

const FIBERS: Mottle = Mottle::stretched(0.30, [14.0, 1.2], 71);
const FIBER_M: f32 = 0.07;
const BOARD_M: f32 = 0.12;
const BOARD_EACH: f32 = 0.15;
const BOARD_SALT: u32 = 72;
const WOOD_GRAIN: Grain = Grain { contrast: 0.20, finest_m: 0.006, salt: 73 };

#[inline(always)]
fn wood(base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px, fine) = (at.u, at.v, at.footprint_m, at.pixel_m);
    let fibers = FIBERS.at(u, v) * keep(FIBER_M, px);
    let board = BOARD_EACH * centered(hash2(split(u * (1.0 / BOARD_M)).0, 0, BOARD_SALT)) * keep(BOARD_M, px);
    base * (1.0 + fibers + board + WOOD_GRAIN.at(u, v, fine))
}

const FOLDS: Mottle = Mottle::stretched(0.30, [9.0, 4.0], 81);
const FOLD_M: f32 = 0.1;
const CLOTH_GRAIN: Grain = Grain { contrast: 0.10, finest_m: 0.006, salt: 82 };

#[inline(always)]
fn cloth(base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px, fine) = (at.u, at.v, at.footprint_m, at.pixel_m);
    base * (1.0 + FOLDS.at(u, v) * keep(FOLD_M, px) + CLOTH_GRAIN.at(u, v, fine))
}

#[cfg(test)]
mod tests {
    use strum::VariantArray;

    use super::*;

    fn statistics(pattern: Pattern, footprint_m: f32) -> (f32, f32) {
        let n = 160;
        let mut values = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let (u, v) = (i as f32 * footprint_m, j as f32 * footprint_m);
                let hash = hash2(i / 3, j / 3, 5);
                let at = PatternPoint { u, v, footprint_m, pixel_m: footprint_m, face_hash: hash, place_hash: 77 };
                values.push(albedo(pattern, Vec3::splat(0.5), &at).y);
            }
        }
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        let var = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / values.len() as f32;
        (mean / 0.5, var.sqrt() / mean)
    }

    #[test]
    fn patterns_keep_their_mean_albedo_near_and_far() {
        for &pattern in Pattern::VARIANTS {
            for footprint in [0.004, 0.03, 0.3] {
                let (mean, spread) = statistics(pattern, footprint);
                assert!((0.78..1.22).contains(&mean), "{pattern:?} at {footprint}: mean {mean}");
                assert!(spread < 0.75, "{pattern:?} at {footprint}: spread {spread}");
            }
        }
    }

    #[test]
    fn asphalt_has_the_grain_that_was_measured() {
        for footprint in [0.008, 0.02, 0.06] {
            let (_, spread) = statistics(Pattern::Asphalt, footprint);
            // Before lens and sensor; what is left of it in pictures is tested on them.
            assert!((0.10..0.24).contains(&spread), "{footprint}: {spread}");
        }
    }
}
