//! KITTI's two greedy passes over a frame, for one class, level and metric.
//!
//! Both go over the objects in file order and never over the detections. The first collects the scores of the true
//! positives without a threshold and prefers high scores; the second counts at each threshold and prefers large
//! overlaps. The second is not run once a threshold: its answer changes only where a detection that overlaps something
//! comes in, so it is run there and the differences are noted.

use super::class_records::{ClassDetection, ClassObject};
use super::curves::{MAX_THRESHOLDS, Tally};
use super::metric::{Level, Metric};
use super::objects::{Detection, FramePair, ObjectTypes, Truth};
use super::overlaps::FrameOverlaps;
use cadet_base::math;

/// A class at a level in a metric.
#[derive(Debug, Clone, Copy)]
pub(super) struct Criteria<'a> {
    pub kinds: &'a ObjectTypes,
    pub level: &'a Level,
    pub metric: Metric,
    pub min_overlap: f64,
}

/// A frame as a class sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClassFrame<'a> {
    pub frame: &'a FramePair,
    pub overlaps: &'a FrameOverlaps,
    pub class_objects: &'a [ClassObject],
    pub class_detections: &'a [ClassDetection],
}

/// What finding an object that takes part is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mark {
    /// It must be found.
    Valid,
    /// It may be found: too hard for the level, optional, or of a neighbor class.
    Ignored,
}

impl Criteria<'_> {
    fn mark(&self, class_object: &ClassObject) -> Mark {
        let level = self.level;
        let height = class_object.height_px;
        let is_high = height > level.min_height_px || (level.is_inclusive && height == level.min_height_px);
        let is_seen = class_object.occlusion_level <= level.max_occlusion_level
            && class_object.truncation <= level.max_truncation;
        if class_object.is_wanted && is_high && is_seen { Mark::Valid } else { Mark::Ignored }
    }

    /// Whether a detection, of any class, is too low to be right or wrong.
    fn is_small(&self, height_px: f64) -> bool {
        height_px < self.level.min_height_px
    }

    /// (1 + cos d) / 2 of the headings' difference: of observation angles in the image, else of headings in space.
    fn similarity(&self, truth: &Truth, detection: &Detection) -> f64 {
        let difference = match self.metric {
            Metric::Image => truth.alpha - detection.alpha,
            Metric::Bev | Metric::Volume => truth.box_cam.rotation_y - detection.box_cam.rotation_y,
        };
        (1.0 + math::cos(difference)) / 2.0
    }
}

#[derive(Debug, Clone, Copy)]
struct MatchCandidate {
    detection: usize,
    iou: f64,
    score: f64,
    is_active: bool,
    /// The first threshold that lets it in.
    enters: usize,
}

#[derive(Debug, Clone, Copy)]
struct Object {
    truth: usize,
    is_valid: bool,
    start: usize,
    end: usize,
}

/// The objects of a frame that some detection overlaps, and those detections. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(super) struct Matcher {
    objects: Vec<Object>,
    candidates: Vec<MatchCandidate>,
    is_taken: Vec<bool>,
    steps: Vec<usize>,
}

/// What the first pass finds.
#[derive(Debug, Default)]
pub(super) struct FirstPass {
    /// Objects that must be found.
    pub num_valid: u64,
    /// Scores of the true positives.
    pub scores: Vec<f64>,
}

impl FirstPass {
    pub(super) fn joined(mut self, mut other: Self) -> Self {
        self.num_valid += other.num_valid;
        self.scores.append(&mut other.scores);
        self
    }
}

/// What the matched pairs of a frame add up to at a threshold.
#[derive(Debug, Default, Clone, Copy)]
struct Outcome {
    num_tp: i64,
    /// Taken detections that would be false positives otherwise.
    num_spared: i64,
    similarity: i128,
}

impl Matcher {
    /// Adds a frame to the first pass.
    pub(super) fn collect_scores(&mut self, criteria: &Criteria<'_>, view: &ClassFrame<'_>, found: &mut FirstPass) {
        let is_valid = |class_object: &&ClassObject| criteria.mark(class_object) == Mark::Valid;
        found.num_valid += view.class_objects.iter().filter(is_valid).count() as u64;
        self.gather(criteria, view, &[]);
        for object in &self.objects {
            let mut best: Option<&MatchCandidate> = None;
            for candidate in &self.candidates[object.start..object.end] {
                if !self.is_taken[candidate.detection] && best.is_none_or(|best| candidate.score > best.score) {
                    best = Some(candidate);
                }
            }
            if let Some(best) = best {
                self.is_taken[best.detection] = true;
                if object.is_valid && best.is_active {
                    found.scores.push(best.score);
                }
            }
        }
    }

