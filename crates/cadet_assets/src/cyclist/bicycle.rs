//! A bicycle's measures.

use cadet_base::math::{Vec3, cosf, sinf};
use cadet_base::rng::Stream;

/// What stands between saddle and handlebar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FrameKind {
    /// A level tube.
    Diamond,
    /// Two low ones, to step through.
    StepThrough,
}

/// Parts mounted on a bicycle.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fittings {
    pub mudguards: bool,
    pub rack: bool,
    pub basket: bool,
    pub panniers: bool,
    pub chain_guard: bool,
}

/// A bicycle in the box frame: the middle between its wheels at x = 0, the ground at z = 0. Meters.
#[derive(Debug, Clone)]
pub(super) struct Bicycle {
    pub frame: FrameKind,
    pub wheel_radius_m: f32,
    /// Half the tire's thickness.
    pub tire_half_m: f32,
    pub wheelbase_m: f32,
    /// The crank's axle: x and z.
    pub bottom_bracket: [f32; 2],
    pub crank_m: f32,
    /// Pedals' middles beside the middle.
    pub pedal_y: f32,
    /// Middle of the left grip.
    pub grip: Vec3,
    /// Half the handlebar's width.
    pub bar_half_m: f32,
    /// Meters on the ground for a turn of the crank.
    pub development_m: f64,
    pub fittings: Fittings,
}

/// Where the seat tube ends to the rear of the crank's axle, for each meter up.
const SEAT_TUBE_SLOPE: f32 = 0.325;
/// The head tube goes back this much for each meter up.
pub(super) const HEAD_TUBE_SLOPE: f32 = 0.36;
/// Shortest and longest distance of the axles of adults' bicycles, and of children's.
const WHEELBASE_M: [f32; 2] = [0.99, 1.19];
const CHILD_WHEELBASE_M: [f32; 2] = [0.84, 0.98];

impl Bicycle {
    /// Draws one as long as `length_m` with a bar as wide as `width_m`, if there are such, for somebody of a height.
    pub fn draw(length_m: f32, width_m: f32, stature_m: f32, is_woman: bool, s: &mut Stream) -> Self {
        let is_child = stature_m < 1.5;
        let diameter = match (is_child, length_m > 1.66) {
            (true, _) => s.range(0.50, 0.60),
            (false, true) => s.range(0.675, 0.70),
            (false, false) => s.range(0.62, 0.66),
        } as f32;
        let limits = if is_child { CHILD_WHEELBASE_M } else { WHEELBASE_M };
        // Mudguards reach beyond the wheels.
        let wheelbase_m = (length_m - 0.04 - diameter).clamp(limits[0], limits[1]);
        let wheel_radius_m = diameter / 2.0;
        let rear_x = -wheelbase_m / 2.0;
        // Upright city bicycles have high grips far back.
        let style = s.weighted(&[0.50, 0.38, 0.12]);
        let (back, height) = [(0.34, 1.07), (0.24, 1.00), (0.17, 0.94)][style];
        let tall = (stature_m / 1.75).clamp(0.7, 1.1);
        let grip_z = (height + s.range(-0.03, 0.04) as f32) * (0.4 + 0.6 * tall);
        let bar_half_m = (0.5 * width_m - 0.01).clamp(0.23, 0.35);
        let grip = Vec3::new(wheelbase_m / 2.0 - back * tall, bar_half_m - 0.055, grip_z);
        let is_sporty = style == 2;
        let rack = !is_sporty && !is_child && s.chance(0.75);
        let fittings = Fittings {
            mudguards: !is_sporty && s.chance(0.85),
            rack,
            basket: !is_sporty && s.chance(0.22),
            panniers: rack && s.chance(0.27),
            chain_guard: style == 0 && s.chance(0.7),
        };
        let frame =
            if s.chance(if is_woman { 0.8 } else { 0.15 }) { FrameKind::StepThrough } else { FrameKind::Diamond };
        Self {
            frame,
            wheel_radius_m,
            tire_half_m: s.range(0.015, 0.024) as f32,
            wheelbase_m,
            bottom_bracket: [rear_x + if is_child { 0.36 } else { 0.44 }, wheel_radius_m - 0.06],
            crank_m: 0.17 * tall.min(1.0),
            pedal_y: 0.115,
            grip,
            bar_half_m,
            development_m: s.range(3.6, 5.6) * f64::from(diameter) / 0.68,
            fittings,
        }
    }

    /// The rear axle, and the front one.
    pub fn axles(&self) -> [Vec3; 2] {
        [-0.5, 0.5].map(|x| Vec3::new(x * self.wheelbase_m, 0.0, self.wheel_radius_m))
    }

    /// The crank's axle.
    pub fn crank_axle(&self) -> Vec3 {
        Vec3::new(self.bottom_bracket[0], 0.0, self.bottom_bracket[1])
    }

    /// The middle of a pedal; at phase 0 the left one is on top.
    pub fn pedal(&self, side: f32, phase: f32) -> Vec3 {
        let turn = phase * std::f32::consts::TAU + if side > 0.0 { 0.0 } else { std::f32::consts::PI };
        self.crank_axle() + Vec3::new(self.crank_m * sinf(turn), side * self.pedal_y, self.crank_m * cosf(turn))
    }

    /// The place of the seat tube at a height.
    pub fn seat_tube(&self, z: f32) -> Vec3 {
        let [x, low] = self.bottom_bracket;
        Vec3::new(x - (z - low) * SEAT_TUBE_SLOPE, 0.0, z)
    }

    /// The place of the steerer at a height.
    pub fn steerer(&self, z: f32) -> Vec3 {
        // The fork is bent forward by 5 cm.
        Vec3::new(self.wheelbase_m / 2.0 - 0.05 - (z - self.wheel_radius_m) * HEAD_TUBE_SLOPE, 0.0, z)
    }
}
