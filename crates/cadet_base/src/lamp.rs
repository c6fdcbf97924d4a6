//! Light sources at night: where they are, and how much light they send into a direction.

use crate::math::{DPose3, Vec3};

/// Candela that a lamp sends along its strongest direction, per unit of [`Lamp::intensity`].
///
/// An irradiance of 1 is 100 lx at night, so an intensity of 1 makes it at 1 m.
pub const CD_PER_INTENSITY: f32 = 100.0;

/// How light leaves a lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LampBeam {
    /// A street lamp that shines down: full above the second cosine to the nadir, nothing below the first.
    Luminaire {
        /// Cosine of the angle to the nadir at which the light ends.
        cos_ends: f32,
        /// Cosine from which on it is full.
        cos_full: f32,
    },
    /// A low beam for traffic that keeps to the right.
    LowBeam,
    /// A small lens, as of tail lamps and traffic lights: the 16th power of the cosine to its axis.
    Lens,
}

/// A light source in a frame: an instance's or the world's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    /// Its distribution.
    pub beam: LampBeam,
    /// Where it is.
    pub at: Vec3,
    /// Unit vector: the axis of a beam, down for luminaires.
    pub ahead: Vec3,
    /// Unit vector to the left of it.
    pub left: Vec3,
    /// R, G, B along the strongest direction, in [`CD_PER_INTENSITY`].
    pub intensity: [f32; 3],
    /// Its light ends here: beyond 0.7 of it, it is faded out.
    pub reach_m: f32,
}

/// Low beams are aimed so far below the horizon, a tangent.
pub const CUT_OFF_TANGENT: f32 = -0.01;
/// The cut-off rises to the right of the axis, by the tangent of 15 degrees, and so far.
const RISE: f32 = 0.268;
const RISE_TO: f32 = 0.04;
/// Width of the cut-off's edge, a tangent: a sixth of a degree.
const EDGE: f32 = 0.003;
/// Half widths, as tangents: below the cut-off, to both sides of a hot spot, and above the cut-off.
const FALL_BELOW: f32 = 0.025;
const FALL_ASIDE: f32 = 0.12;
const FALL_ABOVE: f32 = 0.1;
const HOT_SPOT: f32 = -0.02;
/// No light leaves a low beam farther aside: what is taken off the share there.
const ASIDE_OFFSET: f32 = 0.012;
/// Stray light above the cut-off: a hundredth of the strongest (160 of 16,000 cd).
const STRAY: f32 = 0.01;
/// Points no farther ahead than this are beside a low beam, meters.
const LEAST_AHEAD_M: f32 = 0.05;
/// A luminaire sends more to the sides than straight down, so that the street is lit evenly.
const BATWING: f32 = 0.7;

impl Lamp {
    /// A lamp of a color of luma 1 and of an intensity along its strongest direction.
    #[must_use]
    pub fn of_candela(
        beam: LampBeam,
        at: Vec3,
        [ahead, left]: [Vec3; 2],
        color: [f32; 3],
        intensity_cd: f32,
        reach_m: f32,
    ) -> Self {
        Self { beam, at, ahead, left, intensity: color.map(|c| c * (intensity_cd / CD_PER_INTENSITY)), reach_m }
    }

    /// The lamp in the frame into which a pose leads.
    #[must_use]
    pub fn placed(&self, pose: &DPose3) -> Self {
        let turn = |v: Vec3| (pose.rotation * v.as_dvec3()).as_vec3();
        let at = pose.transform_point(self.at.as_dvec3()).as_vec3();
        Self { at, ahead: turn(self.ahead), left: turn(self.left), ..*self }
    }

    /// Share of the strongest intensity toward a place, by its vector from the lamp and its distance.
    #[inline(always)]
    #[must_use]
    pub fn share(&self, to: Vec3, distance_m: f32) -> f32 {
        match self.beam {
            LampBeam::Luminaire { cos_ends: ends, cos_full: full } => {
                luminaire(to.dot(self.ahead) / distance_m, ends, full)
            }
            LampBeam::LowBeam => {
                let up = self.ahead.cross(self.left);
                low_beam(to.dot(self.ahead), to.dot(self.left), to.dot(up))
            }
            LampBeam::Lens => lens(to.dot(self.ahead) / distance_m),
        }
    }
}

/// A luminaire's share by the cosine to its nadir.
#[inline(always)]
#[must_use]
pub fn luminaire(cos_nadir: f32, cos_ends: f32, cos_full: f32) -> f32 {
    ((cos_nadir - cos_ends) / (cos_full - cos_ends)).clamp(0.0, 1.0) * (1.0 + BATWING - BATWING * cos_nadir)
}

