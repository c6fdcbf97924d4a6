//! Frames whose overlaps are known, and KITTI's two passes over all or some of them.

use rayon::prelude::*;

use super::class_records::ClassRecords;
use super::curves::{Tally, choose_thresholds};
use super::matching::{ClassFrame, Criteria, FirstPass, Matcher};
use super::metric::{ClassLimits, Metric, Settings};
use super::objects::FramePair;
use super::overlaps::FrameOverlaps;

/// The mark of an observation angle that a detector does not estimate.
const UNKNOWN_ALPHA: f64 = -10.0;
/// The mark of a place that a detector does not estimate.
const UNKNOWN_PLACE: f64 = -1000.0;

/// The fewest frames that are worth a thread.
const FRAMES_A_TASK: usize = 256;

/// A curve that is to be computed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Task {
    /// Index of the class in the settings.
    pub class: usize,
    pub metric: Metric,
    /// Index of the level in the settings.
    pub level: usize,
}

/// Results that are computed once for all classes, metrics and levels.
#[derive(Debug)]
pub(super) struct Prepared<'a> {
    frames: &'a [FramePair],
    settings: &'a Settings,
    overlaps: Vec<FrameOverlaps>,
    records_of_classes: Vec<ClassRecords>,
    has_alpha: bool,
}

impl<'a> Prepared<'a> {
    pub(super) fn new(frames: &'a [FramePair], settings: &'a Settings) -> Self {
        let floors = settings.least_min_overlap();
        let overlaps: Vec<FrameOverlaps> =
            frames.par_iter().map(|frame| FrameOverlaps::new(frame, floors, |kind| settings.wants(kind))).collect();
        let has_alpha = frames.iter().flat_map(|frame| &frame.detections).all(|d| d.alpha != UNKNOWN_ALPHA);
        let records_of_classes: Vec<ClassRecords> =
            settings.classes.par_iter().map(|limits| ClassRecords::new(limits, frames, &overlaps)).collect();
        Self { frames, settings, overlaps, records_of_classes, has_alpha }
    }

    /// Lists the curves; a class without a detection that is usable in a metric has none there.
    pub(super) fn tasks(&self) -> Vec<Task> {
        let mut tasks = Vec::new();
        for (class, limits) in self.settings.classes.iter().enumerate() {
            for metric in Metric::ALL {
                if is_measured(self.frames, limits, metric) {
                    tasks.extend((0..self.settings.levels.len()).map(|level| Task { class, metric, level }));
                }
            }
        }
        tasks
    }

    pub(super) fn criteria(&self, &Task { class, metric, level }: &Task) -> Criteria<'a> {
        let limits = &self.settings.classes[class];
        Criteria {
            kinds: &limits.kinds,
            level: &self.settings.levels[level],
            metric,
            min_overlap: limits.min_overlap[metric as usize],
        }
    }

    /// Whether headings can be compared: in the image only if every detection has an observation angle.
    pub(super) fn has_heading(&self, metric: Metric) -> bool {
        metric != Metric::Image || self.has_alpha
    }

    /// The first pass over all frames.
    pub(super) fn first_pass(&self, criteria: &Criteria<'_>, class: usize) -> FirstPass {
        (0..self.frames.len())
            .into_par_iter()
            .with_min_len(FRAMES_A_TASK)
            .fold(Default::default, |(mut matcher, mut found): (Matcher, FirstPass), index| {
                matcher.collect_scores(criteria, &self.view(class, index), &mut found);
                (matcher, found)
            })
            .map(|(_, found)| found)
            .reduce(FirstPass::default, FirstPass::joined)
    }

    /// The first pass, frame by frame.
    pub(super) fn first_passes(&self, criteria: &Criteria<'_>, class: usize) -> Vec<FirstPass> {
        let pass = |matcher: &mut Matcher, index: usize| {
            let mut found = FirstPass::default();
            matcher.collect_scores(criteria, &self.view(class, index), &mut found);
            found
        };
        (0..self.frames.len()).into_par_iter().with_min_len(FRAMES_A_TASK).map_init(Matcher::default, pass).collect()
    }

    /// Chooses thresholds and counts at each of them, over frames that may come more than once.
    pub(super) fn second_pass(
        &self,
        criteria: &Criteria<'_>,
        class: usize,
        indices: &[u32],
        mut found: FirstPass,
    ) -> (Vec<f64>, Tally) {
        found.scores.sort_unstable_by(|a, b| b.total_cmp(a));
        let thresholds = choose_thresholds(&found.scores, found.num_valid);
        let tally = indices
            .par_iter()
            .with_min_len(FRAMES_A_TASK)
            .fold(Default::default, |(mut matcher, mut tally): (Matcher, Tally), &index| {
                matcher.count(criteria, &self.view(class, index as usize), &thresholds, &mut tally);
                (matcher, tally)
            })
            .map(|(_, tally)| tally)
            .reduce(Tally::default, |a, b| a.plus(&b))
            .accumulate();
        (thresholds, tally)
    }

    fn view(&self, class: usize, index: usize) -> ClassFrame<'_> {
        ClassFrame {
            frame: &self.frames[index],
            overlaps: &self.overlaps[index],
            class_objects: self.records_of_classes[class].class_objects(index),
            class_detections: self.records_of_classes[class].class_detections(index),
        }
    }
}

/// Whether any detection of a class says what a metric needs.
fn is_measured(frames: &[FramePair], class: &ClassLimits, metric: Metric) -> bool {
    frames.iter().flat_map(|frame| &frame.detections).filter(|d| class.kinds.contains(d.kind)).any(|d| {
        let b = &d.box_cam;
        let is_on_ground = b.x != UNKNOWN_PLACE && b.z != UNKNOWN_PLACE && b.width_m > 0.0 && b.length_m > 0.0;
        match metric {
            Metric::Image => d.box_img.left_px >= 0.0,
            Metric::Bev => is_on_ground,
            Metric::Volume => is_on_ground && b.y != UNKNOWN_PLACE && b.height_m > 0.0,
        }
    })
}
