//! A driven car's body: a rigid chassis on four sprung wheels (ray casts), moved by an acceleration and a steering angle.

use std::sync::Arc;

use rapier3d::control::{DynamicRayCastVehicleController, WheelTuning};
use rapier3d::prelude::{MassProperties, RigidBodyBuilder, RigidBodyHandle, RigidBodyType, Vector};

use super::Body;
use super::wheels::wheel_pose;
use crate::physics::{DT_S, GRAVITY_MPS2, Physics, pose_f32, pose_f64};
use cadet_assets::vehicle::VehicleModel;
use cadet_base::math::{self, DPose3, DVec3, TAU};

/// Heave frequency of the body on its springs.
const SUSPENSION_HZ: f64 = 1.35;
/// Fraction of critical damping.
const DAMPING_RATIO: f64 = 0.65;
/// Unloaded length of a spring.
const SPRING_LENGTH_M: f64 = 0.30;
pub(crate) const MAX_STEER_RAD: f64 = 0.62;
pub(crate) const STEER_RATE_RADPS: f64 = 0.9;
/// Below this speed a car that means to stop is held where it is, as by its brakes.
const HOLD_SPEED_MPS: f64 = 0.12;
/// A held car whose springs have been slower than this for so many steps is at rest.
const REST_SPEED_MPS: f32 = 2e-3;
const REST_SPEED_RADPS: f32 = 2e-3;
const REST_STEPS: u32 = 30;

/// A car's physics.
pub(crate) struct Chassis {
    body: RigidBodyHandle,
    pub model: Arc<VehicleModel>,
    controller: DynamicRayCastVehicleController,
    mass_kg: f64,
    steer_rad: f64,
    accel_mps2: f64,
    /// The pose of its box at which the brakes hold the car, once it stands.
    held: Option<DPose3>,
    /// Steps for which a held car has been at rest.
    rest_steps: u32,
}

/// Moments of inertia of a box about its middle.
fn box_inertia(mass_kg: f64, size: DVec3) -> DVec3 {
    DVec3::new(size.y * size.y + size.z * size.z, size.x * size.x + size.z * size.z, size.x * size.x + size.y * size.y)
        * (mass_kg / 12.0)
}

impl Chassis {
    /// A car standing (or rolling at `speed_mps`) at a settled pose of its box frame.
    pub fn new(physics: &mut Physics, model: Arc<VehicleModel>, world_from_box: &DPose3, speed_mps: f64) -> Self {
        let size = model.size_lwh;
        let mass_kg = 130.0 * size.x * size.y * size.z;
        let axle = |i: usize| f64::from(model.wheel_centers[i].x);
        let com = DVec3::new((axle(0) + axle(2)) / 2.0, 0.0, 0.37 * size.z);
        let inertia = box_inertia(mass_kg, size);
        let velocity = world_from_box.rotation * DVec3::new(speed_mps, 0.0, 0.0);
        let body = RigidBodyBuilder::dynamic()
            .pose(pose_f32(world_from_box))
            .linvel(velocity.as_vec3())
            .additional_mass_properties(MassProperties::new(com.as_vec3(), mass_kg as f32, inertia.as_vec3()))
            .can_sleep(false);
        let body = physics.insert_vehicle(body, size, (0.9 * model.wheel_radius_m).min(0.4 * size.z));
        let omega = TAU * SUSPENSION_HZ;
        // rapier's forces are per unit of the whole body's mass, and four wheels share it.
        let stiffness = omega * omega / 4.0;
        let damping = DAMPING_RATIO * omega / 2.0;
        let tuning = WheelTuning {
            suspension_stiffness: stiffness as f32,
            suspension_compression: damping as f32,
            suspension_damping: damping as f32,
            max_suspension_travel: SPRING_LENGTH_M as f32,
            side_friction_stiffness: 1.0,
            friction_slip: 2.0,
            max_suspension_force: (mass_kg * 40.0) as f32,
        };
        let sag_m = GRAVITY_MPS2 / (omega * omega);
        let mut controller = DynamicRayCastVehicleController::new(body);
        controller.index_up_axis = 2;
        controller.index_forward_axis = 0;
        for center in model.wheel_centers {
            let top =
                DVec3::new(f64::from(center.x), f64::from(center.y), model.wheel_radius_m + SPRING_LENGTH_M - sag_m);
            controller.add_wheel(
                top.as_vec3(),
                -Vector::Z,
                -Vector::Y,
                SPRING_LENGTH_M as f32,
                model.wheel_radius_m as f32,
                &tuning,
            );
        }
        Self { body, model, controller, mass_kg, steer_rad: 0.0, accel_mps2: 0.0, held: None, rest_steps: 0 }
    }

