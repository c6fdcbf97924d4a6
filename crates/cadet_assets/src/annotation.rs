//! Boxes as KITTI's annotators drew them: the sizes of each class, and how far the true body reaches beyond them.
//!
//! The mixtures are fits to every label of KITTI's 7,481 training frames (28,742 cars, 2,914 vans, 4,487
//! pedestrians, 1,627 cyclists).
//! The margins are such that the returns of cars lie in their boxes where those of 568 real frames do: annotators drew
//! a box before what they saw of its near end, and let it end early at the far one.

use cadet_base::actor::{AnnotatedBox, BodyEnd, ObjectClass};
use cadet_base::error::{Error, Result};
use cadet_base::math::{DVec2, DVec3};
use cadet_base::rng::Stream;

use super::annotated_sizes::{CARS, CYCLISTS, MISC, Mixture, PEOPLE, SITTERS, TRUCKS, VANS};

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

#[cfg(test)]
mod tests {
    use super::*;

    fn quantile(values: &mut [f64], share: f64) -> f64 {
        values.sort_by(f64::total_cmp);
        values[(share * values.len() as f64) as usize]
    }

    fn correlation(a: &[f64], b: &[f64]) -> f64 {
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let (ma, mb) = (mean(a), mean(b));
        let sum = |f: &dyn Fn(usize) -> f64| (0..a.len()).map(f).sum::<f64>();
        let cov = sum(&|i| (a[i] - ma) * (b[i] - mb));
        let square = |v: f64| v * v;
        cov / (sum(&|i| square(a[i] - ma)) * sum(&|i| square(b[i] - mb))).sqrt()
    }

    /// Quantiles (5, 16, 50, 84, 95 %) of length, width and height and their correlations (l-w, l-h, w-h), over every
    /// label of KITTI's training set.
    struct Labels {
        quantiles: [[f64; 5]; 3],
        correlations: [f64; 3],
        tolerance_m: [f64; 3],
    }

    fn check_quantiles(sizes: &[DVec3], labels: &[[f64; 5]; 3], tolerance_m: [f64; 3]) {
        for (k, quantiles) in labels.iter().enumerate() {
            let mut axis: Vec<f64> = sizes.iter().map(|s| s[k]).collect();
            for (share, expected) in [0.05, 0.16, 0.5, 0.84, 0.95].iter().zip(quantiles) {
                let got = quantile(&mut axis, *share);
                assert!((got - expected).abs() < tolerance_m[k], "axis {k} at {share}: {got}, labels {expected}");
            }
        }
    }

    fn check(sizes: &[DVec3], labels: &Labels) {
        check_quantiles(sizes, &labels.quantiles, labels.tolerance_m);
        let axes: [Vec<f64>; 3] = std::array::from_fn(|k| sizes.iter().map(|s| s[k]).collect());
        for ((a, b), expected) in [(0, 1), (0, 2), (1, 2)].into_iter().zip(labels.correlations) {
            let got = correlation(&axes[a], &axes[b]);
            assert!((got - expected).abs() < 0.06, "axes {a} and {b}: {got}, labels {expected}");
        }
    }

    #[test]
    fn annotated_sizes_are_those_of_kittis_labels() {
        let sizes = |class| (0..20_000).map(move |k| vehicle_size(class, &mut Stream::from_seed("size", k)).unwrap());
        check(
            &sizes(ObjectClass::Car).collect::<Vec<_>>(),
            &Labels {
                quantiles: [
                    [3.20, 3.46, 3.88, 4.33, 4.52],
                    [1.47, 1.54, 1.63, 1.72, 1.80],
                    [1.36, 1.41, 1.50, 1.64, 1.78],
                ],
                correlations: [0.349, 0.173, 0.305],
                tolerance_m: [0.05, 0.02, 0.03],
            },
        );
        check(
            &sizes(ObjectClass::Van).collect::<Vec<_>>(),
            &Labels {
                quantiles: [
                    [3.92, 4.27, 4.98, 5.96, 6.64],
                    [1.64, 1.75, 1.88, 2.06, 2.20],
                    [1.78, 1.87, 2.13, 2.58, 2.75],
                ],
                correlations: [0.648, 0.821, 0.667],
                tolerance_m: [0.25, 0.05, 0.06],
            },
        );
        let people: Vec<DVec3> =
            (0..20_000).map(|k| person_box(&mut Stream::from_seed("person box", k)).size_lwh).collect();
        check(
            &people,
            &Labels {
                quantiles: [
                    [0.42, 0.56, 0.88, 1.06, 1.17],
                    [0.43, 0.52, 0.65, 0.82, 0.91],
                    [1.57, 1.64, 1.77, 1.87, 1.93],
                ],
                correlations: [0.196, 0.273, 0.133],
                tolerance_m: [0.06, 0.03, 0.03],
            },
        );
        let cyclists: Vec<DVec3> =
            (0..20_000).map(|k| cyclist_box(&mut Stream::from_seed("cyclist box", k)).size_lwh).collect();
        check(
            &cyclists,
            &Labels {
                quantiles: [
                    [1.50, 1.59, 1.76, 1.95, 2.02],
                    [0.34, 0.50, 0.60, 0.69, 0.83],
                    [1.59, 1.64, 1.75, 1.82, 1.86],
                ],
                correlations: [0.321, 0.369, 0.130],
                tolerance_m: [0.06, 0.07, 0.03],
            },
        );
    }

