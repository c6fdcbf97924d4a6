//! Properties of the intersection over union of rotated boxes.
#![allow(missing_docs)]

use cadet_core::evaluate::{RotatedBox, intersection_bev_m2, iou_3d, iou_bev};
use cadet_core::math::{PI, cos, sin};
use proptest::prelude::*;

prop_compose! {
    fn size()(exponent in -2.0..3.0_f64) -> f64 { cadet_core::math::exp(exponent) }
}

prop_compose! {
    fn any_box()(
        x in -3.0..3.0_f64, y in -2.0..2.0_f64, z in -3.0..3.0_f64,
        length_m in size(), width_m in size(), height_m in size(), rotation_y in heading(),
    ) -> RotatedBox {
        RotatedBox { x, y, z, length_m, width_m, height_m, rotation_y }
    }
}

/// Any heading, and those where edges are parallel or nearly so.
fn heading() -> impl Strategy<Value = f64> {
    let quarter = (-8..8_i32).prop_map(|quarters| f64::from(quarters) * 0.5 * PI);
    prop_oneof![-10.0..10.0_f64, quarter.clone(), (quarter, -1e-7..1e-7_f64).prop_map(|(q, tiny)| q + tiny)]
}

/// Turns a box about the origin's upright axis, then moves it.
fn moved(b: &RotatedBox, turn: f64, shift: [f64; 3]) -> RotatedBox {
    let (cos, sin) = (cos(turn), sin(turn));
    RotatedBox {
        x: b.x * cos + b.z * sin + shift[0],
        y: b.y + shift[1],
        z: -b.x * sin + b.z * cos + shift[2],
        rotation_y: b.rotation_y + turn,
        ..*b
    }
}

fn contains(b: &RotatedBox, x: f64, z: f64) -> bool {
    let (cos, sin) = (cos(b.rotation_y), sin(b.rotation_y));
    let (dx, dz) = (x - b.x, z - b.z);
    (dx * cos - dz * sin).abs() <= 0.5 * b.length_m && (dx * sin + dz * cos).abs() <= 0.5 * b.width_m
}

/// The share of a grid over `a` that lies in `b`, as an area.
fn sampled_intersection(a: &RotatedBox, b: &RotatedBox, steps: usize) -> f64 {
    let (cos, sin) = (cos(a.rotation_y), sin(a.rotation_y));
    let at = |i: usize, side: f64| ((i as f64 + 0.5) / steps as f64 - 0.5) * side;
    let inside = (0..steps * steps).filter(|i| {
        let (u, v) = (at(i % steps, a.length_m), at(i / steps, a.width_m));
        contains(b, a.x + u * cos + v * sin, a.z - u * sin + v * cos)
    });
    inside.count() as f64 / (steps * steps) as f64 * a.length_m * a.width_m
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn it_is_symmetric_and_in_0_to_1(a in any_box(), b in any_box()) {
        for iou in [iou_bev, iou_3d] {
            let value = iou(&a, &b);
            prop_assert!((0.0..=1.0).contains(&value), "{value}");
            prop_assert_eq!(value.to_bits(), iou(&b, &a).to_bits());
        }
        prop_assert!(intersection_bev_m2(&a, &b) <= a.area_bev_m2().min(b.area_bev_m2()));
    }

    #[test]
    fn equal_boxes_give_1(a in any_box(), half_turns in -3..4_i32) {
        prop_assert_eq!((iou_bev(&a, &a), iou_3d(&a, &a)), (1.0, 1.0));
        let turned = RotatedBox { rotation_y: a.rotation_y + f64::from(half_turns) * PI, ..a };
        // The sides' ratio is at most 150, so a heading's last bit moves an end by little of the width.
        prop_assert!((iou_bev(&a, &turned) - 1.0).abs() < 1e-12);
        let swapped = RotatedBox { length_m: a.width_m, width_m: a.length_m, rotation_y: a.rotation_y + 0.5 * PI, ..a };
        prop_assert!((iou_3d(&a, &swapped) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rigid_motion_changes_nothing(
        a in any_box(), b in any_box(), turn in -7.0..7.0_f64, shift in prop::array::uniform3(-80.0..80.0_f64),
    ) {
        let (c, d) = (moved(&a, turn, shift), moved(&b, turn, shift));
        prop_assert!((iou_bev(&a, &b) - iou_bev(&c, &d)).abs() < 1e-11);
        prop_assert!((iou_3d(&a, &b) - iou_3d(&c, &d)).abs() < 1e-11);
    }

    #[test]
    fn scale_changes_nothing(a in any_box(), b in any_box(), scale in size()) {
        let scaled = |b: &RotatedBox| {
            let [x, y, z, l, w, h, _] = b.to_array().map(|v| v * scale);
            RotatedBox::from_array([x, y, z, l, w, h, b.rotation_y])
        };
        prop_assert!((iou_3d(&a, &b) - iou_3d(&scaled(&a), &scaled(&b))).abs() < 1e-12);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn it_equals_a_sampled_estimate(a in any_box(), b in any_box()) {
        let steps = 200;
        let estimate = sampled_intersection(&a, &b, steps);
        // Only cells that one of the four edges crosses can be counted wrongly, at most 2 x 200 each.
        let bound = 4.0 * 2.0 / steps as f64 * a.area_bev_m2();
        prop_assert!((intersection_bev_m2(&a, &b) - estimate).abs() <= bound);
        let other = sampled_intersection(&b, &a, steps);
        prop_assert!((intersection_bev_m2(&a, &b) - other).abs() <= 8.0 / steps as f64 * b.area_bev_m2());
    }
}
