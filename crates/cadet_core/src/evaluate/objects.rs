//! The two sides of a comparison: the labeled objects and the detections of a frame.

use std::collections::BTreeMap;

use super::rotated_iou::RotatedBox;

/// The type of an object as the evaluation tells them apart. Names are compared without letter case, as KITTI does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ObjectType {
    /// A car.
    Car,
    /// A van: a neighbor of [`ObjectType::Car`].
    Van,
    /// A truck.
    Truck,
    /// A walker.
    Pedestrian,
    /// A sitting person: a neighbor of [`ObjectType::Pedestrian`].
    PersonSitting,
    /// A rider and the bicycle.
    Cyclist,
    /// A tram.
    Tram,
    /// Anything else that is labeled.
    Misc,
    /// A region that nobody labeled.
    DontCare,
    /// A name that KITTI does not have, by its hash.
    Other(u64),
}

/// The names that KITTI writes, in the order of [`ObjectType`].
const NAMES: [(&str, ObjectType); 9] = [
    ("Car", ObjectType::Car),
    ("Van", ObjectType::Van),
    ("Truck", ObjectType::Truck),
    ("Pedestrian", ObjectType::Pedestrian),
    ("Person_sitting", ObjectType::PersonSitting),
    ("Cyclist", ObjectType::Cyclist),
    ("Tram", ObjectType::Tram),
    ("Misc", ObjectType::Misc),
    ("DontCare", ObjectType::DontCare),
];

impl ObjectType {
    /// The type of a name in any letter case; [`ObjectType::Other`] for what KITTI does not have.
    #[must_use]
    pub fn from_name(name: &str) -> Self {
        let known = NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        known.map_or_else(|| Self::Other(hash(name)), |&(_, kind)| kind)
    }

    /// The name as KITTI writes it; None for [`ObjectType::Other`].
    #[must_use]
    pub fn name(self) -> Option<&'static str> {
        NAMES.iter().find(|(_, kind)| *kind == self).map(|&(name, _)| name)
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

/// FNV-1a of a name in small letters.
fn hash(name: &str) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte.to_ascii_lowercase())).wrapping_mul(0x0100_0000_01b3);
    name.bytes().fold(0xcbf2_9ce4_8422_2325, step)
}

/// A set of types, of few.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ObjectTypes(Vec<ObjectType>);

impl ObjectTypes {
    /// Whether a type is one of these.
    #[must_use]
    pub fn contains(&self, kind: ObjectType) -> bool {
        self.0.contains(&kind)
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a type is in both.
    #[must_use]
    pub fn intersects(&self, other: &Self) -> bool {
        self.0.iter().any(|&kind| other.contains(kind))
    }
}

impl FromIterator<ObjectType> for ObjectTypes {
    fn from_iter<I: IntoIterator<Item = ObjectType>>(kinds: I) -> Self {
        Self(kinds.into_iter().collect())
    }
}

/// The names of types that KITTI does not have: as each is first spelled, and how many objects have it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct OtherNames(BTreeMap<ObjectType, (String, usize)>);

impl OtherNames {
    /// Counts an object; one of KITTI's types is none of these.
    pub fn count(&mut self, kind: ObjectType, name: &str) {
        if let ObjectType::Other(_) = kind {
            self.0.entry(kind).or_insert_with(|| (name.to_owned(), 0)).1 += 1;
        }
    }

    /// Adds the counts of other objects.
    pub fn merge(&mut self, other: Self) {
        for (kind, (name, count)) in other.0 {
            self.0.entry(kind).or_insert((name, 0)).1 += count;
        }
    }

    /// The name of a type: KITTI's or one of these; empty for one that was never counted.
    #[must_use]
    pub fn name(&self, kind: ObjectType) -> &str {
        kind.name().or_else(|| self.0.get(&kind).map(|(name, _)| name.as_str())).unwrap_or_default()
    }

    /// The names and how many objects have each.
    pub fn iter(&self) -> impl Iterator<Item = (ObjectType, &str, usize)> {
        self.0.iter().map(|(&kind, (name, count))| (kind, name.as_str(), *count))
    }
}

/// An upright rectangle of the image, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxImg {
    /// Left edge.
    pub left_px: f64,
    /// Upper edge.
    pub top_px: f64,
    /// Right edge.
    pub right_px: f64,
    /// Lower edge.
    pub bottom_px: f64,
}

impl BoxImg {
    /// The area in square pixels, as KITTI computes it: no pixel is added to a side.
    #[must_use]
    pub fn area_px2(&self) -> f64 {
        (self.right_px - self.left_px) * (self.bottom_px - self.top_px)
    }

    /// Whether nothing lies inside, as in what is written where no rectangle is known: `0 0 0 0`, `-1 -1 -1 -1`.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.left_px == self.right_px || self.top_px == self.bottom_px
    }

    /// The area shared with another rectangle, 0 where they only touch.
    #[must_use]
    pub fn intersection_px2(&self, other: &Self) -> f64 {
        let width = self.right_px.min(other.right_px) - self.left_px.max(other.left_px);
        let height = self.bottom_px.min(other.bottom_px) - self.top_px.max(other.top_px);
        if width <= 0.0 || height <= 0.0 { 0.0 } else { width * height }
    }

    /// Intersection over union.
    #[must_use]
    pub fn iou(&self, other: &Self) -> f64 {
        let shared = self.intersection_px2(other);
        if shared > 0.0 { shared / (self.area_px2() + other.area_px2() - shared) } else { 0.0 }
    }
}

/// An object of the ground truth: a line of a label file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Its type.
    pub kind: ObjectType,
    /// Share outside the image, 0..1; -1 unknown.
    pub truncation: f64,
    /// Occlusion level, 0 visible .. 3 unknown; -1 in regions that nobody labeled.
    pub occlusion_level: f64,
    /// Observation angle in radians.
    pub alpha: f64,
    /// Rectangle in the image.
    pub box_img: BoxImg,
    /// Box in the rectified camera frame.
    pub box_cam: RotatedBox,
    /// Whether it may be found but need not, at any level. No file says so.
    pub is_optional: bool,
}

/// A detection: a line of a result file. Truncation and occlusion of detections are not used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Its type.
    pub kind: ObjectType,
    /// Observation angle in radians, -10 unknown.
    pub alpha: f64,
    /// Rectangle in the image.
    pub box_img: BoxImg,
    /// Box in the rectified camera frame.
    pub box_cam: RotatedBox,
    /// Confidence: any number above [`MIN_SCORE`], higher is surer.
    pub score: f64,
    /// Whether it is no false positive where it finds nothing. No file says so.
    pub is_optional: bool,
}

impl Detection {
    /// Height of the rectangle in the image, in pixels, also of one that stands on its head.
    #[must_use]
    pub fn height_px(&self) -> f64 {
        (self.box_img.bottom_px - self.box_img.top_px).abs()
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
