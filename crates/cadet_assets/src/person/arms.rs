//! Arms, and what a person carries.

use super::clothes::slot;
use super::frame::{Frame, SIDES};
use super::gait::Arm;
use super::proportions::{ArmPose, Load, PersonKind, Proportions, Top};
use super::tube::{Ring, Tubes};
use cadet_base::math::{Vec3, acosf, cosf, sinf};

/// An arm: the shoulder, which way upper arm and forearm go, and which way the elbow folds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ArmLine {
    pub shoulder: Vec3,
    pub upper: Vec3,
    pub fore: Vec3,
    pub fold: Vec3,
    /// +1 on the left, -1 on the right.
    pub side: f32,
}

/// The shoulder joint.
pub(crate) fn shoulder(p: &Proportions, frame: &Frame, side: f32) -> Vec3 {
    frame.spine(0.94 * p.trunk_m) + frame.left(p.trunk_m) * side * p.shoulder_half_m
}

/// An arm held at angles.
pub(crate) fn arm_line(p: &Proportions, frame: &Frame, side: f32, arm: Arm) -> ArmLine {
    let (forward, left) = (frame.forward(p.trunk_m), frame.left(p.trunk_m) * side);
    let out = sinf(arm.lift_rad);
    let upper = (forward * (sinf(arm.swing_rad) * cosf(arm.lift_rad)) + left * out
        - Vec3::Z * (cosf(arm.swing_rad) * cosf(arm.lift_rad)))
    .normalize();
    // The forearm folds forward and inward, square to the upper arm.
    let fold = forward * cosf(arm.inward_rad) - left * sinf(arm.inward_rad);
    let fold = (fold - upper * fold.dot(upper)).normalize();
    let fore = upper * cosf(arm.elbow_rad) + fold * sinf(arm.elbow_rad);
    ArmLine { shoulder: shoulder(p, frame, side), upper, fore, fold, side }
}

/// The directions of two links from a joint to an end: the joint between them is on the side of `pole`. Out of reach
/// they are straight.
pub(crate) fn two_links(from: Vec3, to: Vec3, a_m: f32, b_m: f32, pole: Vec3) -> (Vec3, Vec3) {
    let d = to - from;
    let reach = d.length().clamp((a_m - b_m).abs() + 1e-3, 0.9995 * (a_m + b_m));
    let along = d.normalize_or(Vec3::NEG_Z);
    let aside = (pole - along * pole.dot(along)).normalize();
    let angle = acosf(((a_m * a_m + reach * reach - b_m * b_m) / (2.0 * a_m * reach)).clamp(-1.0, 1.0));
    let first = along * cosf(angle) + aside * sinf(angle);
    let second = (along * reach - first * a_m).normalize();
    (first, second)
}

/// The arm whose hand is at a place, and whose elbow points another way.
pub(crate) fn arm_to(p: &Proportions, frame: &Frame, side: f32, hand: Vec3, elbow_to: Vec3) -> ArmLine {
    let from = shoulder(p, frame, side);
    let (upper, fore) = two_links(from, hand, p.upper_arm_m, p.forearm_m + 0.5 * p.hand_m, elbow_to);
    let fold = (fore - upper * fore.dot(upper)).normalize_or(Vec3::X);
    ArmLine { shoulder: from, upper, fore, fold, side }
}

