//! The overlaps of a frame's objects and detections: computed once, read by every class, level and threshold.

use super::metric::Metric;
use super::objects::{Detection, FramePair, ObjectType, Truth};
use super::rotated_iou::{intersection_bev_m2, iou_3d_from, iou_bev_from};

/// A detection that overlaps an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DetectionOverlap {
    /// Index of the detection in its frame.
    pub detection: u32,
    /// Intersection over union, above the lowest limit that any class asks for.
    pub iou: f64,
}

/// The overlaps of one frame in one metric.
#[derive(Debug, Clone, Default)]
struct MetricOverlaps {
    overlaps: Vec<DetectionOverlap>,
    /// Where the overlaps of each object begin, and the end.
    starts: Vec<u32>,
    /// The largest share of each detection in one DontCare region, infinite for an optional one; empty if the frame has
    /// neither.
    covered: Vec<f64>,
}

/// The overlaps of one frame.
#[derive(Debug, Clone, Default)]
pub(super) struct FrameOverlaps {
    tables: [MetricOverlaps; 3],
}

impl FrameOverlaps {
    /// Computes the overlaps above `min_iou` (one a metric) of objects whose kind `is_wanted`.
    pub(super) fn new(frame: &FramePair, min_iou: [f64; 3], is_wanted: impl Fn(ObjectType) -> bool) -> Self {
        let mut tables: [MetricOverlaps; 3] = Default::default();
        for truth in &frame.truths {
            for table in &mut tables {
                table.starts.push(table.overlaps.len() as u32);
            }
            if !is_wanted(truth.kind) {
                continue;
            }
            for (index, detection) in frame.detections.iter().enumerate() {
                for (metric, iou) in ious(truth, detection).into_iter().enumerate() {
                    if iou > min_iou[metric] {
                        tables[metric].overlaps.push(DetectionOverlap { detection: index as u32, iou });
                    }
                }
            }
        }
        for table in &mut tables {
            table.starts.push(table.overlaps.len() as u32);
        }
        for region in frame.truths.iter().filter(|truth| truth.kind == ObjectType::DontCare) {
            for (metric, table) in tables.iter_mut().enumerate() {
                table.covered.resize(frame.detections.len(), 0.0);
                for (most, detection) in table.covered.iter_mut().zip(&frame.detections) {
                    *most = most.max(covered_share(region, detection)[metric]);
                }
            }
        }
        for (index, _) in frame.detections.iter().enumerate().filter(|(_, detection)| detection.is_optional) {
            for table in &mut tables {
                table.covered.resize(frame.detections.len(), 0.0);
                table.covered[index] = f64::INFINITY;
            }
        }
        Self { tables }
    }

    /// The overlaps of an object, in the order of the detections.
    pub(super) fn of(&self, metric: Metric, truth: usize) -> &[DetectionOverlap] {
        let table = &self.tables[metric as usize];
        &table.overlaps[table.starts[truth] as usize..table.starts[truth + 1] as usize]
    }

    /// The largest share of a detection that lies in one DontCare region, infinite for an optional one.
    pub(super) fn covered_share(&self, metric: Metric, detection: usize) -> f64 {
        self.tables[metric as usize].covered.get(detection).copied().unwrap_or(0.0)
    }
}

/// Intersection over union in the image, from above, and of volumes.
fn ious(truth: &Truth, detection: &Detection) -> [f64; 3] {
    let (a, b) = (&truth.box_cam, &detection.box_cam);
    let image = truth.box_img.iou(&detection.box_img);
    let shared = intersection_bev_m2(a, b);
    if shared > 0.0 { [image, iou_bev_from(shared, a, b), iou_3d_from(shared, a, b)] } else { [image, 0.0, 0.0] }
}

/// Intersection over the detection's own size, in the image, from above, and of volumes.
///
/// A region has no place in space, but KITTI's program builds the box of its marks all the same, -1 x -1 m at
/// (-1000, -1000): it covers, from above, a detection that carries the same marks.
fn covered_share(region: &Truth, detection: &Detection) -> [f64; 3] {
    let (a, b) = (&region.box_cam, &detection.box_cam);
    let share = |shared: f64, own: f64| if shared > 0.0 { shared / own } else { 0.0 };
    let image = share(region.box_img.intersection_px2(&detection.box_img), detection.box_img.area_px2());
    let shared = intersection_bev_m2(a, b);
    [image, share(shared, b.area_bev_m2()), share(shared * a.shared_height_m(b), b.volume_m3())]
}
