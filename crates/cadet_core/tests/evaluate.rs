//! The evaluation against a plain writing-down of its rules, and what must not change its answers.
#![allow(missing_docs)]

#[path = "evaluation/frames.rs"]
mod frames;
#[path = "evaluation/naive.rs"]
mod naive;

use cadet_core::evaluate::{
    ClassLimits, FramePair, Level, ObjectType, ObjectTypes, Settings, average_r11, average_r40, evaluate,
    evaluate_draws, parse_detections, parse_truths,
};
use cadet_core::rng::Stream;
use proptest::prelude::*;

/// A pause that never ends the work.
fn go_on() -> cadet_core::Result<()> {
    Ok(())
}

/// Limits and levels beside KITTI's: low overlaps make several detections fight for an object.
fn crowded() -> Settings {
    let limits = |class, limit: f64| ClassLimits::of(class, [limit, 0.0, limit * 0.5]);
    let level = |height, is_inclusive| Level {
        min_height_px: height,
        is_inclusive,
        max_occlusion_level: f64::INFINITY,
        max_truncation: f64::INFINITY,
    };
    Settings {
        classes: vec![limits(ObjectType::Car, 0.2), limits(ObjectType::Van, 0.1), limits(ObjectType::Pedestrian, 0.3)],
        levels: vec![level(40.0, true), level(32.5, false), level(0.0, false)],
    }
}

/// Moves everything close together, so that boxes overlap more than twos.
fn crowd(frames: &mut [FramePair]) {
    for frame in frames {
        let boxes = frame
            .truths
            .iter_mut()
            .filter(|t| t.kind != ObjectType::DontCare)
            .map(|t| (&mut t.box_cam, &mut t.box_img));
        for (cam, img) in boxes.chain(frame.detections.iter_mut().map(|d| (&mut d.box_cam, &mut d.box_img))) {
            cam.x *= 0.05;
            cam.z = 20.0 + 0.05 * cam.z;
            let shift = 0.95 * (600.0 - img.left_px);
            img.left_px += shift;
            img.right_px += shift;
        }
    }
}

fn assert_same(frames: &[FramePair], settings: &Settings) {
    let curves = evaluate(frames, settings).expect("settings that make sense");
    for curve in &curves {
        let expected = naive::answer(frames, settings, curve.class, curve.metric, curve.level);
        let what = (curve.class, curve.metric, curve.level);
        assert_eq!(curve.num_valid, expected.num_valid, "{what:?}");
        assert_eq!(curve.num_tp, expected.num_tp, "{what:?}");
        assert_eq!(curve.num_fp, expected.num_fp, "{what:?}");
        let heading = curve.heading.as_ref().expect("every detection has an observation angle");
        for i in 0..41 {
            assert!((curve.precision[i] - expected.precision[i]).abs() < 1e-15, "{what:?} {i}");
            assert!((heading[i] - expected.heading[i]).abs() < 1e-13, "{what:?} {i}");
        }
    }
}

#[test]
fn it_answers_as_the_rules_written_plainly_do() {
    for seed in 0..6 {
        let mut frames = frames::draw(seed, 120);
        assert_same(&frames, &frames::kitti());
        crowd(&mut frames);
        assert_same(&frames, &frames::kitti());
        assert_same(&frames, &crowded());
    }
}

#[test]
fn own_classes_and_optional_objects_follow_the_plain_rules_too() {
    let kinds = |kinds: &[ObjectType]| kinds.iter().copied().collect::<ObjectTypes>();
    let mut settings = frames::kitti();
    settings.classes = vec![
        ClassLimits {
            kinds: kinds(&[ObjectType::Car, ObjectType::Van, ObjectType::Truck]),
            neighbors: kinds(&[ObjectType::Misc, ObjectType::Tram]),
            min_overlap: [0.6, 0.5, 0.4],
        },
        ClassLimits { kinds: kinds(&[ObjectType::Car]), neighbors: ObjectTypes::default(), min_overlap: [0.5; 3] },
    ];
    for seed in 0..3 {
        let mut frames = frames::draw(seed, 120);
        let mut rng = Stream::from_seed("optional", seed);
        for frame in &mut frames {
            frame.truths.iter_mut().for_each(|truth| truth.is_optional = rng.chance(0.3));
            frame.detections.iter_mut().for_each(|detection| detection.is_optional = rng.chance(0.3));
        }
        assert_same(&frames, &settings);
        crowd(&mut frames);
        assert_same(&frames, &settings);
        assert_same(&frames, &frames::kitti());
    }
}