/// Adds an arm and its hand; returns the middle of the hand.
pub(crate) fn add_arm(tubes: &mut Tubes, p: &Proportions, frame: &Frame, line: &ArmLine, level: usize) -> Vec3 {
    let ArmLine { shoulder, upper, fore, fold, side } = *line;
    let g = frame.girth_scale;
    let (forward, left) = (frame.forward(p.trunk_m), frame.left(p.trunk_m) * side);
    let elbow = shoulder + upper * p.upper_arm_m;
    let wrist = elbow + fore * p.forearm_m;
    let loose = match p.top {
        Top::TShirt => 0.006,
        Top::Shirt => 0.009,
        Top::Jacket => 0.018,
        Top::Coat => 0.025,
    };
    let short = p.top == Top::TShirt;
    let (sleeve, bare) = (slot::TOP, if short { slot::SKIN } else { slot::TOP });
    let low = if short { 0.0 } else { loose };
    let thin = if p.kind == PersonKind::Woman { 0.90 } else { 1.0 };
    let on_upper = |t: f32| shoulder + upper * (p.upper_arm_m * t);
    let on_fore = |t: f32| elbow + fore * (p.forearm_m * t);
    // One reference direction along the whole arm, so that the tube does not twist.
    let aside = upper.cross(fore);
    let is_bent = aside.length_squared() > 1e-4;
    let reference = if is_bent { aside.normalize() } else { left };
    let ring = |center: Vec3, along: Vec3, r: f32, extra: f32, slot: u8, level: usize| {
        Ring::new(center, [along, reference], [r * g * thin + extra; 2], slot, level)
    };
    let rings = [
        ring(on_upper(-0.04), upper, 0.030, 0.5 * loose, sleeve, 0),
        ring(on_upper(0.03), upper, 0.046, loose, sleeve, 2),
        ring(on_upper(0.25), upper, 0.052, loose, sleeve, 0),
        ring(on_upper(0.55), upper, 0.049, if short { 0.018 } else { loose }, bare, 1),
        ring(on_upper(0.57), upper, 0.046, low, bare, 0),
        ring(on_upper(0.85), upper, 0.043, low, bare, 0),
        ring(elbow, (upper + fore).normalize(), 0.042, low, bare, 2),
        ring(on_fore(0.22), fore, 0.043, low, bare, 0),
        ring(on_fore(0.60), fore, 0.036, low, bare, 1),
        ring(on_fore(0.98), fore, 0.028, low, slot::SKIN, 2),
    ];

    tubes.tube(&rings, SIDES[level][2], level, -1.0);
    let scale = p.hand_m / 0.19;
    let palm = if is_bent { fold } else { forward };
    let flat = |t: f32, a: f32, b: f32, level: usize| {
        Ring::new(wrist + fore * (t * p.hand_m), [fore, palm], [a * scale, b * scale], slot::SKIN, level)
    };
    let hand = [
        flat(-0.05, 0.026, 0.020, 2),
        flat(0.20, 0.040, 0.020, 0),
        flat(0.48, 0.045, 0.021, 1),
        flat(0.75, 0.036, 0.020, 2),
        flat(0.86, 0.020, 0.013, 0),
    ];
    tubes.tube(&hand, SIDES[level][2] / 2 + 2, level, -1.0);
    wrist + fore * (0.5 * p.hand_m)
}

/// An upright soft box.
fn sack(tubes: &mut Tubes, center: Vec3, forward: Vec3, half: Vec3, level: usize) {
    let rings =
        [(-1.0, 0.70, 1), (-0.85, 1.0, 2), (0.0, 1.05, 0), (0.75, 0.92, 2), (1.0, 0.6, 1)].map(|(z, s, keep)| {
            let half_xy = [half.x * s * 1.12, half.y * s * 1.12];
            Ring::new(center + Vec3::Z * (z * half.z), [Vec3::Z, forward], half_xy, slot::BAG, keep)
        });
    tubes.tube(&rings, SIDES[level][2], level, -1.0);
}

pub(crate) fn add_load(tubes: &mut Tubes, p: &Proportions, frame: &Frame, wrists: [Vec3; 2], level: usize) {
    let k = p.stature_m / 1.75;
    match p.load {
        Load::None => {}
        Load::Backpack => {
            let z = 0.60 * p.trunk_m;
            let (f, loose) = (frame.forward(z), if p.top == Top::Coat { 0.045 } else { 0.02 });
            let center = frame.spine(z) - f * (0.105 * frame.girth_scale + loose + 0.08 * k);
            sack(tubes, center, f, Vec3::new(0.09, 0.15, 0.22) * k, level);
        }
        Load::ShoulderBag => {
            let z = 0.05 * p.trunk_m;
            let (f, left) = (frame.forward(z), frame.left(z));
            let center = frame.spine(z) + left * (0.168 * frame.girth_scale + 0.065) - f * 0.08;
            sack(tubes, center, f, Vec3::new(0.16, 0.055, 0.14), level);
            if level < 2 {
                let ends = [center + Vec3::Z * 0.12, frame.spine(1.08 * p.trunk_m) + left * (0.8 * p.shoulder_half_m)];
                let strap = ends.map(|end| Ring::new(end, [Vec3::Z, f], [0.02, 0.008], slot::BAG, 2));
                tubes.tube(&strap, 4, level, -1.0);
            }
        }
        Load::Shopping => {
            let hand = usize::from(p.arms[0] != ArmPose::Carry || p.held[0].is_some());
            let room = (wrists[hand].z + p.thigh_m + p.shank_m + p.ankle_height_m - 0.10).clamp(0.15, 0.42);
            let center = wrists[hand] - Vec3::Z * (0.5 * room + 0.06);
            sack(tubes, center, Vec3::X, Vec3::new(0.16, 0.075, 0.5 * room), level);
        }
    }
}
