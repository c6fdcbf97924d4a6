//! Overlaps of all pairs, and suppression of the lesser ones.

use rayon::prelude::*;

use super::rotated_iou::{RotatedBox, iou_bev};
use cadet_base::error::Error;
use cadet_base::parallel;

/// Fewer pairs than this are not worth a thread.
const PAIRS_A_TASK: usize = 2048;

/// The most pairs that [`iou_matrix`] takes: 2 GiB of numbers.
pub const MAX_PAIRS: usize = 1 << 28;

/// About as many pairs as a tenth of a second takes.
const PAIRS_BETWEEN_PAUSES: usize = 1 << 19;

/// The IoU of every box of `a` with every box of `b`, row by row; `pause` is called now and then and may end it.
///
/// # Errors
/// [`Error::OutOfRange`] for more than [`MAX_PAIRS`], or where the system has no room for fewer; what `pause` returns.
pub fn iou_matrix<E: From<Error>>(
    a: &[RotatedBox],
    b: &[RotatedBox],
    iou: fn(&RotatedBox, &RotatedBox) -> f64,
    mut pause: impl FnMut() -> Result<(), E>,
) -> Result<Vec<f64>, E> {
    if b.is_empty() {
        return Ok(Vec::new());
    }
    let too_many = |expected: String| {
        let value = format!("{} x {}", a.len(), b.len());
        Error::OutOfRange { what: "number of pairs of boxes", value, expected }
    };
    let num_pairs = a.len().checked_mul(b.len()).filter(|pairs| *pairs <= MAX_PAIRS);
    let num_pairs = num_pairs.ok_or_else(|| too_many(format!("at most {MAX_PAIRS}: give the boxes part by part")))?;
    let mut matrix: Vec<f64> = Vec::new();
    matrix.try_reserve_exact(num_pairs).map_err(|_| too_many("fewer: there is no memory for them".to_owned()))?;
    let rows_a_task = PAIRS_A_TASK.div_ceil(b.len());
    let fill = |(rows, a): (&mut [f64], &[RotatedBox])| {
        for (row, a) in rows.chunks_exact_mut(b.len()).zip(a) {
            for (value, b) in row.iter_mut().zip(b) {
                *value = iou(a, b);
            }
        }
    };
    let rows_a_part = PAIRS_BETWEEN_PAUSES.div_ceil(b.len());
    for a in a.chunks(rows_a_part) {
        let start = matrix.len();
        matrix.resize(start + a.len() * b.len(), 0.0);
        let rows = &mut matrix[start..];
        parallel::run(|| rows.par_chunks_mut(rows_a_task * b.len()).zip(a.par_chunks(rows_a_task)).for_each(fill));
        pause()?;
    }
    Ok(matrix)
}

/// Keeps each box that no kept box of higher score overlaps by more than `threshold`, seen from above.
///
/// Returns the indices of what is kept, by falling score; of equal scores the first comes first.
#[must_use]
pub fn nms_bev(boxes: &[RotatedBox], scores: &[f64], threshold: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..boxes.len().min(scores.len())).collect();
    // Adding 0 makes -0 equal to 0.
    order.sort_by(|&i, &j| (scores[j] + 0.0).total_cmp(&(scores[i] + 0.0)));
    let mut kept: Vec<usize> = Vec::new();
    for index in order {
        if kept.iter().all(|&other| iou_bev(&boxes[other], &boxes[index]) <= threshold) {
            kept.push(index);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64) -> RotatedBox {
        RotatedBox { x, y: 1.6, z: 20.0, length_m: 4.0, width_m: 2.0, height_m: 1.5, rotation_y: 0.0 }
    }

    #[test]
    fn a_suppressed_box_suppresses_nothing() {
        // Neighbors share 0.6 of their union, next but ones 1/3.
        let boxes = [at(0.0), at(1.0), at(2.0), at(3.0)];
        assert_eq!(nms_bev(&boxes, &[0.9, 0.8, 0.7, 0.6], 0.5), [0, 2]);
        assert_eq!(nms_bev(&boxes, &[0.8, 0.9, 0.7, 0.6], 0.5), [1, 3]);
        assert_eq!(nms_bev(&boxes, &[0.9, 0.8, 0.7, 0.6], 0.6), [0, 1, 2, 3]);
        assert_eq!(nms_bev(&boxes, &[0.5; 4], 0.5), [0, 2]);
        assert_eq!(nms_bev(&[], &[], 0.5), [0_usize; 0]);
    }

    #[test]
    fn a_matrix_beyond_the_limit_is_refused_before_it_is_made() {
        let (many, few) = (vec![at(0.0); 1 << 20], vec![at(0.0); 257]);
        let error = iou_matrix(&many, &few, iou_bev, || Ok::<_, Error>(())).unwrap_err().to_string();
        let expected =
            "number of pairs of boxes is 1048576 x 257, expected at most 268435456: give the boxes part by part";
        assert_eq!(error, expected);
    }

    #[test]
    fn the_matrix_has_a_row_for_each_box_of_the_first() {
        let many: Vec<RotatedBox> = (0..100).map(|i| at(f64::from(i) * 0.1)).collect();
        let matrix = iou_matrix(&many, &many[..70], iou_bev, || Ok::<_, Error>(())).unwrap();
        assert_eq!(matrix.len(), 7000);
        for i in 0..100 {
            for j in 0..70 {
                assert_eq!(matrix[i * 70 + j], iou_bev(&many[i], &many[j]));
            }
        }
    }
}
