//! Objects that are labeled: KITTI's classes and the state of an actor.

use strum::{AsRefStr, IntoStaticStr, VariantArray};

use crate::error::{Result, variant};
use crate::material::Semantic;
use crate::math::{DPose3, DVec3};

/// KITTI's object types, in the order of its development kit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, AsRefStr, IntoStaticStr, VariantArray)]
pub enum ObjectClass {
    /// Passenger car.
    Car,
    /// Van.
    Van,
    /// Truck, bus.
    Truck,
    /// A person on foot.
    Pedestrian,
    /// A sitting person.
    #[strum(serialize = "Person_sitting")]
    PersonSitting,
    /// A person on a bicycle.
    Cyclist,
    /// Tram.
    Tram,
    /// Trailers, motorbikes and the like.
    Misc,
}

impl ObjectClass {
    /// The name in KITTI's label files.
    #[must_use]
    pub fn kitti_name(self) -> &'static str {
        self.into()
    }

    /// True for somebody on foot, on a seat, or on a bicycle; false for vehicles.
    #[must_use]
    pub fn is_human(self) -> bool {
        matches!(self, Self::Pedestrian | Self::PersonSitting | Self::Cyclist)
    }

    /// What the semantic image shows of the class.
    #[must_use]
    pub fn semantic(self) -> Semantic {
        match self {
            Self::Car => Semantic::Car,
            Self::Van => Semantic::Van,
            Self::Truck => Semantic::Truck,
            Self::Pedestrian | Self::PersonSitting => Semantic::Person,
            Self::Cyclist => Semantic::Cyclist,
            Self::Tram => Semantic::Tram,
            Self::Misc => Semantic::OtherVehicle,
        }
    }

    /// The class of that name, in any letter case.
    ///
    /// # Errors
    /// [`crate::Error::Unknown`], listing the names that exist.
    pub fn from_name(name: &str) -> Result<Self> {
        variant("class", name, |known| known.eq_ignore_ascii_case(name))
    }
}

/// The box that an annotator would draw round an actor, in the actor's box frame, and from how far: fixed for its life.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnnotatedBox {
    /// Length, width, height.
    pub size_lwh: DVec3,
    /// Its bottom center.
    pub bottom_center_in_box: DVec3,
    /// The greatest depth at which it is drawn, meters: annotators leave out far objects.
    pub farthest_m: f64,
    /// Returns that an annotator needs to draw it.
    pub least_points: usize,
}

/// An end of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyEnd {
    /// Where it heads.
    Front,
    /// The other one.
    Rear,
}

impl BodyEnd {
    /// The end that is nearer to an eye.
    #[must_use]
    pub fn nearer(world_from_box: &DPose3, eye_world: DVec3) -> Self {
        let forward_world = world_from_box.rotation * DVec3::X;
        if forward_world.dot(eye_world - world_from_box.translation) > 0.0 { Self::Front } else { Self::Rear }
    }
}

impl AnnotatedBox {
    /// The box of the true extents.
    #[must_use]
    pub fn exact(size_lwh: DVec3) -> Self {
        Self { size_lwh, bottom_center_in_box: DVec3::ZERO, farthest_m: f64::INFINITY, least_points: 0 }
    }
}

/// What a driver brakes for, or waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BrakesFor {
    /// A vehicle that moves or waits, by its actor's id.
    Vehicle(i32),
    /// Something that stands in the lane for good.
    Obstacle,
    /// A person on the road.
    Person,
    /// A traffic light.
    Light,
    /// Others who cross a junction first, one of them by its actor's id where there is one.
    Junction(Option<i32>),
    /// The end of the road or of the line.
    RoadEnd,
}

impl BrakesFor {
    /// A word for it, and the id of the actor that it is.
    #[must_use]
    pub fn name_and_id(self) -> (&'static str, Option<i32>) {
        match self {
            Self::Vehicle(id) => ("vehicle", Some(id)),
            Self::Obstacle => ("obstacle", None),
            Self::Person => ("person", None),
            Self::Light => ("light", None),
            Self::Junction(id) => ("junction", id),
            Self::RoadEnd => ("road end", None),
        }
    }
}

/// An actor at one instant: what labels are made of.
#[derive(Debug, Clone)]
pub struct ActorState {
    /// At least 1, stable within an episode.
    pub id: i32,
    /// KITTI's class.
    pub class: ObjectClass,
    /// The model's name, for example `"saloon/17"`.
    pub model: String,
    /// Length, width, height of the actor's box, fixed for its life.
    pub size_lwh: DVec3,
    /// What an annotator would draw instead, who sees the end that faced the ego when the actor was first labeled.
    pub annotated: AnnotatedBox,
    /// The box frame: x forward, y left, z up, origin at the box's **bottom center**.
    pub world_from_box: DPose3,
    /// Velocity of the box's origin, m/s.
    pub velocity_world: DVec3,
    /// Angular velocity of the box, rad/s; 0 for people, whose turns take longer than a scan.
    pub angular_velocity_world: DVec3,
    /// What its driver brakes for most; `None` where the way is free, and of what nobody drives.
    pub brakes_for: Option<BrakesFor>,
}

impl ActorState {
    /// The box's geometric center.
    #[must_use]
    pub fn center_world(&self) -> DVec3 {
        self.world_of(&AnnotatedBox::exact(self.size_lwh))
    }

    /// The geometric center of a box that is given in the actor's box frame.
    #[must_use]
    pub fn world_of(&self, own: &AnnotatedBox) -> DVec3 {
        let center = own.bottom_center_in_box + DVec3::new(0.0, 0.0, own.size_lwh.z / 2.0);
        self.world_from_box.translation + self.world_from_box.rotation * center
    }
}