    #[test]
    fn boxes_of_people_who_sit_are_those_of_kittis_labels() {
        let sizes: Vec<DVec3> =
            (0..20_000).map(|k| sitting_box(&mut Stream::from_seed("sitting box", k)).size_lwh).collect();
        let labels = [[0.57, 0.61, 0.75, 1.11, 1.33], [0.50, 0.50, 0.59, 0.68, 0.75], [1.14, 1.18, 1.26, 1.34, 1.39]];
        check_quantiles(&sizes, &labels, [0.1, 0.035, 0.04]);
    }

    #[test]
    fn a_box_within_margins_is_the_box_that_they_were_put_around() {
        for seed in 0..200 {
            let margins = Margins::of_vehicle(ObjectClass::Car, &mut Stream::from_seed("margins", seed));
            let annotated = DVec3::new(3.9, 1.6, 1.5);
            let true_lwh = margins.around(annotated);
            let found = margins.within(true_lwh);
            assert!((found.size_lwh - annotated).abs().max_element() < 1e-12);
            let (c, size) = (found.bottom_center_in_box, found.size_lwh);
            let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
            assert!(close(true_lwh.x / 2.0 - (c.x + size.x / 2.0), margins.front_m));
            assert!(close(c.x - size.x / 2.0 + true_lwh.x / 2.0, margins.rear_m));
            assert!(close(true_lwh.y / 2.0 - (c.y + size.y / 2.0), margins.left_m));
            assert!(close(c.y - size.y / 2.0 + true_lwh.y / 2.0, margins.right_m));
            assert!(close(true_lwh.z - (c.z + size.z), margins.top_m) && close(c.z, margins.bottom_m));
        }
    }

    #[test]
    fn boxes_begin_before_the_near_end_and_end_inside_the_far_one() {
        // Mean and standard deviation over cars: near end beyond the body's, far end inside it.
        let body = DVec3::new(4.0, 1.65, 1.5);
        for (near, toward, before_m, inside_m) in
            [(BodyEnd::Front, 1.0, 0.06, 0.26), (BodyEnd::Rear, -1.0, 0.035, 0.235)]
        {
            let ends = |seed| {
                let margins = Margins::of_vehicle(ObjectClass::Car, &mut Stream::from_seed("margins", seed));
                let drawn = displaced(margins.within(body), ObjectClass::Car, near);
                let (x, half) = (toward * drawn.bottom_center_in_box.x, drawn.size_lwh.x / 2.0);
                [x + half - body.x / 2.0, body.x / 2.0 - half + x]
            };
            let all: Vec<[f64; 2]> = (0..4000).map(ends).collect();
            for (k, mean) in [before_m, inside_m].into_iter().enumerate() {
                let mut end: Vec<f64> = all.iter().map(|e| e[k]).collect();
                let (low, middle, high) = (quantile(&mut end, 0.16), quantile(&mut end, 0.5), quantile(&mut end, 0.84));
                assert!((middle - mean).abs() < 0.01 && (low + 0.07 - mean).abs() < 0.02, "{near:?} {low} {middle}");
                assert!((high - 0.07 - mean).abs() < 0.02, "{near:?} {high}");
            }
        }
    }

    #[test]
    fn no_size_is_drawn_for_a_tram() {
        let error = vehicle_size(ObjectClass::Tram, &mut Stream::from_seed("size", 0)).unwrap_err();
        assert!(error.to_string().contains("Tram"), "{error}");
    }
}