    /// Adds a frame to the second pass at all thresholds, which fall.
    pub(super) fn count(
        &mut self,
        criteria: &Criteria<'_>,
        view: &ClassFrame<'_>,
        thresholds: &[f64],
        tally: &mut Tally,
    ) {
        for class_detection in view.class_detections {
            if !criteria.is_small(class_detection.height_px)
                && class_detection.covered_share[criteria.metric as usize] <= criteria.min_overlap
            {
                let enters = first_threshold(thresholds, class_detection.score);
                if enters < thresholds.len() {
                    tally.num_fp[enters] += 1;
                }
            }
        }
        self.gather(criteria, view, thresholds);
        self.steps.clear();
        self.steps.extend(self.candidates.iter().map(|candidate| candidate.enters));
        self.steps.sort_unstable();
        self.steps.dedup();
        let mut before = Outcome::default();
        for step in 0..self.steps.len() {
            let threshold = self.steps[step];
            if threshold >= thresholds.len() {
                break;
            }
            let now = self.match_at(criteria, view, threshold);
            tally.num_tp[threshold] += now.num_tp - before.num_tp;
            tally.num_fp[threshold] -= now.num_spared - before.num_spared;
            tally.similarity[threshold] += now.similarity - before.similarity;
            before = now;
        }
    }

    /// Lists the objects that may be found and the detections that may find them.
    fn gather(&mut self, criteria: &Criteria<'_>, view: &ClassFrame<'_>, thresholds: &[f64]) {
        self.objects.clear();
        self.candidates.clear();
        for class_object in view.class_objects {
            let start = self.candidates.len();
            for overlap in view.overlaps.of(criteria.metric, class_object.truth as usize) {
                if overlap.iou <= criteria.min_overlap {
                    continue;
                }
                let detection = &view.frame.detections[overlap.detection as usize];
                let is_small = criteria.is_small(detection.height_px());
                if is_small || criteria.kinds.contains(detection.kind) {
                    self.candidates.push(MatchCandidate {
                        detection: overlap.detection as usize,
                        iou: overlap.iou,
                        score: detection.score,
                        is_active: !is_small,
                        enters: first_threshold(thresholds, detection.score),
                    });
                }
            }
            let end = self.candidates.len();
            if end > start {
                let is_valid = criteria.mark(class_object) == Mark::Valid;
                self.objects.push(Object { truth: class_object.truth as usize, is_valid, start, end });
            }
        }
        if !self.objects.is_empty() {
            self.is_taken.clear();
            self.is_taken.resize(view.frame.detections.len(), false);
        }
    }

    fn match_at(&mut self, criteria: &Criteria<'_>, view: &ClassFrame<'_>, threshold: usize) -> Outcome {
        let mut outcome = Outcome::default();
        self.is_taken.fill(false);
        for object in &self.objects {
            let mut chosen: Option<&MatchCandidate> = None;
            for candidate in &self.candidates[object.start..object.end] {
                if candidate.enters > threshold || self.is_taken[candidate.detection] {
                    continue;
                }
                let is_better = match chosen {
                    None => true,
                    Some(other) if candidate.is_active => !other.is_active || candidate.iou > other.iou,
                    Some(_) => false,
                };
                if is_better {
                    chosen = Some(candidate);
                }
            }
            let Some(chosen) = chosen else { continue };
            self.is_taken[chosen.detection] = true;
            if !chosen.is_active {
                continue;
            }
            let is_stuff = view.overlaps.covered_share(criteria.metric, chosen.detection) > criteria.min_overlap;
            outcome.num_spared += i64::from(!is_stuff);
            if object.is_valid {
                outcome.num_tp += 1;
                let (truth, detection) = (&view.frame.truths[object.truth], &view.frame.detections[chosen.detection]);
                outcome.similarity += Tally::fixed_point(criteria.similarity(truth, detection));
            }
        }
        outcome
    }
}

/// The index of the first of the falling thresholds that a score reaches; their number if it reaches none.
fn first_threshold(thresholds: &[f64], score: f64) -> usize {
    debug_assert!(thresholds.len() <= MAX_THRESHOLDS, "{} thresholds", thresholds.len());
    thresholds.partition_point(|&threshold| threshold > score)
}
