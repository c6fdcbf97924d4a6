//! Boxes as KITTI's annotators drew them: the sizes of each class, and how far the true body reaches beyond them.
//!
//! The mixtures are fits to every label of KITTI's 7,481 training frames (28,742 cars, 2,914 vans, 4,487
//! pedestrians, 1,627 cyclists).
//! The margins are such that the returns of cars lie in their boxes where those of 568 real frames do: annotators drew
//! a box before what they saw of its near end, and let it end early at the far one.

pub(super) mod sizes;
#[cfg(test)]
mod tests;

use cadet_base::actor::{AnnotatedBox, BodyEnd, ObjectClass};
use cadet_base::error::{Error, Result};
use cadet_base::math::{DVec2, DVec3};
use cadet_base::rng::Stream;

use sizes::{CARS, CYCLISTS, MISC, Mixture, PEOPLE, SITTERS, TRUCKS, VANS};

/// How far a body reaches beyond its annotated box, meters; negative where it ends inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    front_m: f64,
    rear_m: f64,
    left_m: f64,
    right_m: f64,
    top_m: f64,
    /// The box's bottom over the ground.
    bottom_m: f64,
    /// The greatest depth at which the box is drawn.
    farthest_m: f64,
    /// Returns that it takes to draw the box.
    least_points: usize,
}

/// Mean and standard deviation of a vehicle's margins at its ends, each side and above; the ends' before the box is
/// displaced.
const VEHICLE_END_M: (f64, f64) = (0.10, 0.07);
const VEHICLE_SIDE_M: (f64, f64) = (-0.01, 0.04);
const VEHICLE_TOP_M: (f64, f64) = (-0.012, 0.01);
/// How far a vehicle's box is displaced toward the ego: where the front is near, and where the rear is. Its near end then
/// stands 6 or 3.5 cm before the body's, its far end 26 or 23.5 cm inside: KITTI's boxes are shorter than catalogs' cars.
const FRONT_NEAR_M: f64 = 0.16;
const REAR_NEAR_M: f64 = 0.135;
/// The bottoms of KITTI's cars lie this far over the ground beside them: 63 cars and vans of 45 real frames.
const VEHICLE_BOTTOM_M: (f64, f64) = (0.045, 0.025);
/// The greatest depth at which an object is labeled: 95 % of KITTI's cars lie within 59 m, of its vans within 70 m, of
/// its pedestrians within 38 m, though more of them are seen farther away.
const CAR_FARTHEST_M: (f64, f64) = (70.0, 12.0);
const VAN_FARTHEST_M: (f64, f64) = (74.0, 8.0);
/// 95 % of the trams lie within 90 m.
const TRAM_FARTHEST_M: (f64, f64) = (92.0, 6.0);
/// 95 % of the trucks lie within 77 m, of what is Misc within 65 m.
const TRUCK_FARTHEST_M: (f64, f64) = (82.0, 6.0);
const MISC_FARTHEST_M: (f64, f64) = (70.0, 8.0);
const PERSON_FARTHEST_M: (f64, f64) = (36.0, 10.0);
/// Of the people who sit, 95 % within 21 m, none beyond 26 m.
const SITTER_FARTHEST_M: (f64, f64) = (21.0, 4.0);
/// Annotators drew boxes round points: of KITTI's cars at 40 to 50 m, 95 in a hundred have at least 4.
const LEAST_POINTS: (usize, usize) = (2, 6);
/// Boxes are placed too high or too low as wholes, too.
const VERTICAL_SD_M: f64 = 0.025;
/// Mean and standard deviation of how far forward a box stands on somebody. A walker's bounds reach farther ahead, where the
/// toes are, than their bulk, which KITTI's annotators put in the middle: of 10 real people the returns lie 0.066 m (+- 0.02)
/// farther forward in their boxes than ours did in those bounds.
const WALKER_FORWARD_M: (f64, f64) = (-0.065, 0.045);
const RIDER_FORWARD_M: (f64, f64) = (0.0, 0.03);
const PERSON_ASIDE_SD_M: f64 = 0.03;
/// How far the box of somebody on foot is displaced toward the ego: 0.054 m (+- 0.02) of the same 10.
const WALKER_NEAR_M: f64 = 0.05;
/// KITTI's boxes of people are of two lengths: about 0.5 m and about 0.95 m.
const SHORTEST_STRIDE_M: f64 = 0.7;
/// How much farther than its box a walker reaches: heels and toes lie beyond what annotators take for the body.
const WALKER_LONGER_M: f64 = 0.085;
const PERSON_TOP_M: (f64, f64) = (-0.02, 0.01);
const PERSON_BOTTOM_M: (f64, f64) = (0.035, 0.02);
/// 95 % of KITTI's cyclists lie within 53 m.
const CYCLIST_FARTHEST_M: (f64, f64) = (52.0, 10.0);
/// How much longer and wider a cyclist is than its box.
const CYCLIST_LONGER_M: (f64, f64) = (0.02, 0.04);
const CYCLIST_WIDER_M: (f64, f64) = (0.02, 0.03);

