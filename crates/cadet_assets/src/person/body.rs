//! The body at a posture: tubes around a skeleton.

use super::arms::{add_arm, add_load, arm_line, arm_to};
use super::clothes::slot;
use super::frame::{Frame, SIDES, down};
use super::gait::{Leg, Posture};
use super::head::add_head;
use super::proportions::{Legwear, PersonKind, Proportions, Top};
use super::tube::{Ring, Tubes};
use cadet_base::math::{Vec3, cosf, sinf};

/// Builds the body with the hip joints' middle at the origin's height; the caller puts the soles on the ground.
pub(crate) fn body(p: &Proportions, posture: &Posture, level: usize) -> Tubes {
    let mut tubes = Tubes::default();
    let frame = Frame::new(p, posture);
    let mut knees = [Vec3::ZERO; 2];
    for (i, side) in [1.0_f32, -1.0].into_iter().enumerate() {
        knees[i] = add_leg(&mut tubes, p, &leg_line(p, posture, side, posture.legs[i]), level);
    }
    let sole = tubes.vertices.iter().fold(0.0, |low: f32, v| low.min(v.z));
    add_trunk(&mut tubes, p, &frame, level);
    add_skirts(&mut tubes, p, &frame, knees, level);
    let mut wrists = [Vec3::ZERO; 2];
    for (i, side) in [1.0_f32, -1.0].into_iter().enumerate() {
        let line = match &p.held[i] {
            Some(hold) => arm_to(p, &frame, side, hold.at(posture.phase) + Vec3::Z * sole, hold.elbow_to(side)),
            None => arm_line(p, &frame, side, posture.arms[i]),
        };
        wrists[i] = add_arm(&mut tubes, p, &frame, &line, level);
    }
    add_head(&mut tubes, p, &frame, level);
    add_load(&mut tubes, p, &frame, wrists, level);
    tubes
}

/// A leg: where the hip joint is, which way thigh and shank go, and how the foot stands.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LegLine {
    pub hip: Vec3,
    /// Of unit length but for a slight slant.
    pub thigh: Vec3,
    pub shank: Vec3,
    /// Toward the kneecap, about square to the leg.
    pub forward: Vec3,
    /// The sole's pitch, toes up positive.
    pub sole_rad: f32,
    /// +1 on the left, -1 on the right.
    pub side: f32,
}

fn leg_line(p: &Proportions, posture: &Posture, side: f32, leg: Leg) -> LegLine {
    let yaw = posture.pelvis_yaw_rad;
    let hip = Vec3::new(-side * sinf(yaw) * p.hip_half_m, posture.sway_m + side * cosf(yaw) * p.hip_half_m, 0.0);
    // The leg leans in its plane so that the foot lands on its line.
    let foot_y = side * p.step_half_width_m.max(if p.speed_mps == 0.0 { 0.10 } else { 0.0 });
    let slope = (foot_y - hip.y) / (p.thigh_m + p.shank_m);
    let slanted = |v: Vec3| Vec3::new(v.x, v.y - slope * v.z, v.z);
    let middle_rad = 0.5 * (leg.thigh_rad + leg.shank_rad);
    let forward = Vec3::new(cosf(middle_rad), 0.0, sinf(middle_rad));
    let [thigh, shank] = [leg.thigh_rad, leg.shank_rad].map(|angle_rad| slanted(down(angle_rad)));
    LegLine { hip, thigh, shank, forward, sole_rad: leg.sole_rad, side }
}

