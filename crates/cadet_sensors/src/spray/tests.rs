//! Depths along rays against closed forms, and who has a plume.

use super::*;
use cadet_base::actor::AnnotatedBox;
use cadet_base::math;

/// A vehicle that drives along the world's x axis with its rear bumper at the origin.
pub fn vehicle(class: ObjectClass, size_lwh: DVec3, speed_mps: f64) -> ActorState {
    ActorState {
        id: 7,
        class,
        model: "saloon/1".to_owned(),
        size_lwh,
        annotated: AnnotatedBox::exact(size_lwh),
        world_from_box: DPose3::from_translation(DVec3::new(0.5 * size_lwh.x, 0.0, 0.0)),
        velocity_world: DVec3::X * speed_mps,
        angular_velocity_world: DVec3::ZERO,
        brakes_for: None,
    }
}

pub const CAR_M: DVec3 = DVec3::new(4.3, 1.8, 1.5);
const TRUCK_M: DVec3 = DVec3::new(9.0, 2.5, 3.6);

fn raining(wetness: f64) -> Weather {
    Weather::of_air(0.0, 25.0, 0.0, wetness).expect("valid")
}

fn behind(weather: &Weather, actor: &ActorState) -> Spray {
    Spray::behind(weather, std::slice::from_ref(actor), &mut Stream::from_seed("spray", 1))
}

/// A plume without lumps.
pub fn smooth(class: ObjectClass, size_lwh: DVec3, speed_mps: f64) -> Spray {
    let mut spray = behind(&raining(1.0), &vehicle(class, size_lwh, speed_mps));
    spray.plumes.iter_mut().for_each(|plume| plume.lumps = [1.0; CORNERS]);
    spray
}

/// Optical depth of a ray before an end, by 20,000 steps.
pub fn depth(plume: &Plume, from: Vec3, direction: Vec3, end: f32) -> f64 {
    let Some([a, b]) = plume.crossing(from, direction, end) else { return 0.0 };
    let steps = 20_000;
    let step = f64::from(b - a) / f64::from(steps);
    let at = |k: i32| from + direction * (f64::from(a) + (f64::from(k) + 0.5) * step) as f32;
    (0..steps).map(|k| f64::from(plume.extinction_per_m(at(k))) * step).sum()
}

#[test]
fn a_ray_along_the_road_meets_the_depth_of_speed_water_and_size() {
    for (size, speed_mps, wetness) in [(CAR_M, 14.0, 1.0), (CAR_M, 25.0, 0.5), (TRUCK_M, 22.0, 1.0)] {
        let actor = vehicle(ObjectClass::Car, size, speed_mps);
        let mut spray = behind(&raining(wetness), &actor);
        spray.plumes[0].lumps = [1.0; CORNERS];
        let expected = 0.0025 * (speed_mps * speed_mps - 64.0) * wetness * (size.y * size.z / 2.7).sqrt();
        let got = depth(&spray.plumes[0], Vec3::new(-40.0, 0.0, 0.0), Vec3::X, 1e3);
        assert!((got / expected - 1.0).abs() < 2e-3, "{speed_mps}: {got} {expected}");
    }
}

#[test]
fn a_ray_across_meets_what_the_profile_holds() {
    let spray = smooth(ObjectClass::Car, CAR_M, 14.0);
    let plume = &spray.plumes[0];
    // At u = 1/2 of 12 m the integral of (1 - (y / w)^4)^2 is 64/45 w with w = 0.9 * 1.25, and a quarter of the peak is left.
    let expected = plume.peak_per_m * 0.25 * 64.0 / 45.0 * 0.9 * 1.25;
    let got = depth(plume, Vec3::new(-6.0, -30.0, 0.0), Vec3::Y, 1e3);
    assert!((got / f64::from(expected) - 1.0).abs() < 2e-3, "{got} {expected}");
    // Above and beside it there is nothing.
    assert_eq!(depth(plume, Vec3::new(-30.0, 0.0, 1.21), Vec3::X, 1e3), 0.0);
    assert_eq!(depth(plume, Vec3::new(-30.0, 1.36, 0.5), Vec3::X, 1e3), 0.0);
}

#[test]
fn cars_at_town_speeds_hide_less_than_half_and_trucks_more() {
    let opacity = |class, size, speed_mps| {
        let spray = smooth(class, size, speed_mps);
        1.0 - math::exp(-depth(&spray.plumes[0], Vec3::new(-40.0, 0.0, 0.3), Vec3::X, 1e3))
    };
    let (slow, town) = (opacity(ObjectClass::Car, CAR_M, 10.0), opacity(ObjectClass::Car, CAR_M, 16.7));
    let truck = opacity(ObjectClass::Truck, TRUCK_M, 16.7);
    assert!(slow < 0.12 && (0.2..0.5).contains(&town) && (0.5..0.8).contains(&truck), "{slow} {town} {truck}");
    let heights = [CAR_M, TRUCK_M].map(|size| smooth(ObjectClass::Truck, size, 15.0).plumes[0].bounds()[1].z);
    assert!((1.0..1.5).contains(&heights[0]) && (heights[1] - 3.6).abs() < 1e-6, "{heights:?}");
}

#[test]
fn lumps_leave_the_mean_and_come_from_the_stream_and_the_vehicle() {
    let actor = vehicle(ObjectClass::Car, CAR_M, 20.0);
    let deep = |seed: u64, id: i32| {
        let actor = ActorState { id, ..actor.clone() };
        let spray = Spray::behind(&raining(1.0), &[actor], &mut Stream::from_seed("spray", seed));
        depth(&spray.plumes[0], Vec3::new(-40.0, 0.0, 0.2), Vec3::X, 1e3)
    };
    assert_eq!(deep(3, 7), deep(3, 7));
    assert!(deep(3, 7) != deep(4, 7) && deep(3, 7) != deep(3, 8));
    let mean = (0..60).map(|seed| deep(seed, 7)).sum::<f64>() / 60.0;
    let smooth = depth(&smooth(ObjectClass::Car, CAR_M, 20.0).plumes[0], Vec3::new(-40.0, 0.0, 0.2), Vec3::X, 1e3);
    assert!((mean / smooth - 1.0).abs() < 0.06, "{mean} {smooth}");
}

#[test]
fn nothing_sprays_that_is_slow_or_on_rails_nor_on_a_dry_road() {
    let count = |weather: &Weather, class, speed_mps| behind(weather, &vehicle(class, CAR_M, speed_mps)).plumes.len();
    assert_eq!(count(&raining(1.0), ObjectClass::Car, 14.0), 1);
    for speed_mps in [-14.0, 0.0, 8.0] {
        assert_eq!(count(&raining(1.0), ObjectClass::Car, speed_mps), 0, "{speed_mps}");
    }
    assert_eq!(count(&raining(1.0), ObjectClass::Tram, 14.0), 0);
    for name in ["clear_noon", "wet_noon", "snow", "dense_fog", "wet_night"] {
        assert_eq!(count(&Weather::preset(name).expect("known"), ObjectClass::Car, 14.0), 0, "{name}");
    }
}
