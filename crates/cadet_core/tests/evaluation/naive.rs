//! KITTI's rules written down plainly: every overlap anew, every frame again at every threshold.

use cadet_core::evaluate::{
    Detection, FramePair, Level, Metric, ObjectType, ObjectTypes, PrecisionByRecall, Settings, Truth,
    choose_thresholds, intersection_bev_m2, iou_3d, iou_bev,
};
use cadet_core::math::cos;

/// Number of valid objects, true and false positives at each threshold, precision and heading similarity.
pub struct Answer {
    pub num_valid: u64,
    pub num_tp: Vec<u64>,
    pub num_fp: Vec<u64>,
    pub precision: PrecisionByRecall,
    pub heading: PrecisionByRecall,
}

#[derive(PartialEq, Clone, Copy)]
enum Mark {
    Counts,
    Ignored,
    Unrelated,
}

pub fn answer(frames: &[FramePair], settings: &Settings, class: usize, metric: Metric, level: usize) -> Answer {
    let rules = Rules {
        kinds: &settings.classes[class].kinds,
        neighbors: &settings.classes[class].neighbors,
        limit: settings.classes[class].min_overlap[metric as usize],
        level: &settings.levels[level],
        metric,
    };
    let mut scores: Vec<f64> = frames.iter().flat_map(|frame| rules.first_pass(frame)).collect();
    scores.sort_by(|a, b| b.total_cmp(a));
    let valid = frames.iter().flat_map(|f| &f.truths).filter(|t| rules.truth_mark(t) == Mark::Counts).count();
    let mut answer =
        Answer { num_valid: valid as u64, num_tp: vec![], num_fp: vec![], precision: [0.0; 41], heading: [0.0; 41] };
    for (i, &threshold) in choose_thresholds(&scores, valid as u64).iter().enumerate() {
        let (mut tp, mut fp, mut similarity) = (0, 0, 0.0);
        for frame in frames {
            let counts = rules.second_pass(frame, threshold);
            tp += counts.0;
            fp += counts.1;
            similarity += counts.2;
        }
        let total = (tp + fp) as f64;
        answer.num_tp.push(tp);
        answer.num_fp.push(fp);
        if total > 0.0 {
            answer.precision[i] = tp as f64 / total;
            answer.heading[i] = similarity / total;
        }
    }
    for samples in [&mut answer.precision, &mut answer.heading] {
        for i in (0..40).rev() {
            samples[i] = samples[i].max(samples[i + 1]);
        }
    }
    answer
}

struct Rules<'a> {
    kinds: &'a ObjectTypes,
    neighbors: &'a ObjectTypes,
    limit: f64,
    level: &'a Level,
    metric: Metric,
}

impl Rules<'_> {
    fn truth_mark(&self, t: &Truth) -> Mark {
        let is_neighbor = self.neighbors.contains(t.kind);
        let height = t.box_img.bottom_px - t.box_img.top_px;
        let is_low = if self.level.is_inclusive {
            height < self.level.min_height_px
        } else {
            height <= self.level.min_height_px
        };
        let is_hard =
            t.occlusion_level > self.level.max_occlusion_level || t.truncation > self.level.max_truncation || is_low;
        match (self.kinds.contains(t.kind), is_neighbor) {
            (true, _) if !is_hard && !t.is_optional => Mark::Counts,
            (true, _) | (_, true) => Mark::Ignored,
            _ => Mark::Unrelated,
        }
    }

    fn detection_mark(&self, d: &Detection) -> Mark {
        if (d.box_img.top_px - d.box_img.bottom_px).abs() < self.level.min_height_px {
            Mark::Ignored
        } else if self.kinds.contains(d.kind) {
            Mark::Counts
        } else {
            Mark::Unrelated
        }
    }

    fn overlap(&self, t: &Truth, d: &Detection) -> f64 {
        match self.metric {
            Metric::Image => t.box_img.iou(&d.box_img),
            Metric::Bev => iou_bev(&t.box_cam, &d.box_cam),
            Metric::Volume => iou_3d(&t.box_cam, &d.box_cam),
        }
    }

    fn is_stuff(&self, frame: &FramePair, d: &Detection) -> bool {
        frame.truths.iter().filter(|t| t.kind == ObjectType::DontCare).any(|region| {
            let share = match self.metric {
                Metric::Image => region.box_img.intersection_px2(&d.box_img) / d.box_img.area_px2(),
                Metric::Bev => intersection_bev_m2(&region.box_cam, &d.box_cam) / d.box_cam.area_bev_m2(),
                Metric::Volume => 0.0,
            };
            share > self.limit
        })
    }

    fn first_pass(&self, frame: &FramePair) -> Vec<f64> {
        let mut taken = vec![false; frame.detections.len()];
        let mut scores = Vec::new();
        for t in &frame.truths {
            let mark = self.truth_mark(t);
            if mark == Mark::Unrelated {
                continue;
            }
            let mut best: Option<usize> = None;
            for (j, d) in frame.detections.iter().enumerate() {
                if self.detection_mark(d) == Mark::Unrelated || taken[j] || self.overlap(t, d) <= self.limit {
                    continue;
                }
                if best.is_none_or(|b| d.score > frame.detections[b].score) {
                    best = Some(j);
                }
            }
            if let Some(j) = best {
                taken[j] = true;
                if mark == Mark::Counts && self.detection_mark(&frame.detections[j]) == Mark::Counts {
                    scores.push(frame.detections[j].score);
                }
            }
        }
        scores
    }

    fn second_pass(&self, frame: &FramePair, threshold: f64) -> (u64, u64, f64) {
        let mut taken = vec![false; frame.detections.len()];
        let (mut tp, mut similarity) = (0, 0.0);
        for t in &frame.truths {
            let mark = self.truth_mark(t);
            if mark == Mark::Unrelated {
                continue;
            }
            let fits = |j: &usize| {
                let d = &frame.detections[*j];
                !taken[*j] && d.score >= threshold && self.overlap(t, d) > self.limit
            };
            let of = |mark: Mark| {
                let marked = move |j: &usize| self.detection_mark(&frame.detections[*j]) == mark;
                (0..frame.detections.len()).filter(fits).filter(marked)
            };
            let mut best: Option<usize> = None;
            for j in of(Mark::Counts) {
                if best.is_none_or(|b| self.overlap(t, &frame.detections[j]) > self.overlap(t, &frame.detections[b])) {
                    best = Some(j);
                }
            }
            let chosen = best.or_else(|| of(Mark::Ignored).next());
            if let (Some(j), Mark::Counts) = (best, mark) {
                tp += 1;
                let d = &frame.detections[j];
                let difference = match self.metric {
                    Metric::Image => t.alpha - d.alpha,
                    _ => t.box_cam.rotation_y - d.box_cam.rotation_y,
                };
                similarity += (1.0 + cos(difference)) / 2.0;
            }
            if let Some(j) = chosen {
                taken[j] = true;
            }
        }
        let is_wrong = |(j, d): &(usize, &Detection)| {
            self.detection_mark(d) == Mark::Counts
                && d.score >= threshold
                && !taken[*j]
                && !d.is_optional
                && !self.is_stuff(frame, d)
        };
        let fp = frame.detections.iter().enumerate().filter(is_wrong).count();
        (tp, fp as u64, similarity)
    }
}