/// Adds a leg and its foot; returns the knee.
pub(crate) fn add_leg(tubes: &mut Tubes, p: &Proportions, line: &LegLine, level: usize) -> Vec3 {
    let LegLine { hip, thigh, shank, forward, sole_rad, side } = *line;
    let g = p.girth_factor * p.stature_m / 1.75;
    let knee = hip + thigh * p.thigh_m;
    let ankle = knee + shank * p.shank_m;
    let bare = matches!(p.legwear, Legwear::Shorts | Legwear::Skirt);
    let wide = match p.legwear {
        Legwear::WideTrousers => 0.028,
        Legwear::Trousers => 0.013,
        _ => 0.006,
    };
    let lower = if bare { slot::SKIN } else { slot::LEGS };
    let upper = if p.legwear == Legwear::Skirt { slot::SKIN } else { slot::LEGS };
    let loose = if bare { 0.0 } else { wide };
    let bend = (thigh + shank).normalize();
    let ring = |center: Vec3, along: Vec3, r: f32, extra: f32, slot: u8, level: usize| {
        Ring::new(center, [along.normalize(), forward], [r * g + extra, 0.95 * r * g + extra], slot, level)
    };
    let hem = if p.legwear == Legwear::Shorts { 0.030 } else { wide };
    let on_thigh = |t: f32| hip + thigh * (p.thigh_m * t);
    let on_shank =
        |t: f32| knee + shank * (p.shank_m * t) - forward * (0.010 * (1.0 - t) * if t > 0.1 { 1.0 } else { 0.0 });
    let rings = [
        ring(on_thigh(-0.06), thigh, 0.080, wide, upper, 0),
        ring(on_thigh(0.08), thigh, 0.088, wide, upper, 2),
        ring(on_thigh(0.30), thigh, 0.082, wide, upper, 1),
        ring(on_thigh(0.58), thigh, 0.072, hem, upper, 0),
        ring(on_thigh(0.84), thigh, 0.062, hem, lower, if bare { 1 } else { 0 }),
        ring(on_thigh(0.86), thigh, 0.060, loose, lower, 0),
        ring(knee, bend, 0.057, loose, lower, 2),
        ring(on_shank(0.16), shank, 0.054, loose, lower, 0),
        ring(on_shank(0.32), shank, 0.058, loose, lower, 1),
        ring(on_shank(0.62), shank, 0.047, loose, lower, 0),
        ring(on_shank(0.90), shank, 0.036, 1.4 * loose, lower, 1),
        ring(on_shank(1.0), shank, 0.036, 1.5 * loose, lower, 2),
    ];
    tubes.tube(&rings, SIDES[level][1], level, -1.0);
    add_foot(tubes, p, ankle, sole_rad, side, level);
    knee
}

/// Along a foot and up from its sole.
pub(crate) fn foot_axes(pitch_rad: f32, side: f32) -> (Vec3, Vec3) {
    let out = 0.10 * side;
    (
        Vec3::new(cosf(pitch_rad) * cosf(out), cosf(pitch_rad) * sinf(out), sinf(pitch_rad)),
        Vec3::new(-sinf(pitch_rad), 0.0, cosf(pitch_rad)),
    )
}

fn add_foot(tubes: &mut Tubes, p: &Proportions, ankle: Vec3, sole_rad: f32, side: f32, level: usize) {
    // Toes stay on the ground while the heel rises.
    let toe_pitch = if sole_rad < 0.0 { sole_rad + (-sole_rad).min(0.75) } else { sole_rad };
    let (along, up) = foot_axes(sole_rad, side);
    let (toe_along, toe_up) = foot_axes(toe_pitch, side);
    let ball = ankle + along * p.ball_before_ankle_m - up * p.ankle_height_m;
    const CUT: f32 = -0.80;
    let scale = p.foot_m / 0.29;
    let ring = |x: f32, height: f32, half_width: f32, level: usize| {
        let half = height * scale / (1.0 - CUT);
        let past = x * p.foot_m - p.ball_before_ankle_m;
        let (ground, direction, normal) = if past > 0.0 {
            (ball + toe_along * past, toe_along, toe_up)
        } else {
            (ankle + along * (x * p.foot_m) - up * p.ankle_height_m, along, up)
        };
        Ring::new(ground - normal * (CUT * half), [direction, normal], [half, half_width * scale], slot::SHOES, level)
    };
    let rings = [
        ring(-0.255, 0.060, 0.022, 1),
        ring(-0.235, 0.085, 0.032, 2),
        ring(-0.12, 0.105, 0.038, 0),
        ring(0.04, 0.105, 0.038, 1),
        ring(0.22, 0.078, 0.043, 0),
        ring(0.44, 0.058, 0.050, 2),
        ring(0.60, 0.048, 0.046, 0),
        ring(0.70, 0.038, 0.034, 2),
        ring(0.735, 0.026, 0.020, 0),
    ];
    tubes.tube(&rings, SIDES[level][1], level, CUT);
}

