//! Overlaps of all pairs, and suppression of the lesser ones.

use rayon::prelude::*;

use super::rotated_iou::{BoxCam, iou_bev};

/// Fewer pairs than this are not worth a thread.
const PAIRS_A_TASK: usize = 2048;

/// The IoU of every box of `a` with every box of `b`, row by row.
#[must_use]
pub fn iou_matrix(a: &[BoxCam], b: &[BoxCam], iou: fn(&BoxCam, &BoxCam) -> f64) -> Vec<f64> {
    if b.is_empty() {
        return Vec::new();
    }
    let mut matrix = vec![0.0; a.len() * b.len()];
    let rows_a_task = PAIRS_A_TASK.div_ceil(b.len());
    matrix.par_chunks_mut(rows_a_task * b.len()).zip(a.par_chunks(rows_a_task)).for_each(|(rows, a)| {
        for (row, a) in rows.chunks_exact_mut(b.len()).zip(a) {
            for (value, b) in row.iter_mut().zip(b) {
                *value = iou(a, b);
            }
        }
    });
    matrix
}

/// Keeps each box that no kept box of higher score overlaps by more than `threshold`, seen from above.
///
/// Returns the indices of what is kept, by falling score; of equal scores the first comes first.
#[must_use]
pub fn nms_bev(boxes: &[BoxCam], scores: &[f64], threshold: f64) -> Vec<usize> {
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

    fn at(x: f64) -> BoxCam {
        BoxCam { x, y: 1.6, z: 20.0, length: 4.0, width: 2.0, height: 1.5, rotation_y: 0.0 }
    }

    #[test]
    fn a_suppressed_box_suppresses_nothing() {
        // Neighbours share 0.6 of their union, next but ones 1/3.
        let boxes = [at(0.0), at(1.0), at(2.0), at(3.0)];
        assert_eq!(nms_bev(&boxes, &[0.9, 0.8, 0.7, 0.6], 0.5), [0, 2]);
        assert_eq!(nms_bev(&boxes, &[0.8, 0.9, 0.7, 0.6], 0.5), [1, 3]);
        assert_eq!(nms_bev(&boxes, &[0.9, 0.8, 0.7, 0.6], 0.6), [0, 1, 2, 3]);
        assert_eq!(nms_bev(&boxes, &[0.5; 4], 0.5), [0, 2]);
        assert_eq!(nms_bev(&[], &[], 0.5), [0_usize; 0]);
    }

    #[test]
    fn the_matrix_has_a_row_for_each_box_of_the_first() {
        let many: Vec<BoxCam> = (0..100).map(|i| at(f64::from(i) * 0.1)).collect();
        let matrix = iou_matrix(&many, &many[..70], iou_bev);
        assert_eq!(matrix.len(), 7000);
        for i in 0..100 {
            for j in 0..70 {
                assert_eq!(matrix[i * 70 + j], iou_bev(&many[i], &many[j]));
            }
        }
    }
}
