//! The fast renderer against the plain one, on generated suburbs, before blur and noise.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::reference::{COLUMNS, ROWS, Rate, Reference};
use crate::camera::light::Sky;
use crate::camera::render::{Scratch, radiance};
use crate::camera::sensor::{
    MEAN_LUMA, MeteredPixel, NIGHT_MEAN_LUMA, ROWS_BEFORE, VEILING_GLARE_SHARE, balanced, gain_at_night,
    gain_for_mean_luma,
};
use crate::camera::{Maps, View, kitti_like, visibility_pass};
use crate::lidar::LidarSpec;
use crate::rig::Mount;
use crate::sense::{PosedScene, Resolution};
use crate::weather::Weather;
use cadet_base::frames;
use cadet_base::math::{DMat3, DPose3, DQuat, DVec3, Vec3};
use cadet_base::rng::StreamKey;
use cadet_town::{PropConfig, SuburbConfig, Town};
use cadet_world::{TrafficConfig, World};

/// Of 255.
const NEAR_LEVELS: f32 = 2.0;

/// Numbers of a suburb and its traffic.
#[derive(Default)]
struct Street {
    suburb: SuburbConfig,
    props: PropConfig,
    traffic: TrafficConfig,
}

impl Street {
    /// What stands there after two seconds, in the camera's view from the ego.
    fn seen(&self, key: StreamKey, weather: &Weather) -> (Arc<PosedScene>, View) {
        let town = Town::suburb(&key, &self.suburb, &self.props).expect("a suburb");
        let mut world = World::new(Arc::new(town), key)
            .expect("drivable")
            .with_lamps(weather.needs_lamps())
            .with_night(weather.is_night())
            .with_rain(weather.rain_mm_per_h > 0.0);
        let _ = world.spawn_traffic(&self.traffic).expect("traffic");
        world.step(126);
        let snapshot = world.snapshot();
        let world_from_ego = snapshot.ego.world_from_ego;
        let camera = kitti_like();
        let resolution = Resolution::of(camera.intrinsics_px()[0], LidarSpec::cadet().azimuths_rad().len());
        let posed = PosedScene::for_resolution(&snapshot.instances, world_from_ego.translation, resolution);
        let axes = DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X);
        let velo = frames::mounted(DVec3::new(0.0, 0.0, 1.73), 0.0, 0.0, 0.0);
        let ahead = DPose3 { rotation: DQuat::from_mat3(&axes), translation: DVec3::new(0.27, 0.0, -0.08) };
        let view = View::new(&camera, &Mount::new(vec![velo, ahead]).world_from_sensor(&world_from_ego));
        (Arc::new(posed.with_lamps(&snapshot.ego_lamps)), view)
    }
}

/// Some rows of a picture, [`ROWS`] side by side each.
struct Shot {
    plain: Reference,
    view: View,
    weather: Weather,
    tops: Vec<usize>,
    /// The fast renderer's radiance in these rows.
    fast: Vec<Vec3>,
    maps: Maps,
}

impl Shot {
    fn of(seed: u64, weather: &str, change: fn(&mut Street)) -> Self {
        let key = StreamKey::scene(seed);
        let weather = Weather::preset(weather).expect("a preset");
        let mut street = Street::default();
        change(&mut street);
        let (posed, view) = street.seen(key, &weather);
        let weather = weather.with_sun_turned(&mut key.stream("sun"));
        let seen = visibility_pass(&posed, &view).expect("a view");
        let mut scratch = Scratch::default();
        let _ = radiance(&posed, &view, &weather, &seen, &mut scratch);
        let image = &scratch.rgb[ROWS_BEFORE * view.width * 3..];
        let pixel = |at: usize| Vec3::new(image[3 * at], image[3 * at + 1], image[3 * at + 2]);
        let tops: Vec<usize> = (3..view.height / ROWS).step_by(12).map(|four| ROWS * four).collect();
        let fast = tops.iter().flat_map(|top| top * view.width..(top + ROWS) * view.width).map(pixel).collect();
        Self { plain: Reference::new(&posed, &view, &weather), maps: seen.maps(&posed), view, weather, tops, fast }
    }

