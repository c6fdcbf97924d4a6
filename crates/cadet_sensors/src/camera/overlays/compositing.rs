//! Blending colors into linear images, and looking colors up in coarse ones.

use cadet_base::math::Vec3;

/// Puts a color over a pixel, R, G, B, of which it covers a share.
pub(super) fn blend(pixel: &mut [f32], color: Vec3, cover: f32) {
    for (value, over) in pixel.iter_mut().zip(color.to_array()) {
        *value += (over - *value) * cover;
    }
}

/// The two of a row of cells between whose middles a place lies, in cells from the middle of the first, and the share of the
/// second; what is beyond the last is the last's.
pub(super) fn between_cells(at_cell: f64, cells: usize) -> (usize, usize, f32) {
    let at = at_cell.clamp(0.0, (cells - 1) as f64);
    let first = (at as usize).min(cells.saturating_sub(2));
    (first, (first + 1).min(cells - 1), (at - first as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_a_color_is_laid_over_a_pixel() {
        let mut pixel = [1.0, 2.0, 4.0];
        blend(&mut pixel, Vec3::new(3.0, 2.0, 0.0), 0.25);
        assert_eq!(pixel, [1.5, 2.0, 3.0]);
    }

    #[test]
    fn places_lie_between_the_middles_of_cells() {
        assert_eq!(between_cells(1.25, 4), (1, 2, 0.25));
        assert_eq!(between_cells(-2.0, 4), (0, 1, 0.0));
        assert_eq!(between_cells(9.0, 4), (2, 3, 1.0));
        assert_eq!(between_cells(0.7, 1), (0, 0, 0.0));
    }
}
