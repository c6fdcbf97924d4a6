//! Made-up ground truth and detections, with everything that KITTI's rules tell apart: neighbor classes, levels,
//! heights on a limit, equal scores, duplicates, wrong names, small detections, DontCare regions, empty frames.
#![allow(dead_code)]

use std::fmt::Write;

use cadet_core::evaluate::{BoxImg, ClassLimits, Detection, FramePair, Level, ObjectType, RotatedBox, Settings, Truth};
use cadet_core::math::{PI, atan2, cos, sin, wrap_angle};
use cadet_core::rng::Stream;

const FOCAL_PX: f64 = 721.5;

/// Kind, objects a frame, length, width, height.
const OBJECTS: [(ObjectType, f64, [f64; 3]); 8] = [
    (ObjectType::Car, 4.2, [3.88, 1.63, 1.53]),
    (ObjectType::Van, 0.45, [5.08, 1.90, 2.21]),
    (ObjectType::Truck, 0.15, [10.1, 2.59, 3.25]),
    (ObjectType::Pedestrian, 0.65, [0.84, 0.66, 1.76]),
    (ObjectType::PersonSitting, 0.1, [0.80, 0.59, 1.27]),
    (ObjectType::Cyclist, 0.3, [1.76, 0.60, 1.74]),
    (ObjectType::Tram, 0.06, [16.1, 2.54, 3.53]),
    (ObjectType::Misc, 0.12, [3.58, 1.51, 1.91]),
];
const EVALUATED: [ObjectType; 3] = [ObjectType::Car, ObjectType::Pedestrian, ObjectType::Cyclist];

/// KITTI's classes, limits and levels.
pub fn kitti() -> Settings {
    let classes = EVALUATED.map(|class| {
        let limit = if class == ObjectType::Car { 0.7 } else { 0.5 };
        ClassLimits::of(class, [limit; 3])
    });
    let levels = [(40.0, 0.0, 0.15), (25.0, 1.0, 0.30), (25.0, 2.0, 0.50)].map(|(height, occlusion, truncation)| {
        Level { min_height_px: height, is_inclusive: false, max_occlusion_level: occlusion, max_truncation: truncation }
    });
    Settings { classes: classes.to_vec(), levels: levels.to_vec() }
}

/// Frames with about 6.6 lines of ground truth and 13 detections each, as KITTI's validation set has with a detector
/// that keeps its low scores.
pub fn draw(seed: u64, num_frames: usize) -> Vec<FramePair> {
    (0..num_frames).map(|index| draw_frame(&mut Stream::from_seed(&format!("frame {index}"), seed))).collect()
}

fn draw_frame(rng: &mut Stream) -> FramePair {
    let mut frame = FramePair::default();
    if rng.chance(0.03) {
        return frame;
    }
    for (kind, mean, sizes) in OBJECTS {
        for _ in 0..rng.poisson(mean) {
            let truth = draw_truth(rng, kind, sizes);
            frame.truths.push(truth);
            let copies = usize::from(rng.chance(0.8)) + usize::from(rng.chance(0.15));
            for _ in 0..copies {
                frame.detections.push(draw_detection(rng, &truth));
            }
        }
    }
    for _ in 0..rng.poisson(0.5) {
        let (left, top) = (rng.range(0.0, 1000.0), rng.range(120.0, 200.0));
        frame.truths.push(dont_care(left, top, rng.range(20.0, 160.0), rng.range(12.0, 70.0)));
        if rng.chance(0.5) {
            let mut stuff = draw_detection_at_random(rng);
            stuff.box_img =
                BoxImg { left_px: left + 2.0, top_px: top + 1.0, right_px: left + 30.0, bottom_px: top + 40.0 };
            frame.detections.push(stuff);
        }
    }
    for _ in 0..rng.poisson(6.5) {
        let mut wrong = draw_detection_at_random(rng);
        wrong.score = hundredths(wrong.score * 0.4);
        frame.detections.push(wrong);
    }
    rng.shuffle(&mut frame.detections);
    frame
}

/// A detection of something that is not there.
fn draw_detection_at_random(rng: &mut Stream) -> Detection {
    let (kind, _, sizes) = OBJECTS[[0, 3, 5][rng.weighted(&[0.5, 0.3, 0.2])]];
    let truth = draw_truth(rng, kind, sizes);
    draw_detection(rng, &truth)
}

fn draw_truth(rng: &mut Stream, kind: ObjectType, sizes: [f64; 3]) -> Truth {
    let [length_m, width_m, height_m] = sizes.map(|size| hundredths(size * rng.range(0.9, 1.1)));
    let z = hundredths(rng.range(6.0, 40.0) + rng.range(0.0, 30.0) * rng.unit());
    let x = hundredths(rng.range(-0.8, 0.8) * z);
    let rotation_y = hundredths(rng.range(-PI, PI));
    let box_cam = RotatedBox { x, y: hundredths(rng.range(1.4, 1.9)), z, length_m, width_m, height_m, rotation_y };
    let mut box_img = project(&box_cam);
    if rng.chance(0.1) {
        box_img.bottom_px = box_img.top_px + [25.0, 40.0, 24.99, 25.01, 39.99, 40.01][rng.below(6)];
    }
    Truth {
        kind,
        truncation: [0.0, 0.0, 0.1, 0.15, 0.3, 0.31, 0.5, 0.6][rng.below(8)],
        occlusion_level: [0.0, 1.0, 2.0, 3.0][rng.weighted(&[0.5, 0.25, 0.2, 0.05])],
        alpha: hundredths(wrap_angle(rotation_y - atan2(x, z))),
        box_img,
        box_cam,
        is_optional: false,
    }
}