pub(crate) fn add_trunk(tubes: &mut Tubes, p: &Proportions, frame: &Frame, level: usize) {
    let g = frame.girth_scale;
    let t = p.trunk_m;
    let (hips, chest, bust) = if p.kind == PersonKind::Woman { (1.04, 0.93, 0.022) } else { (1.0, 1.0, 0.0) };
    let loose = match p.top {
        Top::TShirt | Top::Shirt => 0.010,
        Top::Jacket => 0.028,
        Top::Coat => 0.045,
    };
    let bottom = slot::LEGS;
    let sh = p.shoulder_half_m;
    let ring = |z: f32, dx: f32, x: f32, y: f32, slot: u8, level: usize| {
        frame.ring(z * t, dx, [x * g + loose, y * g + loose], slot, level)
    };
    let belly = p.belly_m;

    let rings = [
        frame.ring(-0.14 * t, 0.0, [0.075 * g, 0.100 * g], bottom, 0),
        frame.ring(-0.07 * t, -0.005, [0.105 * g, 0.150 * hips * g], bottom, 2),
        frame.ring(0.06 * t, -0.005, [0.112 * g, 0.168 * hips * g], bottom, 1),
        ring(0.10, 0.0, 0.112, 0.165 * hips, slot::TOP, 0),
        ring(0.22, 0.5 * belly, 0.104 + 0.5 * belly, 0.150 * hips, slot::TOP, 1),
        ring(0.40, 0.5 * belly, 0.100 + 0.5 * belly, 0.142, slot::TOP, 0),
        ring(0.58, 0.002 + 0.3 * bust, 0.108, 0.152 * chest, slot::TOP, 0),
        ring(0.70, 0.004 + 0.5 * bust, 0.113 + 0.5 * bust, 0.160 * chest, slot::TOP, 2),
        ring(0.85, 0.0, 0.104, 0.167 * chest, slot::TOP, 0),
        frame.ring(0.95 * t, -0.004, [0.090 * g + loose, sh + 0.016 + 0.6 * loose], slot::TOP, 1),
        frame.ring(1.03 * t, -0.008, [0.072 * g + loose, 0.74 * sh + 0.5 * loose], slot::TOP, 1),
        frame.ring(1.10 * t, -0.006, [0.058 * g + 0.5 * loose, 0.070 * g + 0.5 * loose], slot::SKIN, 2),
    ];
    tubes.tube(&rings, SIDES[level][0], level, -1.0);
    let neck = [
        frame.ring(1.02 * t, -0.005, [0.056 * g, 0.058 * g], slot::SKIN, 2),
        frame.ring(p.chin_m + 0.25 * p.head_m, 0.004, [0.053 * g, 0.053 * g], slot::SKIN, 2),
    ];
    tubes.tube(&neck, SIDES[level][2], level, -1.0);
}

/// Skirt and coat tails: cones that the legs push out.
fn add_skirts(tubes: &mut Tubes, p: &Proportions, frame: &Frame, knees: [Vec3; 2], level: usize) {
    let coat = p.top == Top::Coat;
    let skirt = p.legwear == Legwear::Skirt;
    if !coat && !skirt {
        return;
    }
    let g = frame.girth_scale;
    let (slot, top_half, top_z, reach) = if coat {
        (slot::TOP, [0.105 * g + 0.05, 0.165 * g + 0.045], 0.22 * p.trunk_m, 0.72)
    } else {
        (slot::LEGS, [0.112 * g + 0.012, 0.160 * g + 0.012], 0.14 * p.trunk_m, 1.0)
    };
    let rings = [(0.0_f32, 2), (0.25, 1), (0.55, 0), (0.8, 1), (1.0, 2)].map(|(s, level)| {
        let along = s * reach;
        let [a, b] = knees.map(|k| k * along);
        let (front, back) = (a.x.max(b.x), a.x.min(b.x));
        let spread = 0.5 * (front - back);
        let z = top_z * (1.0 - s) + s * reach * (0.5 * (knees[0].z + knees[1].z));
        let ease = s * (2.0 - s);
        let half = [top_half[0] + spread + 0.012 * ease, top_half[1] + 0.02 * ease];
        let center = Vec3::new(0.5 * (front + back), frame.posture.sway_m * (1.0 - 0.5 * s), z);
        Ring::new(center, [Vec3::NEG_Z, Vec3::X], half, slot, level)
    });
    tubes.tube(&rings, SIDES[level][0], level, -1.0);
}