    /// Sets what the driver wants from now on. `stand` asks for a stop that holds.
    pub fn command(&mut self, accel_mps2: f64, steer_rad: f64, stand: bool, physics: &Physics) {
        let limit = STEER_RATE_RADPS * DT_S;
        let steer = steer_rad.clamp(-MAX_STEER_RAD, MAX_STEER_RAD);
        self.steer_rad += (steer - self.steer_rad).clamp(-limit, limit);
        // A driver's foot takes about a fifth of a second.
        self.accel_mps2 += (accel_mps2 - self.accel_mps2) * (DT_S / 0.2).min(1.0);
        if !stand {
            self.held = None;
        } else if self.held.is_none() && self.forward_mps(physics).abs() < HOLD_SPEED_MPS {
            self.held = Some(self.world_from_box(physics));
        }
    }

    /// Whether the brakes hold it where it stands.
    pub fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Casts the wheels' rays and pushes the body; to be followed by the physics step. A held car at rest is a fixed body,
    /// until its driver lets it go.
    pub fn apply(&mut self, physics: &mut Physics) {
        for wheel in &mut self.controller.wheels_mut()[..2] {
            wheel.steering = self.steer_rad as f32;
        }
        let body = &mut physics.world.bodies[self.body];
        let is_slow = body.linvel().length() < REST_SPEED_MPS && body.angvel().length() < REST_SPEED_RADPS;
        self.rest_steps = if self.held.is_some() && is_slow { self.rest_steps + 1 } else { 0 };
        if self.rest_steps >= REST_STEPS {
            if self.rest_steps == REST_STEPS {
                body.set_linvel(Vector::ZERO, false);
                body.set_angvel(Vector::ZERO, false);
                body.set_body_type(RigidBodyType::Fixed, false);
            }
            return;
        }
        if body.is_fixed() {
            body.set_body_type(RigidBodyType::Dynamic, true);
        }
        let pose = pose_f64(body.position());
        let (forward, left) = (pose.rotation * DVec3::X, pose.rotation * DVec3::Y);
        let on_ground = self.controller.wheels().iter().filter(|w| w.raycast_info().is_in_contact).count();
        let mut accel = self.accel_mps2;
        if let Some(held) = self.held {
            let velocity = body.linvel().as_dvec3();
            let off_m = (pose.translation - held.translation).dot(forward);
            accel = (-25.0 * off_m - 10.0 * velocity.dot(forward)).clamp(-6.0, 6.0);
        }
        let force = self.mass_kg * (accel + GRAVITY_MPS2 * forward.z) / 4.0;
        // Before its first step rapier knows no mass of the body: wheels without any force would divide 0 by 0, and the body
        // would not move any more.
        let is_undefined = force == 0.0 && body.mass() == 0.0;
        let force = if is_undefined { f64::from(f32::MIN_POSITIVE) } else { force };
        self.controller.wheels_mut().iter_mut().for_each(|wheel| wheel.engine_force = force as f32);
        physics.push_wheels(&mut self.controller);
        // The tires carry the slope's pull sideways at once; rapier's friction alone would let the car creep. It goes
        // last, or that friction would take it for a sideways motion and fight it.
        let body = &mut physics.world.bodies[self.body];
        if on_ground >= 3 {
            let mut sideways = left * (GRAVITY_MPS2 * left.z);
            if let Some(held) = self.held {
                let velocity = body.linvel().as_dvec3();
                sideways -= left * (25.0 * (pose.translation - held.translation).dot(left) + 4.0 * velocity.dot(left));
                // Turned wheels would let the car turn where it stands.
                let turned_rad = math::asin((held.rotation * DVec3::X).cross(forward).z.clamp(-1.0, 1.0));
                let turning_radps = f64::from(body.angvel().z);
                let inertia = box_inertia(self.mass_kg, self.model.size_lwh).z;
                let torque = -inertia * (100.0 * turned_rad + 15.0 * turning_radps);
                body.apply_torque_impulse((DVec3::Z * (torque * DT_S)).as_vec3(), false);
            }
            body.apply_impulse((sideways * self.mass_kg * DT_S).as_vec3(), false);
        }
    }

