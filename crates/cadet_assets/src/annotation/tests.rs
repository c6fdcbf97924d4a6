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

fn check_quantiles(sizes: &[DVec3], labels: &[[f64; 5]; 3], tolerance_m: [f64; 3]) {
    for (k, quantiles) in labels.iter().enumerate() {
        let mut axis: Vec<f64> = sizes.iter().map(|s| s[k]).collect();
        for (share, expected) in [0.05, 0.16, 0.5, 0.84, 0.95].iter().zip(quantiles) {
            let got = quantile(&mut axis, *share);
            assert!((got - expected).abs() < tolerance_m[k], "axis {k} at {share}: {got}, labels {expected}");
        }
    }
}

/// Compares sizes with every label of KITTI's training set: quantiles (5, 16, 50, 84, 95 %) of length, width and
/// height, which may differ by so much, and their correlations (l-w, l-h, w-h).
fn check(sizes: impl Fn(u64) -> DVec3, labels: [[f64; 5]; 3], tolerance_m: [f64; 3], correlations: [f64; 3]) {
    let sizes: Vec<DVec3> = (0..20_000).map(sizes).collect();
    check_quantiles(&sizes, &labels, tolerance_m);
    let axes: [Vec<f64>; 3] = std::array::from_fn(|k| sizes.iter().map(|s| s[k]).collect());
    for ((a, b), expected) in [(0, 1), (0, 2), (1, 2)].into_iter().zip(correlations) {
        let got = correlation(&axes[a], &axes[b]);
        assert!((got - expected).abs() < 0.06, "axes {a} and {b}: {got}, labels {expected}");
    }
}

#[test]
fn annotated_sizes_are_those_of_kittis_labels() {
    let cars = |k| vehicle_size(ObjectClass::Car, &mut Stream::from_seed("size", k)).unwrap();
    let labels = [[3.20, 3.46, 3.88, 4.33, 4.52], [1.47, 1.54, 1.63, 1.72, 1.80], [1.36, 1.41, 1.50, 1.64, 1.78]];
    check(cars, labels, [0.05, 0.02, 0.03], [0.349, 0.173, 0.305]);
    let vans = |k| vehicle_size(ObjectClass::Van, &mut Stream::from_seed("size", k)).unwrap();
    let labels = [[3.92, 4.27, 4.98, 5.96, 6.64], [1.64, 1.75, 1.88, 2.06, 2.20], [1.78, 1.87, 2.13, 2.58, 2.75]];
    check(vans, labels, [0.25, 0.05, 0.06], [0.648, 0.821, 0.667]);
    let people = |k| person_box(&mut Stream::from_seed("person box", k)).size_lwh;
    let labels = [[0.42, 0.56, 0.88, 1.06, 1.17], [0.43, 0.52, 0.65, 0.82, 0.91], [1.57, 1.64, 1.77, 1.87, 1.93]];
    check(people, labels, [0.06, 0.03, 0.03], [0.196, 0.273, 0.133]);
    let cyclists = |k| cyclist_box(&mut Stream::from_seed("cyclist box", k)).size_lwh;
    let labels = [[1.50, 1.59, 1.76, 1.95, 2.02], [0.34, 0.50, 0.60, 0.69, 0.83], [1.59, 1.64, 1.75, 1.82, 1.86]];
    check(cyclists, labels, [0.06, 0.07, 0.03], [0.321, 0.369, 0.130]);
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
    for (near, toward, before_m, inside_m) in [(BodyEnd::Front, 1.0, 0.06, 0.26), (BodyEnd::Rear, -1.0, 0.035, 0.235)] {
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
