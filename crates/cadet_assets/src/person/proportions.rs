//! One person's measures and gait.

use strum::AsRefStr;

use super::hold::Hold;
use cadet_base::math;
use cadet_base::rng::Stream;

/// What an arm does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ArmPose {
    /// Swings with the gait.
    Swing,
    /// Hangs.
    Hang,
    /// Holds a telephone before the chest.
    Phone,
    /// Hand in a pocket.
    Pocket,
    /// Arms crossed.
    Crossed,
    /// Carries a bag.
    Carry,
    /// Holds the strap on the shoulder.
    Strap,
}

/// Kind of person.
#[derive(Debug, Clone, Copy, PartialEq, Eq, AsRefStr)]
#[strum(serialize_all = "lowercase")]
pub(crate) enum PersonKind {
    Man,
    Woman,
    Child,
}

/// What covers the legs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Legwear {
    Trousers,
    WideTrousers,
    Shorts,
    Skirt,
}

/// What covers the trunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Top {
    /// Short sleeves.
    TShirt,
    /// Long sleeves.
    Shirt,
    Jacket,
    /// Reaches to mid-thigh.
    Coat,
}

/// Load that a person carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Load {
    None,
    ShoulderBag,
    Backpack,
    Shopping,
}

/// What covers the head.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Headwear {
    ShortHair,
    LongHair,
    Hat,
    /// Of cyclists.
    Helmet,
}

/// A person's measures in meters, and how the person moves.
#[derive(Debug, Clone)]
pub(crate) struct Proportions {
    pub kind: PersonKind,
    /// Height with shoes and hair.
    pub stature_m: f32,
    /// Girth relative to a slim adult's, and how far the belly sticks out.
    pub girth_factor: f32,
    pub belly_m: f32,
    pub thigh_m: f32,
    pub shank_m: f32,
    pub upper_arm_m: f32,
    pub forearm_m: f32,
    pub hand_m: f32,
    pub foot_m: f32,
    /// Ankle joint above the sole, shoes included.
    pub ankle_height_m: f32,
    pub heel_behind_ankle_m: f32,
    pub ball_before_ankle_m: f32,
    /// Half distance of hip joints, of shoulder joints, of the footprints.
    pub hip_half_m: f32,
    pub shoulder_half_m: f32,
    pub step_half_width_m: f32,
    /// Shoulder joints above hip joints.
    pub trunk_m: f32,
    /// Chin above hip joints, and the head's height.
    pub chin_m: f32,
    pub head_m: f32,
    /// 0 for a person who stands, m/s.
    pub speed_mps: f32,
    /// Two steps, meters.
    pub cycle_length_m: f32,
    pub lean_rad: f32,
    pub elbow_rad: f32,
    pub arms: [ArmPose; 2],
    /// How much farther than others the person holds the arms from the trunk.
    pub arms_out_rad: f32,
    pub weight_on_left: bool,
    /// How far one foot of a person who stands is before the other.
    pub stance_m: f32,
    pub legwear: Legwear,
    pub top: Top,
    pub load: Load,
    pub headwear: Headwear,
    pub is_elderly: bool,
    /// Where hands hold something, left and right.
    pub held: [Option<Hold>; 2],
}

/// People shorter than this are children.
const TALLEST_CHILD_M: f64 = 1.5;

/// Share of men among adults of a height, who are normally distributed: men 1.81 +- 0.08 m, women 1.68 +- 0.07 m.
fn share_of_men(stature_m: f64) -> f64 {
    let density = |mean: f64, sd: f64| math::exp(-0.5 * ((stature_m - mean) / sd) * ((stature_m - mean) / sd)) / sd;
    let (men, women) = (0.55 * density(1.81, 0.08), 0.45 * density(1.68, 0.07));
    men / (men + women)
}

