//! Plumes of spray in the image against sums along single rays.

use super::*;
use crate::camera::light::Light;
use crate::camera::overlays::spray::draw;
use crate::camera::render::{Foreground, Scratch, radiance, render_through};
use crate::camera::visibility::Visibility;
use crate::spray::Spray;
use crate::spray::tests::{CAR_M, depth, smooth, vehicle};
use cadet_base::actor::ObjectClass;

/// A view of a smooth plume of 12 m from 20 m behind the bumper, over a road, with more in it.
struct Sight {
    view: View,
    seen: Visibility,
    light: Light,
    spray: Spray,
}

fn sight(more: Vec<Instance>) -> Sight {
    let scene = PosedScene::new(&[vec![ground()], more].concat(), DVec3::ZERO);
    let mut view = view();
    view.world_from_cam.translation.x = -20.0;
    let weather = Weather::of_air(0.0, 25.0, 0.0, 1.0).expect("valid");
    let seen = visibility_pass(&scene, &view).expect("a camera");
    let light = radiance(&scene, &view, &weather, &seen, &mut Scratch::default());
    Sight { view, seen, light, spray: smooth(ObjectClass::Truck, DVec3::new(9.0, 2.5, 3.6), 14.0) }
}

impl Sight {
    /// Draws the spray over an image of one brightness.
    fn over(&self, brightness: f32) -> Vec<f32> {
        let mut rgb = vec![brightness; 3 * self.view.width * self.view.height];
        draw(&self.spray, &mut rgb, &self.view, &self.seen, &self.light);
        rgb
    }

    /// Share of the light behind that is left at pixels' middles, by a sum along their rays up to what they show.
    fn expected(&self, row: usize, column: usize) -> f64 {
        let [fx, fy, cx, cy] = self.view.intrinsics_px;
        let plume = &self.spray.plumes()[0];
        // Two samples a pixel.
        let of = |shift: f64| {
            let in_cam = DVec3::new((column as f64 + shift - cx) / fx, (row as f64 + shift - cy) / fy, 1.0);
            let plume_from_cam = *plume.plume_from_world() * self.view.world_from_cam;
            let direction = (plume_from_cam.rotation * in_cam).as_vec3();
            let shown_m = self.seen.depth_m_at(row, column);
            let depth = depth(plume, plume_from_cam.translation.as_vec3(), direction, shown_m);
            math::exp(-depth * in_cam.length())
        };
        0.5 * (of(0.0) + of(0.5))
    }
}

/// A wall across the road, between two distances behind the bumper.
fn wall(behind_m: f32) -> Vec<Instance> {
    let (low, high) = (Vec3::new(-behind_m - 0.1, -3.0, 0.0), Vec3::new(-behind_m, 3.0, 4.0));
    vec![cuboid(low, high, gray(Semantic::Building, 0.3), 3)]
}

#[test]
fn as_much_light_is_left_as_the_spray_before_it_lets_through() {
    // Before the sky and the road, and before walls behind the plume and in the middle of it.
    for more in [Vec::new(), wall(-1.0), wall(6.0)] {
        let sight = sight(more);
        let (black, white) = (sight.over(0.0), sight.over(1.0));
        let (mut compared, mut sum, mut worst) = (0, 0.0, 0.0_f64);
        for row in (2..98).step_by(3) {
            for column in (2..318).step_by(3) {
                let at = 3 * (row * sight.view.width + column);
                // The lower half pixel of what ends in between shows something else.
                let neighbors = [(row + 1, column), (row, column + 1), (row + 1, column + 1)];
                let depth_m = sight.seen.depth_m_at(row, column);
                if neighbors.iter().any(|(r, c)| (sight.seen.depth_m_at(*r, *c) - depth_m).abs() > 0.6) {
                    continue;
                }
                let expected = sight.expected(row, column);
                let error = (f64::from(white[at + 1] - black[at + 1]) - expected).abs();
                if expected < 0.97 {
                    (compared, sum) = (compared + 1, sum + error);
                }
                worst = worst.max(error);
            }
        }
        let mean = sum / f64::from(compared);
        assert!(compared > 40 && mean < 0.01 && worst < 0.05, "{compared} {mean} {worst}");
    }
}

#[test]
fn what_stands_before_a_plume_is_as_it_was_and_what_stands_behind_turns_to_the_light_around() {
    for (behind_m, is_before) in [(13.0, true), (-1.0, false)] {
        let sight = sight(wall(behind_m));
        let (gray, around) = (sight.over(0.02), sight.light.around());
        let middle = 3 * (45 * sight.view.width + 155);
        let pixel = Vec3::from_slice(&gray[middle..middle + 3]);
        if is_before {
            assert_eq!(pixel, Vec3::splat(0.02));
            assert!(gray.iter().filter(|v| **v != 0.02).count() < 3 * 40, "only beside the wall's foot");
        } else {
            assert!(pixel.y > 0.04 && pixel.y < around.y && (pixel.x / pixel.z) < 1.0, "{pixel} {around}");
        }
    }
}

#[test]
fn a_camera_in_a_plume_sees_through_what_is_before_it() {
    let mut sight = sight(Vec::new());
    sight.view.world_from_cam.translation.x = -5.0;
    sight.seen = visibility_pass(&PosedScene::new(&[ground()], DVec3::ZERO), &sight.view).expect("a camera");
    let (black, white) = (sight.over(0.0), sight.over(1.0));
    let mut worst = 0.0_f64;
    for (row, column) in [(20, 20), (30, 155), (45, 100), (10, 290)] {
        let at = 3 * (row * sight.view.width + column);
        worst = worst.max((f64::from(white[at] - black[at]) - sight.expected(row, column)).abs());
    }
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn without_spray_no_byte_changes() {
    let scene = PosedScene::new(&[ground()], DVec3::ZERO);
    let (view, clear) = (view(), Weather::preset("clear_noon").expect("known"));
    let seen = visibility_pass(&scene, &view).expect("a camera");
    let image = |weather: &Weather, spray_weather: &Weather, speed_mps: f64| {
        let actors = [vehicle(ObjectClass::Car, CAR_M, speed_mps)];
        let spray = Spray::behind(spray_weather, &actors, &mut Stream::from_seed("spray", 0));
        let foreground = Foreground { spray, ..Foreground::default() };
        let mut view = view.clone();
        view.world_from_cam.translation.x = -20.0;
        render_through(&scene, &view, weather, &seen, &foreground, &mut Stream::from_seed("camera", 0)).image
    };
    let rain = Weather::preset("hard_rain_noon").expect("known");
    assert_eq!(image(&clear, &clear, 20.0), image(&clear, &rain, 8.0));
    assert_ne!(image(&clear, &clear, 20.0), image(&clear, &rain, 20.0));
}