    /// What the plain renderer sees in the rows.
    fn plain(&self, rate: Rate) -> Vec<Vec3> {
        let rows = |top: &usize| {
            let blocks: Vec<_> =
                (0..self.view.width).step_by(COLUMNS).map(|left| self.plain.block(*top, left, rate)).collect();
            let pixel = move |i: usize| {
                let (row, column) = (i / self.view.width, i % self.view.width);
                blocks[column / COLUMNS][row][column % COLUMNS]
            };
            (0..ROWS * self.view.width).map(pixel)
        };
        self.tops.iter().flat_map(rows).collect()
    }

    /// Shares of the pixels whose channels are all within two levels; and what those show that are not, by class.
    fn agreement(&self, plain: &[Vec3]) -> (f64, BTreeMap<u8, usize>) {
        let is_night = self.weather.is_night();
        let ceiling = Vec3::splat(if is_night { 1.0 } else { 2.0 * Sky::new(&self.weather).sky_on_level.y });
        let veil = plain.iter().map(|p| p.min(ceiling)).sum::<Vec3>() * (VEILING_GLARE_SHARE / plain.len() as f32);
        let veiled = |pixels: &[Vec3]| -> Vec<MeteredPixel> {
            pixels.iter().map(|p| (balanced(p.to_array(), veil.to_array()), 1.0)).collect()
        };
        let [fast, plain] = [veiled(&self.fast), veiled(plain)];
        let [fast_gain, gain] = [&fast, &plain].map(|pixels| {
            if is_night {
                gain_at_night(pixels, NIGHT_MEAN_LUMA[0]).min(24_000.0)
            } else {
                gain_for_mean_luma(pixels, MEAN_LUMA[0])
            }
        });
        assert!((fast_gain / gain - 1.0).abs() < 2e-3, "{fast_gain} {gain}");
        let level = |balanced: [f32; 3]| (Vec3::from(balanced) * gain).min(Vec3::splat(255.0));
        let mut far: BTreeMap<u8, usize> = BTreeMap::new();
        for (i, ((a, _), (b, _))) in fast.iter().zip(&plain).enumerate() {
            if (level(*a) - level(*b)).abs().max_element() > NEAR_LEVELS {
                let at = self.tops[i / (ROWS * self.view.width)] * self.view.width + i % (ROWS * self.view.width);
                *far.entry(self.maps.semantic[at]).or_default() += 1;
            }
        }
        (1.0 - far.values().sum::<usize>() as f64 / plain.len() as f64, far)
    }
}

/// Seed, weather, and what is unlike in the suburb.
type Setting = (u64, &'static str, fn(&mut Street));

const SHOTS: [Setting; 11] = [
    (0, "clear_noon", |_| ()),
    (1, "clear_sunset", |street| street.props.house_shares = [0.0, 0.0, 0.0, 0.5, 0.2, 0.3]),
    (2, "soft_rain_noon", |_| ()),
    (3, "dense_fog", |street| street.traffic.num_pedestrians = 60),
    (4, "snow", |street| street.suburb.hilly_share = 1.0),
    (5, "dusk", |street| street.traffic.num_cars = 30),
    (6, "wet_noon", |street| street.props.greenery = 0.2),
    (7, "hard_rain_sunset", |_| ()),
    (8, "clear_night", |street| street.traffic.num_cars = 30),
    (9, "wet_night", |street| street.props.city_share = 1.0),
    (10, "rain_night", |_| ()),
];

#[test]
fn it_agrees_with_the_plain_one_within_two_levels() {
    let mut sum = 0.0;
    for (seed, weather, change) in SHOTS {
        let shot = Shot::of(seed, weather, change);
        let (share, far) = shot.agreement(&shot.plain(Rate::Coarse));
        assert!(share > 0.994, "{seed} {weather}: {share}, others by class: {far:?}");
        sum += share;
    }
    let mean = sum / SHOTS.len() as f64;
    assert!(mean > 0.9985, "{mean}");
}

#[test]
fn what_it_leaves_out_between_pixels_is_as_little_as_stated() {
    for (seed, weather, change) in [SHOTS[0], SHOTS[2]] {
        let shot = Shot::of(seed, weather, change);
        let (share, _) = shot.agreement(&shot.plain(Rate::Pixel));
        assert!(share > 0.92, "{seed} {weather}: {share}");
    }
}
