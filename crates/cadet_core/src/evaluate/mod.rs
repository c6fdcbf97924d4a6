//! KITTI's average precision: the rules of the official program, decision by decision, in double precision.
//!
//! [`read_files`] reads label and result files; [`evaluate`] compares. Overlaps are computed once for each frame;
//! frames, classes, levels and metrics run in parallel.
//!
//! # Determinism
//!
//! Nothing depends on the number of threads or the order of frames, to the last bit: what is summed over frames are
//! whole numbers. Within a frame the order of lines breaks ties, as in KITTI's program.

mod curves;
mod files;
mod matching;
mod metric;
mod nms;
mod objects;
mod overlaps;
mod parse;
mod roster;
mod rotated_iou;

use rayon::prelude::*;

pub use curves::{MAX_THRESHOLDS, Samples, average_r11, average_r40, choose_thresholds, perfect};
pub use files::read_files;
pub use metric::{ClassLimits, Level, Metric, Settings};
pub use nms::{MAX_PAIRS, iou_matrix, nms_bev};
pub use objects::{BoxImg, Detection, FramePair, Kind, MIN_SCORE, Truth};
pub use parse::{ParsedDetections, parse_detections, parse_truths};
pub use rotated_iou::{BoxCam, intersection_bev, iou_3d, iou_bev};

use crate::error::Result;
use crate::parallel;
use curves::Tally;
use matching::{Contest, FirstPass, Matcher, View};
use overlaps::FrameOverlaps;
use roster::Roster;

/// The mark of an observation angle that a detector does not estimate.
const UNKNOWN_ALPHA: f64 = -10.0;
/// The mark of a place that a detector does not estimate.
const UNKNOWN_PLACE: f64 = -1000.0;

/// The fewest frames that are worth a thread.
const FRAMES_A_TASK: usize = 256;

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
    pub precision: Samples,
    /// The same with each true positive worth (1 + cos d) / 2 of its heading's error: AOS of observation angles in the
    /// image, AHS of headings from above and in space. None in the image if any detection has no observation angle.
    pub heading: Option<Samples>,
}

/// Compares detections with ground truth.
///
/// A class without a detection that is usable in a metric has no curve there.
///
/// ```
/// use cadet_core::evaluate::{
///     ClassLimits, FramePair, Kind, Level, Settings, evaluate, parse_detections, parse_truths,
/// };
///
/// let car = "Car 0.00 0 0.10 100.00 150.00 200.00 220.00 1.50 1.60 3.90 1.00 1.60 20.00 0.15";
/// let truths = parse_truths(car.as_bytes(), "000000.txt")?;
/// let found = parse_detections(format!("{car} 0.9").as_bytes(), "000000.txt")?;
/// let frames = [FramePair { truths, detections: found.detections }];
///
/// let class = ClassLimits { class: Kind::Car, min_overlap: [0.7; 3] };
/// let easy = Level { min_height_px: 40.0, is_inclusive: false, max_occlusion: 0.0, max_truncation: 0.15 };
/// let curves = evaluate(&frames, &Settings { classes: vec![class], levels: vec![easy] })?;
/// // In the image, from above, and in 3D.
/// assert_eq!(curves.len(), 3);
/// assert!(curves.iter().all(|curve| curve.num_tp[0] == 1 && curve.precision[0] == 1.0));
/// # Ok::<_, cadet_core::Error>(())
/// ```
///
/// # Errors
/// [`crate::Error::OutOfRange`] and [`crate::Error::Unknown`] for settings that make no sense.
pub fn evaluate(frames: &[FramePair], settings: &Settings) -> Result<Vec<Curve>> {
    settings.check()?;
    Ok(parallel::run(|| curves_of(frames, settings)))
}

fn curves_of(frames: &[FramePair], settings: &Settings) -> Vec<Curve> {
    let floors = settings.floors();
    let overlaps: Vec<FrameOverlaps> =
        frames.par_iter().map(|frame| FrameOverlaps::new(frame, floors, |kind| settings.wants(kind))).collect();
    let has_alpha = frames.iter().flat_map(|frame| &frame.detections).all(|d| d.alpha != UNKNOWN_ALPHA);
    let rosters: Vec<Roster> =
        settings.classes.par_iter().map(|limits| Roster::new(limits.class, frames, &overlaps)).collect();
    let mut tasks = Vec::new();
    for (class, limits) in settings.classes.iter().enumerate() {
        for metric in Metric::ALL {
            if is_measured(frames, limits.class, metric) {
                tasks.extend((0..settings.levels.len()).map(|level| (class, metric, level)));
            }
        }
    }
    let curve = |&(class, metric, level): &(usize, Metric, usize)| {
        let limits = &settings.classes[class];
        let contest = Contest {
            class: limits.class,
            level: &settings.levels[level],
            metric,
            min_overlap: limits.min_overlap[metric as usize],
        };
        let (found, thresholds, tally) = run(&contest, frames, &overlaps, &rosters[class]);
        let count = thresholds.len();
        Curve {
            class,
            metric,
            level,
            num_valid: found.num_valid,
            num_tp: tally.num_tp[..count].iter().map(|&n| n as u64).collect(),
            num_fp: tally.num_fp[..count].iter().map(|&n| n as u64).collect(),
            precision: tally.precision(count),
            heading: (metric != Metric::Image || has_alpha).then(|| tally.heading_similarity(count)),
            thresholds,
        }
    };
    tasks.par_iter().map(curve).collect()
}

/// Whether any detection of a class says what a metric needs.
fn is_measured(frames: &[FramePair], class: Kind, metric: Metric) -> bool {
    frames.iter().flat_map(|frame| &frame.detections).filter(|d| d.kind == class).any(|d| {
        let b = &d.box_cam;
        let is_on_ground = b.x != UNKNOWN_PLACE && b.z != UNKNOWN_PLACE && b.width > 0.0 && b.length > 0.0;
        match metric {
            Metric::Image => d.box_img.x1 >= 0.0,
            Metric::Bev => is_on_ground,
            Metric::Volume => is_on_ground && b.y != UNKNOWN_PLACE && b.height > 0.0,
        }
    })
}

fn run(
    contest: &Contest<'_>,
    frames: &[FramePair],
    overlaps: &[FrameOverlaps],
    roster: &Roster,
) -> (FirstPass, Vec<f64>, Tally) {
    let view = |index: usize| View {
        frame: &frames[index],
        overlaps: &overlaps[index],
        entrants: roster.entrants(index),
        claims: roster.claims(index),
    };
    let indices = || (0..frames.len()).into_par_iter().with_min_len(FRAMES_A_TASK);
    let mut found = indices()
        .fold(Default::default, |(mut matcher, mut found): (Matcher, FirstPass), index| {
            matcher.collect_scores(contest, &view(index), &mut found);
            (matcher, found)
        })
        .map(|(_, found)| found)
        .reduce(FirstPass::default, FirstPass::joined);
    found.scores.sort_unstable_by(|a, b| b.total_cmp(a));
    let thresholds = choose_thresholds(&found.scores, found.num_valid);
    let tally = indices()
        .fold(Default::default, |(mut matcher, mut tally): (Matcher, Tally), index| {
            matcher.count(contest, &view(index), &thresholds, &mut tally);
            (matcher, tally)
        })
        .map(|(_, tally)| tally)
        .reduce(Tally::default, |a, b| a.plus(&b))
        .accumulate();
    (found, thresholds, tally)
}