    /// Lets the car roll forwards at a speed.
    pub fn roll(&self, speed_mps: f64, physics: &mut Physics) {
        let body = &mut physics.world.bodies[self.body];
        let forward = body.position().rotation * Vector::X;
        body.set_linvel(forward * speed_mps as f32, true);
    }

    /// Moves the car to a settled pose, standing still.
    pub fn place(&mut self, physics: &mut Physics, world_from_box: &DPose3) {
        let body = &mut physics.world.bodies[self.body];
        body.set_position(pose_f32(world_from_box), true);
        body.set_linvel(Vector::ZERO, true);
        body.set_angvel(Vector::ZERO, true);
        self.steer_rad = 0.0;
        self.accel_mps2 = 0.0;
        self.held = Some(*world_from_box);
        self.rest_steps = 0;
    }

    /// Distance between the axles.
    pub fn wheelbase_m(&self) -> f64 {
        self.model.wheelbase_m()
    }

    /// Distance of the rear axle behind the middle of the box.
    pub fn rear_axle_m(&self) -> f64 {
        -f64::from(self.model.wheel_centers[2].x)
    }
}

impl Body for Chassis {
    fn world_from_box(&self, physics: &Physics) -> DPose3 {
        pose_f64(physics.world.bodies[self.body].position())
    }

    fn velocity_world(&self, physics: &Physics) -> DVec3 {
        let body = &physics.world.bodies[self.body];
        body.velocity_at_point(body.position().translation).as_dvec3()
    }

    fn angular_velocity_world(&self, physics: &Physics) -> DVec3 {
        physics.world.bodies[self.body].angvel().as_dvec3()
    }

    fn forward_mps(&self, physics: &Physics) -> f64 {
        let body = &physics.world.bodies[self.body];
        (body.position().rotation * Vector::X).dot(body.linvel()).into()
    }

    /// Sprung, steered and rolled.
    fn box_from_wheels(&self) -> Option<[DPose3; 4]> {
        let mut wheels = [DPose3::default(); 4];
        for (i, (pose, wheel)) in wheels.iter_mut().zip(self.controller.wheels()).enumerate() {
            let top = wheel.chassis_connection_point_cs.as_dvec3();
            // Before the first step no ray has been cast: the wheels stand at their design height.
            let length_m = match wheel.raycast_info().suspension_length {
                0.0 => top.z - self.model.wheel_radius_m,
                length => f64::from(length),
            };
            let center = top - DVec3::Z * length_m;
            let roll_rad = math::wrap_angle(f64::from(wheel.rotation));
            *pose = wheel_pose(center, i, f64::from(wheel.steering), roll_rad);
        }
        Some(wheels)
    }

    fn handle(&self) -> Option<RigidBodyHandle> {
        Some(self.body)
    }
}
