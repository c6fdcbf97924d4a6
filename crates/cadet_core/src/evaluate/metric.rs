//! Settings of an evaluation: what it measures, for which classes, and how strictly.

use super::objects::{ObjectType, ObjectTypes};
use cadet_base::error::{Error, Result};

/// How overlap is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Metric {
    /// Rectangles in the image.
    Image = 0,
    /// Rotated rectangles seen from above.
    Bev = 1,
    /// Volumes.
    Volume = 2,
}

impl Metric {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Image, Self::Bev, Self::Volume];
}

/// Which objects of a class must be found; what is easier than a level's limits still counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Height of the rectangle in the image, in pixels. Lower detections are neither right nor wrong.
    pub min_height_px: f64,
    /// Whether an object of exactly the least height belongs to the level. In KITTI it does not.
    pub is_inclusive: bool,
    /// The largest occlusion level, infinite for none.
    pub max_occlusion_level: f64,
    /// The largest truncation, infinite for none.
    pub max_truncation: f64,
}

/// A class and the overlaps that its detections must exceed.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassLimits {
    /// The types that belong to it; a detection of any of them may find an object of any.
    pub kinds: ObjectTypes,
    /// The types of objects that are so alike that taking them for this class is neither right nor wrong.
    pub neighbors: ObjectTypes,
    /// By metric; each in [0, 1).
    pub min_overlap: [f64; 3],
}

impl ClassLimits {
    /// A class of one type and its neighbor in KITTI.
    #[must_use]
    pub fn of(kind: ObjectType, min_overlap: [f64; 3]) -> Self {
        Self { kinds: ObjectTypes::from_iter([kind]), neighbors: kind.neighbor().into_iter().collect(), min_overlap }
    }
}

/// What to evaluate.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The classes, each once.
    pub classes: Vec<ClassLimits>,
    /// The levels.
    pub levels: Vec<Level>,
}

impl Settings {
    /// Refuses settings that make no sense.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] and [`Error::Unknown`], naming what is wrong.
    pub fn check(&self) -> Result<()> {
        for limits in &self.classes {
            if limits.kinds.contains(ObjectType::DontCare) || limits.neighbors.contains(ObjectType::DontCare) {
                return Err(Error::Unknown {
                    what: "class",
                    name: "DontCare".to_owned(),
                    known: "Car, Van, Truck, Pedestrian, Person_sitting, Cyclist, Tram, Misc, others".to_owned(),
                });
            }
            if limits.kinds.is_empty() {
                return Err(out_of_range("types of a class", "none", "at least one"));
            }
            if limits.kinds.intersects(&limits.neighbors) {
                return Err(out_of_range("neighbors of a class", "one of its own types", "other types"));
            }
            if let Some(limit) = limits.min_overlap.iter().find(|limit| !(0.0..1.0).contains(*limit)) {
                return Err(out_of_range("min_overlap", limit, "0 <= overlap < 1"));
            }
        }
        for level in &self.levels {
            if !(level.min_height_px >= 0.0 && level.min_height_px.is_finite()) {
                return Err(out_of_range("min_height_px", level.min_height_px, "a number of at least 0"));
            }
            if level.max_occlusion_level.is_nan() || level.max_truncation.is_nan() {
                return Err(out_of_range("a level's limit", "NaN", "a number"));
            }
        }
        Ok(())
    }

    /// The lowest overlap that any class asks for, by metric.
    pub(super) fn least_min_overlap(&self) -> [f64; 3] {
        std::array::from_fn(|metric| self.classes.iter().map(|c| c.min_overlap[metric]).fold(1.0, f64::min))
    }

    /// Whether objects of this kind take part, as a class or a neighbor of one.
    pub(super) fn wants(&self, kind: ObjectType) -> bool {
        self.classes.iter().any(|limits| limits.kinds.contains(kind) || limits.neighbors.contains(kind))
    }
}

fn out_of_range(what: &'static str, value: impl ToString, expected: &str) -> Error {
    Error::OutOfRange { what, value: value.to_string(), expected: expected.to_owned() }
}
