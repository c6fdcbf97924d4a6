//! Lit panes at night: which of them are, and what they show.

use super::textures::PatternPoint;
use super::value_noise::{hash2, unit, value_noise};
use cadet_base::math::Vec3;

/// Where windows are known by their middles, meters: the same in all levels of detail.
const PLACES_PER_M: f32 = 4.0;
/// Longer diagonals are those of shop windows.
const SHOP_FROM_M: f32 = 2.45;
const SHOP_FLAG: u32 = 1 << 31;
/// Light of homes and of shops, of luma 1; of screens.
const WARM: Vec3 = Vec3::new(1.42, 0.93, 0.42);
const COOL: Vec3 = Vec3::new(1.04, 1.0, 0.86);
const SCREEN: Vec3 = Vec3::new(0.35, 0.45, 0.75);
const SCREEN_SHARE: f32 = 0.08;
/// Shares of curtains that are drawn, and what comes through them.
const CURTAIN_SHARE: f32 = 0.45;
const CURTAIN: f32 = 0.4;
/// From the least to the greatest radiance of rooms, times the mean.
const LEAST: f32 = 0.25;
const RANGE: f32 = 1.9;
/// The wall behind a window is brighter toward the lamp at the ceiling: by the meter.
const RISE_PER_M: f32 = 0.5;
const FOLDS_PER_M: f32 = 7.0;
/// What stands in rooms and behind shop windows: cells of noise per meter, and how dark it is.
const THINGS_PER_M: f32 = 2.2;
const THINGS: f32 = 0.85;
const SHELVES_PER_M: [f32; 2] = [1.1, 2.7];

/// A window's number and the middle of its pane, in its mesh's frame, by the corners of a half of it.
#[inline]
pub(crate) fn window([a, b, c]: [Vec3; 3], normal: Vec3, place_hash: u32) -> (u32, Vec3) {
    // The halves of a rectangle share its diagonal, the longest edge.
    let longest = |[a, b]: [Vec3; 2], [c, d]: [Vec3; 2]| {
        if (b - a).length_squared() >= (d - c).length_squared() { [a, b] } else { [c, d] }
    };
    let [from, to] = longest(longest([a, b], [b, c]), [c, a]);
    let middle = (from + to) * 0.5;
    // Panes lie at other depths in other levels of detail.
    let flat = middle - normal * middle.dot(normal);
    let key = (flat * PLACES_PER_M + Vec3::splat(0.31)).floor();
    let hash = hash2(key.x as i32 ^ (key.z as i32).wrapping_mul(0x3D4D), key.y as i32, place_hash);
    let is_shop = (to - from).length() > SHOP_FROM_M;
    (hash & !SHOP_FLAG | if is_shop { SHOP_FLAG } else { 0 }, middle)
}

/// Radiance of a pane; `u` and `v` of the point are meters from its middle, `window` is the material's albedo
/// ([`cadet_base::material::Pattern::Window`]).
#[inline(always)]
pub(crate) fn radiance(window: Vec3, at: &PatternPoint) -> Vec3 {
    let hash = at.face_hash;
    let [lit, kind, level, tint] = [1, 2, 3, 4].map(|salt| unit(hash2(hash as i32, salt, 0x1417)));
    if window.x > 1.0 {
        return COOL * window.y;
    }
    if hash & SHOP_FLAG != 0 {
        // Shelves, darker toward the floor.
        let shelves = value_noise(at.u * SHELVES_PER_M[0], at.v * SHELVES_PER_M[1], hash);
        let low = (0.7 - at.v * 0.5).clamp(0.0, 1.0);
        return COOL * (window.z * (1.3 - THINGS * low * (0.4 + shelves)));
    }
    if lit >= window.x {
        return Vec3::ZERO;
    }
    let brightness = window.y * (LEAST + RANGE * level * level);
    let color = WARM + (COOL - WARM) * (tint * tint);
    if kind < SCREEN_SHARE {
        return SCREEN * (0.3 * brightness);
    }
    if kind < SCREEN_SHARE + CURTAIN_SHARE {
        let folds = value_noise(at.u * FOLDS_PER_M, 0.5, hash);
        return color * (brightness * CURTAIN * (0.75 + 0.5 * folds));
    }
    let things = value_noise(at.u * THINGS_PER_M, at.v * THINGS_PER_M, hash);
    let dark = THINGS * (0.1 - at.v * 1.4).clamp(0.0, 1.0) * things;
    color * (brightness * (1.0 + RISE_PER_M * at.v).max(0.2) * (1.0 - dark))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(hash: u32) -> PatternPoint {
        PatternPoint { u: 0.1, v: 0.2, footprint_m: 0.01, pixel_m: 0.01, face_hash: hash, place_hash: 0 }
    }

    #[test]
    fn both_halves_of_a_pane_and_its_coarser_levels_are_one_window() {
        let [a, b, c, d] =
            [(0.0, 0.0), (1.2, 0.0), (1.2, 1.4), (0.0, 1.4)].map(|(y, z)| Vec3::new(4.0, 3.1 + y, 2.2 + z));
        let (first, middle) = window([a, b, c], Vec3::X, 7);
        let (second, _) = window([a, c, d], Vec3::X, 7);
        // Farther out and larger about the same middle.
        let grown = [a, b, c].map(|p| middle + (p - middle) * 1.12 + Vec3::X * 0.21);
        assert_eq!((first, first), (second, window(grown, Vec3::X, 7).0));
        assert!((middle - Vec3::new(4.0, 3.7, 2.9)).length() < 1e-5);
        assert_ne!(first, window([a, b, c].map(|p| p + Vec3::Y * 2.0), Vec3::X, 7).0);
    }

    #[test]
    fn as_many_windows_are_lit_as_stated_and_shops_where_they_are() {
        let lit = |flag: u32, window: Vec3| {
            let hashes = (0..4000_u32).map(|i| hash2(i as i32, 3, 9) & !SHOP_FLAG | flag);
            hashes.filter(|h| radiance(window, &at(*h)).y > 0.0).count() as f32 / 4000.0
        };
        let homes = lit(0, Vec3::new(0.24, 0.1, 0.0));
        assert!((homes - 0.24).abs() < 0.02, "{homes}");
        assert_eq!(lit(SHOP_FLAG, Vec3::new(0.24, 0.1, 0.0)), 0.0);
        assert_eq!(lit(SHOP_FLAG, Vec3::new(0.24, 0.1, 0.05)), 1.0);
        let bus = Vec3::new(2.0, 0.1, 0.0);
        assert_eq!(radiance(bus, &at(3)), radiance(bus, &at(SHOP_FLAG | 4)));
    }
}
