//! What is compared: the labeled objects and the detections of a frame.

use super::rotated_iou::BoxCam;

/// The type of an object as the evaluation tells them apart. Names are compared without letter case, as KITTI does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Kind {
    /// A car.
    Car,
    /// A van: a neighbor of [`Kind::Car`].
    Van,
    /// A truck.
    Truck,
    /// A walker.
    Pedestrian,
    /// A sitting person: a neighbor of [`Kind::Pedestrian`].
    PersonSitting,
    /// A rider and the bicycle.
    Cyclist,
    /// A tram.
    Tram,
    /// Anything else that is labeled.
    Misc,
    /// A region that nobody labeled.
    DontCare,
    /// A name that KITTI does not have.
    Unknown,
}

/// The names that KITTI writes, in the order of [`Kind`].
const NAMES: [(&str, Kind); 9] = [
    ("Car", Kind::Car),
    ("Van", Kind::Van),
    ("Truck", Kind::Truck),
    ("Pedestrian", Kind::Pedestrian),
    ("Person_sitting", Kind::PersonSitting),
    ("Cyclist", Kind::Cyclist),
    ("Tram", Kind::Tram),
    ("Misc", Kind::Misc),
    ("DontCare", Kind::DontCare),
];

impl Kind {
    /// The type of a name in any letter case; [`Kind::Unknown`] for what KITTI does not have.
    #[must_use]
    pub fn from_name(name: &str) -> Self {
        NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map_or(Self::Unknown, |&(_, kind)| kind)
    }

    /// The name as KITTI writes it, `"unknown"` for [`Kind::Unknown`].
    #[must_use]
    pub fn name(self) -> &'static str {
        NAMES.iter().find(|(_, kind)| *kind == self).map_or("unknown", |&(name, _)| name)
    }

    /// The type whose objects are so alike that taking them for this class is neither right nor wrong.
    #[must_use]
    pub fn neighbor(self) -> Option<Self> {
        match self {
            Self::Car => Some(Self::Van),
            Self::Pedestrian => Some(Self::PersonSitting),
            _ => None,
        }
    }
}

/// A set of types.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Kinds(u16);

impl Kinds {
    /// Whether a type is one of these.
    #[must_use]
    pub fn contains(self, kind: Kind) -> bool {
        self.0 & (1 << kind as u8) != 0
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether a type is in both.
    #[must_use]
    pub fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

impl FromIterator<Kind> for Kinds {
    fn from_iter<I: IntoIterator<Item = Kind>>(kinds: I) -> Self {
        Self(kinds.into_iter().fold(0, |bits, kind| bits | 1 << kind as u8))
    }
}

/// An upright rectangle of the image, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxImg {
    /// Left edge.
    pub x1: f64,
    /// Upper edge.
    pub y1: f64,
    /// Right edge.
    pub x2: f64,
    /// Lower edge.
    pub y2: f64,
}

impl BoxImg {
    /// The area in square pixels, as KITTI computes it: no pixel is added to a side.
    #[must_use]
    pub fn area(&self) -> f64 {
        (self.x2 - self.x1) * (self.y2 - self.y1)
    }

    /// The area shared with another rectangle, 0 where they only touch.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> f64 {
        let width = self.x2.min(other.x2) - self.x1.max(other.x1);
        let height = self.y2.min(other.y2) - self.y1.max(other.y1);
        if width <= 0.0 || height <= 0.0 { 0.0 } else { width * height }
    }

    /// Intersection over union.
    #[must_use]
    pub fn iou(&self, other: &Self) -> f64 {
        let shared = self.intersection(other);
        if shared > 0.0 { shared / (self.area() + other.area() - shared) } else { 0.0 }
    }
}

/// An object of the ground truth: a line of a label file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Its type.
    pub kind: Kind,
    /// Share outside the image, 0..1; -1 unknown.
    pub truncated: f64,
    /// Occlusion level, 0 visible .. 3 unknown; -1 in regions that nobody labeled.
    pub occluded: f64,
    /// Observation angle in radians.
    pub alpha: f64,
    /// Rectangle in the image.
    pub box_img: BoxImg,
    /// Box in the rectified camera frame.
    pub box_cam: BoxCam,
    /// Whether it may be found but need not, at any level. No file says so.
    pub is_optional: bool,
}

/// A detection: a line of a result file. Truncation and occlusion of detections are not used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Its type.
    pub kind: Kind,
    /// Observation angle in radians, -10 unknown.
    pub alpha: f64,
    /// Rectangle in the image.
    pub box_img: BoxImg,
    /// Box in the rectified camera frame.
    pub box_cam: BoxCam,
    /// Confidence: any number above [`MIN_SCORE`], higher is surer.
    pub score: f64,
    /// Whether it is no false positive where it finds nothing. No file says so.
    pub is_optional: bool,
}

impl Detection {
    /// Height of the rectangle in the image, in pixels, also of one that stands on its head.
    #[must_use]
    pub fn height_px(&self) -> f64 {
        (self.box_img.y2 - self.box_img.y1).abs()
    }
}

/// KITTI's program never matches a detection whose score is not above this.
pub const MIN_SCORE: f64 = -1e7;

/// One frame: what is there and what was found, both in file order, which breaks ties.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FramePair {
    /// The ground truth.
    pub truths: Vec<Truth>,
    /// The detections.
    pub detections: Vec<Detection>,
}