/// A low beam's share, by meters ahead, to the left, and up.
#[inline(always)]
#[must_use]
pub fn low_beam(ahead_m: f32, left_m: f32, up_m: f32) -> f32 {
    let per_ahead = 1.0 / ahead_m.max(LEAST_AHEAD_M);
    let (aside, up) = (left_m * per_ahead, up_m * per_ahead);
    let over = up - CUT_OFF_TANGENT - RISE * (-aside).clamp(0.0, RISE_TO);
    let below = (over / FALL_BELOW).min(0.0);
    let beam = (0.5 - over / EDGE).clamp(0.0, 1.0) / (1.0 + below * below);
    let (off_spot, above) = ((aside - HOT_SPOT) / FALL_ASIDE, up / FALL_ABOVE);
    let sideways = (1.0 / (1.0 + off_spot * off_spot) - ASIDE_OFFSET).max(0.0);
    let share = sideways * (beam + STRAY / (1.0 + above * above));
    if ahead_m > LEAST_AHEAD_M { share } else { 0.0 }
}

/// A lens' share by the cosine to its axis.
#[inline(always)]
#[must_use]
pub fn lens(cos_axis: f32) -> f32 {
    let square = cos_axis.max(0.0) * cos_axis.max(0.0);
    let fourth = square * square;
    let eighth = fourth * fourth;
    eighth * eighth
}

/// Share of a lamp's light that is left at a distance, by its square and that of the reach: it fades out at the end.
#[inline(always)]
#[must_use]
pub fn fade(square_m2: f32, reach_square_m2: f32) -> f32 {
    (2.0 - 2.0 * square_m2 / reach_square_m2).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_beam_ends_one_percent_below_the_horizon_and_higher_at_the_right() {
        // On a wall 25 m ahead: 25 cm below the lamp is the edge, which is 4 cm wide to both sides.
        let at = |left: f32, up: f32| low_beam(25.0, left, up);
        assert!(at(1.0, -0.31) > 20.0 * at(1.0, -0.19), "{} {}", at(1.0, -0.31), at(1.0, -0.19));
        // ECE R112: point 75R is bright, B50L (0.57 degrees up, 3.43 left) nearly dark.
        assert!(at(-0.75, -0.375) > 0.5 && at(1.5, 0.25) < 0.02);
        // At the right the edge rises by 15 degrees, to 2 cm above the lamp's height.
        assert!(at(-1.0, -0.05) > 0.5 && at(1.0, -0.05) < 0.02);
        assert!(at(-1.0, 0.1) < 0.02);
    }

    #[test]
    fn a_low_beam_fades_to_both_sides_and_sends_nothing_behind() {
        let shares: Vec<f32> = [0.0, 0.2, 0.5, 1.0, 1.2].map(|left| low_beam(10.0, 10.0 * left, -0.3)).to_vec();
        assert!(shares.windows(2).all(|pair| pair[1] <= pair[0]), "{shares:?}");
        assert_eq!(shares[4], 0.0);
        assert_eq!(low_beam(-3.0, 0.0, -0.1), 0.0);
    }

    #[test]
    fn a_luminaire_sends_nothing_above_its_cut_off() {
        assert_eq!(luminaire(1.0, 0.1, 0.3), 1.0);
        assert_eq!(luminaire(0.1, 0.1, 0.3), 0.0);
        assert_eq!(luminaire(-0.5, 0.1, 0.3), 0.0);
        assert!(luminaire(0.5, 0.1, 0.3) > 1.0);
    }

    #[test]
    fn a_placed_lamp_shines_where_its_frame_turns() {
        let lamp = Lamp {
            beam: LampBeam::LowBeam,
            at: Vec3::new(2.0, 0.0, 0.6),
            ahead: Vec3::X,
            left: Vec3::Y,
            intensity: [1.0; 3],
            reach_m: 50.0,
        };
        let pose = crate::frames::upright(crate::math::DVec3::new(10.0, 5.0, 0.0), std::f64::consts::FRAC_PI_2);
        let placed = lamp.placed(&pose);
        assert!((placed.at - Vec3::new(10.0, 7.0, 0.6)).length() < 1e-5, "{}", placed.at);
        let to = Vec3::new(0.3, 20.0, -0.5);
        assert!((placed.share(to, to.length()) - low_beam(20.0, -0.3, -0.5)).abs() < 1e-5);
    }
}
