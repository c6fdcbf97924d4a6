//! How many objects and detections have no height in the image, by which KITTI's rules choose what counts.

use super::metric::{ClassLimits, Settings};
use super::objects::FramePair;

/// Counts among the types of the classes that are evaluated.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Sight {
    /// The classes of whose types there is neither an object nor a detection.
    pub absent_classes: Vec<usize>,
    /// Objects.
    pub num_truths: usize,
    /// Objects without a rectangle: no level with a least height asks for them.
    pub num_truths_without_box: usize,
    /// Detections.
    pub num_detections: usize,
    /// Detections lower than every level asks for: they are neither right nor wrong.
    pub num_low_detections: usize,
    /// Those of them without a rectangle.
    pub num_detections_without_box: usize,
}

/// Counts what can be told by its height in the image, and what can not.
#[must_use]
pub fn sight(frames: &[FramePair], settings: &Settings) -> Sight {
    let least_px = settings.levels.iter().map(|level| level.min_height_px).fold(f64::INFINITY, f64::min);
    let is_own = |kind| settings.classes.iter().any(|class| class.kinds.contains(kind));
    let is_there = |class: &ClassLimits| {
        let has = |frame: &FramePair| {
            frame.truths.iter().any(|truth| class.kinds.contains(truth.kind))
                || frame.detections.iter().any(|detection| class.kinds.contains(detection.kind))
        };
        frames.iter().any(has)
    };
    let absent = settings.classes.iter().enumerate().filter(|(_, class)| !is_there(class)).map(|(index, _)| index);
    let mut sight = Sight { absent_classes: absent.collect(), ..Sight::default() };
    for frame in frames {
        for truth in frame.truths.iter().filter(|truth| is_own(truth.kind)) {
            sight.num_truths += 1;
            sight.num_truths_without_box += usize::from(least_px > 0.0 && truth.box_img.is_empty());
        }
        for detection in frame.detections.iter().filter(|detection| is_own(detection.kind)) {
            let is_low = detection.height_px() < least_px;
            sight.num_detections += 1;
            sight.num_low_detections += usize::from(is_low);
            sight.num_detections_without_box += usize::from(is_low && detection.box_img.is_empty());
        }
    }
    sight
}
