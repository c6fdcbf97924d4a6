//! KITTI's average precision: the rules of the official program, decision by decision, in double precision.
//!
//! [`read_files`] reads label and result files; [`evaluate`] compares. Overlaps are computed once for each frame;
//! frames, classes, levels and metrics run in parallel.
//!
//! # Determinism
//!
//! Nothing depends on the number of threads or the order of frames, to the last bit: what is summed over frames are
//! whole numbers. Within a frame the order of lines breaks ties, as in KITTI's program.

mod class_records;
mod curves;
mod draws;
mod files;
mod matching;
mod metric;
mod nms;
mod objects;
mod overlaps;
mod parse;
mod prepared;
mod rotated_iou;
mod sight;
mod text;

use rayon::prelude::*;

pub use curves::{MAX_THRESHOLDS, PrecisionByRecall, average_r11, average_r40, choose_thresholds, perfect};
pub use draws::{DrawnAp, evaluate_draws};
pub use files::read_files;
pub use metric::{ClassLimits, Level, Metric, Settings};
pub use nms::{MAX_PAIRS, iou_matrix, nms_bev};
pub use objects::{BoxImg, Detection, FramePair, MIN_SCORE, ObjectType, ObjectTypes, OtherNames, Truth};
pub use parse::{Parsed, parse_detections, parse_truths};
pub use rotated_iou::{RotatedBox, intersection_bev_m2, iou_3d, iou_bev};
pub use sight::{Sight, sight};

use cadet_base::error::Result;
use cadet_base::parallel;
use prepared::{Prepared, Task};

/// The result for one class, metric and level.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Index of the class in the settings.
    pub class: usize,
    /// The metric.
    pub metric: Metric,
    /// Index of the level in the settings.
    pub level: usize,
    /// How many objects there are to find.
    pub num_valid: u64,
    /// Falling scores, at most 41; their number is how far recall reaches, in steps of 1/40.
    pub thresholds: Vec<f64>,
    /// True positives at each threshold.
    pub num_tp: Vec<u64>,
    /// False positives at each threshold.
    pub num_fp: Vec<u64>,
    /// Precision by recall, made to fall.
    pub precision: PrecisionByRecall,
    /// Precision by recall, made to fall, with each true positive worth (1 + cos d) / 2 of its heading's error: AOS of
    /// observation angles in the image, AHS of headings from above and in space. None in the image if any detection has
    /// no observation angle.
    pub heading: Option<PrecisionByRecall>,
}

/// Compares detections with ground truth.
///
/// A class without a detection that is usable in a metric has no curve there.
///
/// ```
/// use cadet_core::evaluate::{
///     ClassLimits, FramePair, ObjectType, Level, Settings, evaluate, parse_detections, parse_truths,
/// };
///
/// let car = "Car 0.00 0 0.10 100.00 150.00 200.00 220.00 1.50 1.60 3.90 1.00 1.60 20.00 0.15";
/// let truths = parse_truths(car.as_bytes(), "000000.txt")?;
/// let found = parse_detections(format!("{car} 0.9").as_bytes(), "000000.txt")?;
/// let frames = [FramePair { truths: truths.objects, detections: found.objects }];
///
/// let class = ClassLimits::of(ObjectType::Car, [0.7; 3]);
/// let easy = Level { min_height_px: 40.0, is_inclusive: false, max_occlusion_level: 0.0, max_truncation: 0.15 };
/// let curves = evaluate(&frames, &Settings { classes: vec![class], levels: vec![easy] })?;
/// // In the image, from above, and in 3D.
/// assert_eq!(curves.len(), 3);
/// assert!(curves.iter().all(|curve| curve.num_tp[0] == 1 && curve.precision[0] == 1.0));
/// # Ok::<_, cadet_core::Error>(())
/// ```
///
/// # Errors
/// [`cadet_base::Error::OutOfRange`] and [`cadet_base::Error::Unknown`] for settings that make no sense.
pub fn evaluate(frames: &[FramePair], settings: &Settings) -> Result<Vec<Curve>> {
    settings.check()?;
    Ok(parallel::run(|| curves_of(frames, settings)))
}

fn curves_of(frames: &[FramePair], settings: &Settings) -> Vec<Curve> {
    let prepared = Prepared::new(frames, settings);
    let indices: Vec<u32> = (0..frames.len() as u32).collect();
    let curve = |task: &Task| {
        let (criteria, Task { class, metric, level }) = (prepared.criteria(task), *task);
        let found = prepared.first_pass(&criteria, class);
        let num_valid = found.num_valid;
        let (thresholds, tally) = prepared.second_pass(&criteria, class, &indices, found);
        let count = thresholds.len();
        Curve {
            class,
            metric,
            level,
            num_valid,
            num_tp: tally.num_tp[..count].iter().map(|&n| n as u64).collect(),
            num_fp: tally.num_fp[..count].iter().map(|&n| n as u64).collect(),
            precision: tally.precision(count),
            heading: prepared.has_heading(metric).then(|| tally.heading_similarity(count)),
            thresholds,
        }
    };
    prepared.tasks().par_iter().map(curve).collect()
}
