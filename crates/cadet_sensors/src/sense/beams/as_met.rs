//! Where points stand when the beams of a turning sensor meet them.

use crate::sense::scene::{PosedInstance, PosedScene, RigidMotion};
use crate::sense::spinning::azimuth_rad_of;
use cadet_base::geometry::LANES;
use cadet_base::math::{DPose3, DVec3, PI, wrap_angle};

/// Moves points to where beams meet them.
pub(crate) trait AsMet {
    /// How far any point of an instance moves at most.
    fn reach_m(&self, instance: usize) -> f32;

    /// Moves points of an instance, in the grid's frame.
    fn move_lanes(&self, instance: usize, points_grid: &mut [[f64; LANES]; 3]);
}

/// A world that stands still.
pub(crate) struct Still;

impl AsMet for Still {
    #[inline(always)]
    fn reach_m(&self, _instance: usize) -> f32 {
        0.0
    }

    #[inline(always)]
    fn move_lanes(&self, _instance: usize, _points_grid: &mut [[f64; LANES]; 3]) {}
}

/// Half of a turn: azimuths up to a right angle from its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HalfTurn {
    /// Azimuth of its middle.
    pub middle_rad: f64,
    /// When the beam points there, in seconds from the scan's instant.
    pub middle_s: f64,
    /// By how much later it points one radian farther counter-clockwise.
    pub slope_s_per_rad: f64,
}

/// How much farther than a right angle from the middle of a half turn times go on: what lies behind is seen by no beam, but
/// may be a corner of what is.
const BEYOND_RAD: f64 = 0.3;

impl HalfTurn {
    /// The longest time from the scan's instant at which it sees anything.
    fn most_s(&self) -> f64 {
        self.middle_s.abs() + (0.5 * PI + BEYOND_RAD) * self.slope_s_per_rad.abs()
    }

    /// When the beam passes a place.
    #[inline(always)]
    fn time_s(&self, x: f64, y: f64) -> f64 {
        let off_rad = wrap_angle(f64::from(azimuth_rad_of(x as f32, y as f32)) - self.middle_rad);
        let most_rad = 0.5 * PI + BEYOND_RAD;
        self.middle_s + off_rad.clamp(-most_rad, most_rad) * self.slope_s_per_rad
    }
}

/// Points that move steadily, as the beams of half a turn meet them: to first order in time.
pub(crate) struct MetWhileTurning {
    half: HalfTurn,
    /// Of each instance, as the sensor sees it.
    velocities: Vec<Velocity>,
}

/// A steady motion in the frame of the sensor: that of its origin, and about it.
#[derive(Debug, Clone, Copy)]
struct Velocity {
    linear_m_per_s: DVec3,
    angular_rad_per_s: DVec3,
    reach_m: f32,
}

/// What second-order terms may add, meters.
const CURVES_M: f64 = 0.05;

impl MetWhileTurning {
    /// Points of the scene's instances; `motion_of` says how each moves, by its index.
    pub(crate) fn new<'a>(
        half: HalfTurn,
        scene: &PosedScene,
        (world_from_velo, sensor): (&DPose3, &RigidMotion),
        motion_of: impl Fn(usize) -> Option<&'a RigidMotion>,
    ) -> Self {
        let (rest, velo_from_world) = (RigidMotion::default(), world_from_velo.rotation.inverse());
        let at_origin = |m: &RigidMotion| {
            m.velocity_world + m.angular_velocity_world.cross(world_from_velo.translation - m.pivot_world)
        };
        let velocity = |(index, instance): (usize, &PosedInstance)| {
            let body = motion_of(index).unwrap_or(&rest);
            let linear_m_per_s = velo_from_world * (at_origin(body) - at_origin(sensor));
            let angular_rad_per_s = velo_from_world * (body.angular_velocity_world - sensor.angular_velocity_world);
            let far_m = (instance.center_world - world_from_velo.translation).length() + instance.radius_m;
            let reach_m = (linear_m_per_s.length() + angular_rad_per_s.length() * far_m) * half.most_s();
            Velocity { linear_m_per_s, angular_rad_per_s, reach_m: (reach_m * 1.001 + CURVES_M) as f32 }
        };
        Self { half, velocities: scene.instances.iter().enumerate().map(velocity).collect() }
    }
}

impl AsMet for MetWhileTurning {
    #[inline(always)]
    fn reach_m(&self, instance: usize) -> f32 {
        self.velocities[instance].reach_m
    }

    #[inline(always)]
    fn move_lanes(&self, instance: usize, [x, y, z]: &mut [[f64; LANES]; 3]) {
        let Velocity { linear_m_per_s: v, angular_rad_per_s: w, .. } = self.velocities[instance];
        for i in 0..LANES {
            let p = DVec3::new(x[i], y[i], z[i]);
            let rate = v + w.cross(p);
            // Where it stands when the beam passes where it stands when the beam passes where it was.
            let first_s = self.half.time_s(p.x, p.y);
            let time_s = self.half.time_s(p.x + first_s * rate.x, p.y + first_s * rate.y);
            let met = p + rate * time_s;
            (x[i], y[i], z[i]) = (met.x, met.y, met.z);
        }
    }
}