impl Margins {
    /// Draws those of a vehicle; what is no car is large and labeled from farther away.
    #[must_use]
    pub fn of_vehicle(class: ObjectClass, s: &mut Stream) -> Self {
        let mut draw = |(mean, sd): (f64, f64)| s.clipped_normal(mean, sd);
        let raised = draw((0.0, VERTICAL_SD_M));
        Self {
            front_m: draw(VEHICLE_END_M),
            rear_m: draw(VEHICLE_END_M),
            left_m: draw(VEHICLE_SIDE_M),
            right_m: draw(VEHICLE_SIDE_M),
            top_m: draw(VEHICLE_TOP_M) - raised,
            bottom_m: draw(VEHICLE_BOTTOM_M) + raised,
            farthest_m: draw(match class {
                ObjectClass::Car => CAR_FARTHEST_M,
                ObjectClass::Truck => TRUCK_FARTHEST_M,
                ObjectClass::Misc => MISC_FARTHEST_M,
                ObjectClass::Tram => TRAM_FARTHEST_M,
                _ => VAN_FARTHEST_M,
            }),
            least_points: least_points(s),
        }
    }

    /// What the extents of vehicles exceed their annotated sizes by in the mean: length, width, height.
    #[must_use]
    pub fn mean_of_vehicles() -> [f64; 3] {
        [2.0 * VEHICLE_END_M.0, 2.0 * VEHICLE_SIDE_M.0, VEHICLE_TOP_M.0 + VEHICLE_BOTTOM_M.0]
    }

    /// The true length, width and height of a body whose annotated size is `annotated_lwh`.
    #[must_use]
    pub fn around(&self, annotated_lwh: DVec3) -> DVec3 {
        annotated_lwh + self.sums()
    }

    /// The annotated box of a body that fills `true_lwh`.
    #[must_use]
    pub fn within(&self, true_lwh: DVec3) -> AnnotatedBox {
        let (x, y) = ((self.rear_m - self.front_m) / 2.0, (self.right_m - self.left_m) / 2.0);
        AnnotatedBox {
            size_lwh: true_lwh - self.sums(),
            bottom_center_in_box: DVec3::new(x, y, self.bottom_m),
            farthest_m: self.farthest_m,
            least_points: self.least_points,
        }
    }

    fn sums(&self) -> DVec3 {
        DVec3::new(self.front_m + self.rear_m, self.left_m + self.right_m, self.top_m + self.bottom_m)
    }
}

/// The box as it is drawn by annotators to whom one of the ends is near.
#[must_use]
pub fn displaced(annotated: AnnotatedBox, class: ObjectClass, near: BodyEnd) -> AnnotatedBox {
    let ahead_m = match (class, near) {
        // Of the returns of cyclists two samples say opposite things; of people who sit there are none.
        (ObjectClass::PersonSitting | ObjectClass::Cyclist, _) => 0.0,
        (ObjectClass::Pedestrian, BodyEnd::Front) => WALKER_NEAR_M,
        (ObjectClass::Pedestrian, BodyEnd::Rear) => -WALKER_NEAR_M,
        (_, BodyEnd::Front) => FRONT_NEAR_M,
        (_, BodyEnd::Rear) => -REAR_NEAR_M,
    };
    let bottom_center_in_box = annotated.bottom_center_in_box + DVec3::new(ahead_m, 0.0, 0.0);
    AnnotatedBox { bottom_center_in_box, ..annotated }
}

/// The annotated length, width and height of a vehicle.
///
/// # Errors
/// [`Error::Scene`] for a class that has no shapes.
pub fn vehicle_size(class: ObjectClass, s: &mut Stream) -> Result<DVec3> {
    match class {
        ObjectClass::Car => Ok(CARS.draw(s)),
        ObjectClass::Van => Ok(VANS.draw(s)),
        ObjectClass::Truck => Ok(TRUCKS.draw(s)),
        ObjectClass::Misc => Ok(MISC.draw(s)),
        other => Err(no_such_vehicle(other)),
    }
}