#[test]
fn a_draw_has_the_ap_of_its_frames_written_one_after_the_other() {
    let (frames, settings) = (frames::draw(5, 60), frames::kitti());
    let mut rng = Stream::from_seed("draws", 5);
    let mut draws: Vec<Vec<u32>> =
        (0..6).map(|_| (0..60).map(|_| u32::try_from(rng.below(60)).unwrap()).collect()).collect();
    draws.push((0..60).rev().collect());
    let drawn = evaluate_draws(&frames, &settings, &draws, go_on).unwrap();
    for (number, draw) in draws.iter().enumerate() {
        let repeated: Vec<FramePair> = draw.iter().map(|&index| frames[index as usize].clone()).collect();
        let curves = evaluate(&repeated, &settings).unwrap();
        assert_eq!(curves.len(), drawn.len());
        for (curve, ap) in curves.iter().zip(&drawn) {
            assert_eq!((curve.class, curve.metric, curve.level), (ap.class, ap.metric, ap.level));
            if curve.num_valid == 0 {
                assert!(ap.ap[number].iter().chain(&ap.heading.as_ref().unwrap()[number]).all(|ap| ap.is_nan()));
                continue;
            }
            assert_eq!(ap.ap[number], [average_r11(&curve.precision), average_r40(&curve.precision)]);
            let heading = curve.heading.as_ref().unwrap();
            let expected = [average_r11(heading), average_r40(heading)];
            assert_eq!(ap.heading.as_ref().unwrap()[number], expected);
        }
    }
}

#[test]
fn a_draw_without_objects_has_no_ap_and_frames_that_are_not_there_are_refused() {
    let mut frames = frames::draw(6, 30);
    frames[0] = FramePair::default();
    let drawn = evaluate_draws(&frames, &frames::kitti(), &[vec![0; 30]], go_on).unwrap();
    assert!(drawn.iter().all(|curve| curve.ap[0].iter().all(|ap| ap.is_nan())));
    assert!(evaluate_draws(&frames, &frames::kitti(), &[vec![30]], go_on).is_err());
}

#[test]
fn classes_that_make_no_sense_are_refused() {
    let mut settings = frames::kitti();
    for (kinds, neighbors) in [
        (vec![], vec![]),
        (vec![ObjectType::DontCare], vec![]),
        (vec![ObjectType::Car], vec![ObjectType::Van, ObjectType::Car]),
    ] {
        settings.classes[0].kinds = kinds.into_iter().collect();
        settings.classes[0].neighbors = neighbors.into_iter().collect();
        assert!(evaluate(&[], &settings).is_err());
    }
}

#[test]
fn the_made_up_frames_are_like_a_validation_set() {
    let frames = frames::draw(1, 1000);
    let count = |f: fn(&FramePair) -> usize| frames.iter().map(f).sum::<usize>();
    let (truths, detections) = (count(|f| f.truths.len()), count(|f| f.detections.len()));
    assert!((6000..7500).contains(&truths), "{truths}");
    assert!((12_000..14_500).contains(&detections), "{detections}");
    for curve in evaluate(&frames, &frames::kitti()).unwrap() {
        let ap = average_r40(&curve.precision);
        assert!((15.0..90.0).contains(&ap), "{:?} {ap}", (curve.class, curve.metric, curve.level));
    }
}

#[test]
fn perfect_detections_get_all_that_few_objects_allow() {
    let mut frames = frames::draw(2, 2000);
    for frame in &mut frames {
        let copies =
            frame.truths.iter().filter(|t| t.kind != ObjectType::DontCare).map(|t| cadet_core::evaluate::Detection {
                kind: t.kind,
                alpha: t.alpha,
                box_img: t.box_img,
                box_cam: t.box_cam,
                score: 1.0,
                is_optional: false,
            });
        frame.detections = copies.collect();
    }
    for curve in evaluate(&frames, &frames::kitti()).unwrap() {
        assert!(curve.num_valid > 40);
        assert_eq!((average_r40(&curve.precision), average_r11(&curve.precision)), (100.0, 100.0));
        assert!((average_r40(&curve.heading.unwrap()) - 100.0).abs() < 1e-9);
    }
}

#[test]
fn text_brings_the_frames_back() {
    for frame in frames::draw(3, 50) {
        let truths = parse_truths(frames::label_text(&frame).as_bytes(), "label").unwrap().objects;
        let parsed = parse_detections(frames::result_text(&frame).as_bytes(), "result").unwrap();
        assert_eq!(truths.len(), frame.truths.len());
        for (read, written) in parsed.objects.iter().zip(&frame.detections) {
            assert_eq!((read.kind, read.score, read.box_cam), (written.kind, written.score, written.box_cam));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn neither_the_order_of_frames_nor_threads_change_a_bit(seed in any::<u64>(), num_threads in 1_usize..9) {
        let mut frames = frames::draw(seed, 700);
        let settings = frames::kitti();
        let curves = evaluate(&frames, &settings).unwrap();
        Stream::from_seed("order", seed).shuffle(&mut frames);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(num_threads).build().unwrap();
        let again = pool.install(|| evaluate(&frames, &settings)).unwrap();
        prop_assert_eq!(curves, again);
    }
}
