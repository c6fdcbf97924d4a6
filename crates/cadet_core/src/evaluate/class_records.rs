//! The objects and detections of one class, packed frame by frame: what is read for each level, metric and pass.
//!
//! The frames themselves are several megabytes, too many to go through dozens of times.

use super::metric::{ClassLimits, Metric};
use super::objects::FramePair;
use super::overlaps::FrameOverlaps;

/// An object of the class or of its neighbors.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClassObject {
    /// Its index in the frame.
    pub truth: u32,
    /// Whether a level may ask for it.
    pub is_wanted: bool,
    pub height_px: f64,
    pub occlusion_level: f64,
    pub truncation: f64,
}

/// A detection of the class.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClassDetection {
    pub score: f64,
    pub height_px: f64,
    /// Its largest share in one DontCare region, by metric.
    pub covered_share: [f64; 3],
}

/// Rows of all frames one after the other.
#[derive(Debug)]
struct Rows<T> {
    rows: Vec<T>,
    starts: Vec<u32>,
}

impl<T> Rows<T> {
    fn collect<I: Iterator<Item = T>>(frames: impl Iterator<Item = I>) -> Self {
        let (mut rows, mut starts) = (Vec::new(), vec![0]);
        for frame in frames {
            rows.extend(frame);
            starts.push(rows.len() as u32);
        }
        Self { rows, starts }
    }

    fn of(&self, frame: usize) -> &[T] {
        &self.rows[self.starts[frame] as usize..self.starts[frame + 1] as usize]
    }
}

/// A class in all frames.
#[derive(Debug)]
pub(super) struct ClassRecords {
    class_objects: Rows<ClassObject>,
    class_detections: Rows<ClassDetection>,
}

impl ClassRecords {
    pub(super) fn new(class: &ClassLimits, frames: &[FramePair], overlaps: &[FrameOverlaps]) -> Self {
        let class_objects = Rows::collect(frames.iter().map(|frame| {
            let all = frame.truths.iter().enumerate();
            let taking_part = all.filter(|(_, t)| class.kinds.contains(t.kind) || class.neighbors.contains(t.kind));
            taking_part.map(|(index, t)| ClassObject {
                truth: index as u32,
                is_wanted: class.kinds.contains(t.kind) && !t.is_optional,
                height_px: t.box_img.bottom_px - t.box_img.top_px,
                occlusion_level: t.occlusion_level,
                truncation: t.truncation,
            })
        }));
        let class_detections = Rows::collect(frames.iter().zip(overlaps).map(|(frame, overlaps)| {
            let own = frame.detections.iter().enumerate().filter(|(_, d)| class.kinds.contains(d.kind));
            own.map(|(index, d)| ClassDetection {
                score: d.score,
                height_px: d.height_px(),
                covered_share: Metric::ALL.map(|metric| overlaps.covered_share(metric, index)),
            })
        }));
        Self { class_objects, class_detections }
    }

    /// The objects of a frame, in file order.
    pub(super) fn class_objects(&self, frame: usize) -> &[ClassObject] {
        self.class_objects.of(frame)
    }

    /// The detections of a frame, in file order.
    pub(super) fn class_detections(&self, frame: usize) -> &[ClassDetection] {
        self.class_detections.of(frame)
    }
}