/// The error of asking for a vehicle of a class that has no shapes.
pub(super) fn no_such_vehicle(class: ObjectClass) -> Error {
    Error::Scene {
        reason: format!("no vehicle of class {} is drawn by its size: Car, Van, Truck or Misc", class.kitti_name()),
    }
}

/// The annotated box of a person, in the box frame. It is drawn first: [`person_height_m`] tells how tall that one is.
#[must_use]
pub fn person_box(s: &mut Stream) -> AnnotatedBox {
    box_round(&PEOPLE, WALKER_FORWARD_M, PERSON_FARTHEST_M, s)
}

/// The annotated box of a cyclist, in the box frame. It is drawn first: [`cyclist_size`] tells how long, wide, and high
/// that cyclist is.
#[must_use]
pub fn cyclist_box(s: &mut Stream) -> AnnotatedBox {
    box_round(&CYCLISTS, RIDER_FORWARD_M, CYCLIST_FARTHEST_M, s)
}

/// The length, width, and height of a cyclist of a given annotated box.
#[must_use]
pub fn cyclist_size(annotated: &AnnotatedBox, s: &mut Stream) -> DVec3 {
    let mut more = |(mean, sd): (f64, f64)| s.clipped_normal(mean, sd);
    let (longer_m, wider_m) = (more(CYCLIST_LONGER_M), more(CYCLIST_WIDER_M));
    let height_m = person_height_m(annotated, s);
    DVec3::new(annotated.size_lwh.x + longer_m, annotated.size_lwh.y + wider_m, height_m)
}

fn box_round(sizes: &Mixture, forward_m: (f64, f64), farthest_m: (f64, f64), s: &mut Stream) -> AnnotatedBox {
    let size_lwh = sizes.draw(s);
    let mut place = |mean: f64, sd: f64| s.clipped_normal(mean, sd);
    let bottom_center_in_box = DVec3::new(
        place(forward_m.0, forward_m.1),
        place(0.0, PERSON_ASIDE_SD_M),
        place(PERSON_BOTTOM_M.0, PERSON_BOTTOM_M.1),
    );
    let farthest_m = place(farthest_m.0, farthest_m.1);
    AnnotatedBox { size_lwh, bottom_center_in_box, farthest_m, least_points: least_points(s) }
}

/// The annotated box of a person who sits, in the box frame.
#[must_use]
pub fn sitting_box(s: &mut Stream) -> AnnotatedBox {
    box_round(&SITTERS, RIDER_FORWARD_M, SITTER_FARTHEST_M, s)
}

/// The height that somebody who sits has when they stand: those of high boxes are tall, but boxes differ more than people.
#[must_use]
pub fn sitting_stature_m(annotated: &AnnotatedBox, s: &mut Stream) -> f64 {
    (1.60 + 1.1 * (annotated.size_lwh.z - 1.26) + s.clipped_normal(0.0, 0.04)).clamp(1.50, 1.92)
}

/// The box of a person or rider of known extents: these, drawn from as far and from as few returns as others of the
/// class.
#[must_use]
pub fn box_of_figure(class: ObjectClass, true_lwh: DVec3, s: &mut Stream) -> AnnotatedBox {
    let AnnotatedBox { farthest_m, least_points, .. } = match class {
        ObjectClass::Cyclist => cyclist_box(s),
        ObjectClass::PersonSitting => sitting_box(s),
        _ => person_box(s),
    };
    AnnotatedBox { farthest_m, least_points, ..AnnotatedBox::exact(true_lwh) }
}

fn least_points(s: &mut Stream) -> usize {
    LEAST_POINTS.0 + s.below(LEAST_POINTS.1 - LEAST_POINTS.0 + 1)
}

/// Whether the person of an annotated box stands: 27 % of KITTI's boxes of people are too short for a stride.
#[must_use]
pub fn is_standing(annotated: &AnnotatedBox) -> bool {
    annotated.size_lwh.x < SHORTEST_STRIDE_M
}

/// The length and width of the body that an annotated box is drawn around: KITTI's boxes keep their size over a track, so
/// a walker's holds the whole stride.
#[must_use]
pub fn person_extents(annotated: &AnnotatedBox) -> DVec2 {
    let longer_m = if is_standing(annotated) { 0.0 } else { WALKER_LONGER_M };
    annotated.size_lwh.truncate() + DVec2::new(longer_m, 0.0)
}

/// The height of a person, from shoes to hair, of a given annotated box.
#[must_use]
pub fn person_height_m(annotated: &AnnotatedBox, s: &mut Stream) -> f64 {
    annotated.size_lwh.z + annotated.bottom_center_in_box.z + s.clipped_normal(PERSON_TOP_M.0, PERSON_TOP_M.1)
}