impl Proportions {
    /// Draws a person of a height.
    pub fn draw(is_standing: bool, stature_m: f64, s: &mut Stream) -> Self {
        let kind = if stature_m < TALLEST_CHILD_M {
            PersonKind::Child
        } else if s.chance(share_of_men(stature_m)) {
            PersonKind::Man
        } else {
            PersonKind::Woman
        };
        let is_elderly = kind != PersonKind::Child && s.chance(0.15);
        let speed = match kind {
            _ if is_standing => 0.0,
            PersonKind::Child => s.range(1.1, 1.5),
            _ if is_elderly => s.range(0.95, 1.15),
            _ => s.clipped_normal(1.38, 0.22).clamp(0.85, 1.9),
        };
        // Step length grows with the root of speed; short people take shorter steps.
        let step = (speed * 60.0 * 0.0064 * stature_m / 1.75).sqrt();
        let load = match (kind, s.unit()) {
            (PersonKind::Child, ..0.40) => Load::Backpack,
            (PersonKind::Child, _) => Load::None,
            (_, ..0.25) => Load::ShoulderBag,
            (_, ..0.40) => Load::Backpack,
            (_, ..0.50) => Load::Shopping,
            _ => Load::None,
        };
        let arms = Self::draw_arms(s, is_standing, load);
        let is_woman = kind == PersonKind::Woman;
        let legwear = match s.unit() {
            ..0.15 if is_woman => Legwear::Skirt,
            drawn if drawn > 0.85 => Legwear::Shorts,
            drawn if drawn > 0.65 => Legwear::WideTrousers,
            _ => Legwear::Trousers,
        };
        let top = [Top::TShirt, Top::Shirt, Top::Jacket, Top::Coat][s.weighted(&[0.40, 0.25, 0.25, 0.10])];
        let headwear = if s.chance(0.12) {
            Headwear::Hat
        } else if s.chance(if is_woman { 0.55 } else { 0.04 }) {
            Headwear::LongHair
        } else {
            Headwear::ShortHair
        };
        // The measures' fractions are of the naked height; shoes add 2.5 cm and hair 1.5.
        let h = stature_m - 0.04;
        let child = if kind == PersonKind::Child { ((1.6 - stature_m) / 0.45).clamp(0.0, 1.0) } else { 0.0 };
        let leg_fraction = 0.530 - 0.07 * child;
        let head_fraction = 0.130 + 0.035 * child;
        let leg = (leg_fraction - 0.039) * h;
        let wide = if is_woman { 0.92 } else { 1.0 };
        let foot = 0.152 * h + 0.025;
        Self {
            kind,
            stature_m: stature_m as f32,
            girth_factor: s.clipped_normal(if is_elderly { 1.08 } else { 1.0 }, 0.07) as f32,
            belly_m: if kind == PersonKind::Child { 0.0 } else { (s.range(-0.04, 0.08)).max(0.0) as f32 },
            thigh_m: (0.499 * leg) as f32,
            shank_m: (0.501 * leg) as f32,
            upper_arm_m: (0.186 * h) as f32,
            forearm_m: (0.146 * h) as f32,
            hand_m: (0.108 * h) as f32,
            foot_m: foot as f32,
            ankle_height_m: (0.039 * h + 0.025) as f32,
            heel_behind_ankle_m: (0.235 * foot) as f32,
            ball_before_ankle_m: (0.44 * foot) as f32,
            hip_half_m: (0.050 * h * if is_woman { 1.04 } else { 1.0 }) as f32,
            shoulder_half_m: ((0.1295 * h - 0.035) * wide) as f32,
            step_half_width_m: s.range(0.04, 0.06) as f32,
            trunk_m: ((0.818 - leg_fraction - 0.030 * child) * h - 0.02) as f32,
            chin_m: ((1.0 - head_fraction - leg_fraction) * h) as f32,
            head_m: (head_fraction * h) as f32,
            speed_mps: speed as f32,
            cycle_length_m: (2.0 * step) as f32,
            lean_rad: if is_elderly { s.range(0.06, 0.16) } else { s.range(0.02, 0.07) } as f32,
            elbow_rad: s.range(0.26, 0.52) as f32,
            arms,
            arms_out_rad: 0.0,
            weight_on_left: s.chance(0.5),
            stance_m: 0.0,
            legwear,
            top,
            load,
            headwear,
            is_elderly,
            held: [None; 2],
        }
    }

    /// Makes the body longer and wider: walkers take longer steps at the same cadence, who stands puts one foot before
    /// the other, and arms are held farther from the trunk. What a body cannot do it does not.
    pub fn grow(&mut self, longer_m: f32, wider_m: f32) {
        if self.speed_mps > 0.0 {
            let step_m = self.cycle_length_m / 2.0;
            let (least, most) = (0.26 * self.stature_m, 0.50 * self.stature_m);
            let longer = (step_m + longer_m).clamp(least, most) / step_m;
            self.cycle_length_m *= longer;
            self.speed_mps *= longer;
        } else {
            self.stance_m = (self.stance_m + longer_m).clamp(0.0, 0.25);
        }
        let arm_m = self.upper_arm_m + self.forearm_m;
        self.arms_out_rad = (self.arms_out_rad + wider_m / (2.0 * arm_m)).clamp(-0.06, 0.32);
    }

    fn draw_arms(s: &mut Stream, is_standing: bool, load: Load) -> [ArmPose; 2] {
        let free = |s: &mut Stream| {
            if is_standing {
                [ArmPose::Hang, ArmPose::Phone, ArmPose::Pocket][s.weighted(&[0.45, 0.2, 0.35])]
            } else if s.chance(0.10) {
                ArmPose::Pocket
            } else if s.chance(0.06) {
                ArmPose::Phone
            } else {
                ArmPose::Swing
            }
        };
        let mut arms = [free(s), free(s)];
        if is_standing && s.chance(0.15) {
            arms = [ArmPose::Crossed; 2];
        }
        match load {
            Load::Shopping => arms[s.below(2)] = ArmPose::Carry,
            Load::ShoulderBag if s.chance(0.4) => arms[0] = ArmPose::Strap,
            _ => {}
        }
        arms
    }
}