fn draw_detection(rng: &mut Stream, truth: &Truth) -> Detection {
    let noise = [0.3, 1.0, 2.5][rng.weighted(&[0.55, 0.3, 0.15])];
    let mut shake = |sd: f64| sd * noise * rng.normal();
    let (a, image) = (&truth.box_cam, &truth.box_img);
    let box_cam = RotatedBox {
        x: hundredths(a.x + shake(0.08)),
        y: hundredths(a.y + shake(0.05)),
        z: hundredths(a.z + shake(0.14)),
        length_m: hundredths((a.length_m * (1.0 + shake(0.05))).max(0.1)),
        width_m: hundredths((a.width_m * (1.0 + shake(0.05))).max(0.1)),
        height_m: hundredths((a.height_m * (1.0 + shake(0.05))).max(0.1)),
        rotation_y: hundredths(wrap_angle(a.rotation_y + shake(0.06))),
    };
    let (width, height) = (image.right_px - image.left_px, image.bottom_px - image.top_px);
    let mut box_img = BoxImg {
        left_px: hundredths(image.left_px + shake(0.03) * width),
        top_px: hundredths(image.top_px + shake(0.03) * height),
        right_px: hundredths(image.right_px + shake(0.03) * width),
        bottom_px: hundredths(image.bottom_px + shake(0.03) * height),
    };
    if rng.chance(0.08) {
        box_img.bottom_px = hundredths(box_img.top_px + [25.0, 40.0, 24.99, 39.99, 18.0][rng.below(5)]);
    }
    let mut kind = truth.kind;
    if matches!(kind, ObjectType::Van | ObjectType::Truck | ObjectType::Misc) && rng.chance(0.5) {
        kind = ObjectType::Car;
    } else if kind == ObjectType::PersonSitting && rng.chance(0.6) {
        kind = ObjectType::Pedestrian;
    } else if rng.chance(0.05) {
        kind = EVALUATED[rng.below(3)];
    }
    Detection {
        kind,
        alpha: hundredths(wrap_angle(box_cam.rotation_y - atan2(box_cam.x, box_cam.z))),
        box_img,
        box_cam,
        // Two decimals make equal scores common.
        score: hundredths((1.0 - 0.25 * noise + 0.15 * rng.normal()).clamp(0.01, 1.0)),
        is_optional: false,
    }
}

fn dont_care(left: f64, top: f64, width: f64, height: f64) -> Truth {
    Truth {
        kind: ObjectType::DontCare,
        truncation: -1.0,
        occlusion_level: -1.0,
        alpha: -10.0,
        box_img: BoxImg { left_px: left, top_px: top, right_px: left + width, bottom_px: top + height },
        box_cam: RotatedBox::from_array([-1000.0, -1000.0, -1000.0, -1.0, -1.0, -1.0, -10.0]),
        is_optional: false,
    }
}

/// The rectangle round the corners, roughly: what matters is that near boxes are high.
fn project(b: &RotatedBox) -> BoxImg {
    let half = 0.5 * (b.length_m * cos(b.rotation_y).abs() + b.width_m * sin(b.rotation_y).abs());
    let scale = FOCAL_PX / b.z;
    BoxImg {
        left_px: hundredths(609.6 + (b.x - half) * scale),
        top_px: hundredths(172.9 + (b.y - b.height_m) * scale),
        right_px: hundredths(609.6 + (b.x + half) * scale),
        bottom_px: hundredths(172.9 + b.y * scale),
    }
}

fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// The frame's label file.
pub fn label_text(frame: &FramePair) -> String {
    let mut text = String::new();
    for t in &frame.truths {
        let name = t.kind.name().expect("KITTI's types alone are drawn");
        write!(text, "{name} {:.2} {} {:.2} ", t.truncation, t.occlusion_level, t.alpha).expect("writing to memory");
        write_boxes(&mut text, &t.box_img, &t.box_cam);
        text.push('\n');
    }
    text
}

/// The frame's result file.
pub fn result_text(frame: &FramePair) -> String {
    let mut text = String::new();
    for d in &frame.detections {
        write!(text, "{} -1 -1 {:.2} ", d.kind.name().expect("KITTI's types alone are drawn"), d.alpha)
            .expect("writing to memory");
        write_boxes(&mut text, &d.box_img, &d.box_cam);
        writeln!(text, " {:.2}", d.score).expect("writing to memory");
    }
    text
}

fn write_boxes(text: &mut String, i: &BoxImg, c: &RotatedBox) {
    write!(text, "{:.2} {:.2} {:.2} {:.2} ", i.left_px, i.top_px, i.right_px, i.bottom_px).expect("writing to memory");
    let sizes = [c.height_m, c.width_m, c.length_m];
    write!(text, "{:.2} {:.2} {:.2} ", sizes[0], sizes[1], sizes[2]).expect("writing to memory");
    write!(text, "{:.2} {:.2} {:.2} {:.2}", c.x, c.y, c.z, c.rotation_y).expect("writing to memory");
}
