//! Numbers, sizes, and streaks against closed forms.

use super::*;
use cadet_base::math::{DPose3, DQuat};

/// x right, y down, z forward of a camera that looks along the world's x axis.
fn view_at(at: DVec3) -> View {
    let rotation = DQuat::from_mat3(&math::DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X));
    let world_from_cam = DPose3 { rotation, translation: at };
    View { intrinsics_px: [721.0, 721.0, 610.0, 173.0], width: 1242, height: 375, world_from_cam }
}

fn falling(rain: f64, snow: f64, ego_mps: f64) -> Precipitation {
    let weather = Weather::of_air(0.0, rain, snow, 0.0).expect("valid");
    let stream = &mut Stream::from_seed("falling", 1);
    Precipitation::of(&weather, DVec3::new(0.3, 0.2, 1.6), DVec3::X * ego_mps, stream).expect("it falls")
}

fn cells(of: &Precipitation, radius_m: f64) -> Vec<DVec3> {
    let n = radius_m as i64;
    let center = of.center_world.floor();
    (-n..=n)
        .flat_map(|i| (-n..=n).flat_map(move |j| (-n..=n).map(move |k| DVec3::new(i as f64, j as f64, k as f64))))
        .map(|low| center + low)
        .collect()
}

#[test]
fn nothing_falls_from_a_dry_sky() {
    let weather = Weather::preset("clear_noon").expect("known");
    assert!(Precipitation::of(&weather, DVec3::ZERO, DVec3::ZERO, &mut Stream::from_seed("a", 0)).is_none());
}

#[test]
fn there_are_as_many_large_drops_in_a_cubic_meter_as_the_distribution_says() {
    for (rain, snow, limit_m) in [(25.0, 0.0, 0.003), (8.0, 0.0, 0.002), (0.0, 1.5, 0.006)] {
        let falling = falling(rain, snow, 0.0);
        let (mut count, mut volume_m3) = (0, 0.0);
        for low in cells(&falling, 2.0) {
            volume_m3 += 1.0;
            falling.for_each_in_cell(low, |p| count += usize::from(p.diameter_m > limit_m));
        }
        let sizes = falling.sizes;
        let expected = volume_m3 * sizes.number_per_m3 * math::exp(-sizes.slope_per_m * limit_m);
        assert!((count as f64 - expected).abs() < 5.0 * expected.sqrt() + 1.0, "{rain} {snow}: {count}, {expected}");
    }
}

#[test]
fn a_drop_of_two_millimeters_falls_at_six_and_a_half_meters_a_second() {
    // Gunn and Kinzer's measurements (1949): 4.03, 6.49 and 8.83 m/s at 1, 2 and 4 mm.
    for (mm, mps) in [(1.0, 4.03), (2.0, 6.49), (4.0, 8.83)] {
        assert!((drop_mps(mm * 1e-3) - mps).abs() < 0.2, "{mm}: {}", drop_mps(mm * 1e-3));
    }
}

#[test]
fn a_streak_is_as_long_as_its_way_and_covers_as_much_as_its_disc() {
    let falling = falling(25.0, 0.0, 0.0);
    let view = view_at(DVec3::ZERO);
    let particle = FallingParticle {
        at_world: DVec3::new(2.0, 0.0, 0.0),
        velocity_world: DVec3::new(0.0, 0.0, -7.0),
        diameter_m: 0.003,
    };
    let streak = falling.streak(&view, &view.world_from_cam.inverse(), &particle).expect("in view");
    let [[ax, ay], [bx, by]] = streak.ends_px;
    assert!((ax - bx).abs() < 1e-9 && (by - ay - 721.0 * 7.0 * SHUTTER_S / 2.0).abs() < 1e-9);
    // A white streak over black: the sum of the pixels is the area of the disc, 0.25 pi (721 * 0.003 / 2)^2.
    let mut rgb = vec![0.0; 3 * view.width * view.height];
    streak.draw(&mut rgb, &view, Vec3::ONE);
    let sum: f64 = rgb.iter().map(|v| f64::from(*v)).sum::<f64>() / 3.0;
    let width_px = 721.0 * 0.003 / 2.0;
    let disc = 0.25 * math::PI * width_px * width_px;
    assert!((sum - disc).abs() < 0.1 * disc, "{sum} {disc}");
}

#[test]
fn wind_from_the_side_slants_streaks_by_its_speed_over_that_of_the_fall() {
    let wind_world = DVec3::Y * 5.0;
    let weather = Weather::of_air(0.0, 25.0, 0.0, 0.0).expect("valid");
    let stream = &mut Stream::from_seed("falling", 1);
    let falling = Precipitation::of(&weather, DVec3::ZERO, -wind_world, stream).expect("it falls");
    let view = view_at(DVec3::ZERO);
    let particle = FallingParticle {
        at_world: DVec3::new(2.0, 0.0, 0.0),
        velocity_world: DVec3::new(0.0, 0.0, -7.0),
        diameter_m: 0.003,
    };
    let [[ax, ay], [bx, by]] =
        falling.streak(&view, &view.world_from_cam.inverse(), &particle).expect("in view").ends_px;
    // To the left, as the wind blows, while it falls.
    assert!(((bx - ax) / (by - ay) + 5.0 / 7.0).abs() < 1e-9, "{ax} {bx}");
}

#[test]
fn streaks_lead_away_from_where_the_car_drives() {
    let falling = falling(0.0, 1.5, 14.0);
    let view = view_at(DVec3::new(0.3, 0.2, 1.6));
    let (mut outward, mut count) = (0, 0);
    falling.for_each_streak(&view, |streak| {
        let [a, b] = streak.ends_px;
        let off = [0.5 * (a[0] + b[0]) - 610.0, 0.5 * (a[1] + b[1]) - 173.0];
        if math::hypot(off[0], off[1]) > 150.0 {
            count += 1;
            outward += usize::from((b[0] - a[0]) * off[0] + (b[1] - a[1]) * off[1] > 0.0);
        }
    });
    assert!(count > 100 && outward as f64 > 0.95 * f64::from(count), "{outward} of {count}");
}

#[test]
fn both_cameras_of_a_pair_see_the_same_flakes() {
    let falling = falling(0.0, 1.5, 0.0);
    let streaks = |y_world: f64| {
        let mut all = Vec::new();
        falling.for_each_streak(&view_at(DVec3::new(0.3, y_world, 1.6)), |streak| all.push(*streak));
        all
    };
    // 0.54 m beside each other; y is to the left.
    let (left, right) = (streaks(0.2), streaks(0.2 - 0.54));
    let far: Vec<_> = left.iter().filter(|s| s.depth_m > 4.0 && (300.0..900.0).contains(&s.ends_px[0][0])).collect();
    assert!(far.len() > 20);
    for streak in far {
        let column = streak.ends_px[0][0] - 721.0 * 0.54 / streak.depth_m;
        let is_same = |o: &&Streak| {
            (o.ends_px[0][0] - column).abs() < 0.5 && (o.ends_px[0][1] - streak.ends_px[0][1]).abs() < 1e-6
        };
        assert!(right.iter().any(|o| is_same(&o)), "{streak:?}");
    }
}
