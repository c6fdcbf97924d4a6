use super::super::echo_batch::EchoBatch;
use super::*;
use crate::lidar::echoes::{HitSurface, first_echo};
use crate::lidar::{LidarSpec, Receiver, Scan};
use crate::sense::LaserRing;
use crate::weather::Weather;
use cadet_base::material::{Material, Pattern};
use cadet_base::math;
use cadet_base::rng::Stream;

fn surface(material: &Material, range_m: f64, cos_incidence: f64, actor_id: i32) -> HitSurface<'_> {
    let normal_velo = [0.0; 3];
    HitSurface { range_m, cos_incidence, material, texture_factor: 1.0, snow_cover: 0.0, normal_velo, actor_id }
}

/// The point that is written of one beam.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Return {
    range_m: f64,
    intensity: f64,
    actor_id: i32,
}

/// The receiver of a laser of that gain, which looks ahead.
fn of_gain(laser_gain: f64) -> RingReceiver {
    let mut spec = LidarSpec::new("one", vec![LaserRing::on_axis(0.0, 0.0)], vec![0.0]).expect("valid");
    spec.laser_receivers[0].gain = laser_gain;
    // Drops and flakes nearer than points of KITTI's files are to be seen here.
    spec.min_range_m = 0.0;
    spec.ring_receiver(0)
}

/// The points that a receiver writes of one beam, with their echoes' numbers.
fn written(
    echoes: [Option<Echo>; 4],
    air: &Air,
    mode: ReturnMode,
    receiver: &RingReceiver,
    draws: &Draws,
) -> Vec<(u8, Return)> {
    let mut batch = EchoBatch::new();
    let push = |arrival: &Arrival| batch.push(arrival, draws, 0, [[0.0; 3], [1.0, 0.0, 0.0]]);
    arrivals(&echoes, air, |_| Sprayed::NOT, (mode, receiver, draws), push);
    let mut out = Scan::default();
    batch.receive(receiver, 0, false, &mut out);
    let point = |i: usize| Return {
        range_m: out.range_m[i],
        intensity: f64::from(out.points_velo[i][3]),
        actor_id: out.actor_id[i],
    };
    (0..out.range_m.len()).map(|i| (out.echo[i], point(i))).collect()
}

fn receive(
    transparent: Option<HitSurface<'_>>,
    opaque: Option<HitSurface<'_>>,
    air: &Air,
    laser_gain: f64,
    draws: &Draws,
) -> Option<Return> {
    let echoes = [first_echo(transparent, opaque, draws), None, None, None];
    Some(written(echoes, air, ReturnMode::Strongest, &of_gain(laser_gain), draws).first()?.1)
}

fn clear() -> Air {
    air_of("clear_noon")
}

fn air_of(weather: &str) -> Air {
    Air::new(&Weather::preset(weather).expect("exists"), &Receiver::default(), 6.0)
}

/// Share of beams that return, share of zeros among them, mean intensity, over all lasers of KITTI's sensor.
fn statistics(transparent: Option<HitSurface<'_>>, opaque: Option<HitSurface<'_>>, air: &Air) -> (f64, f64, f64) {
    let mut stream = Stream::from_seed("returns", 1);
    let n = 20_000;
    let lasers = LidarSpec::hdl64e_kitti().laser_receivers;
    let all: Vec<Return> = (0..n)
        .filter_map(|i| {
            receive(transparent, opaque, air, lasers[i % lasers.len()].gain, &Draws::new(stream.next_u64(), 0))
        })
        .collect();
    let count = all.len().max(1) as f64;
    let zeros = all.iter().filter(|r| r.intensity == 0.0).count() as f64 / count;
    (all.len() as f64 / n as f64, zeros, all.iter().map(|r| r.intensity).sum::<f64>() / count)
}

#[test]
fn asphalt_foliage_and_facades_look_as_in_kitti() {
    use Pattern::{Asphalt, Leaves, Render};
    // (pattern, reflectance, cosine, range, returns, zeros, mean intensity): lower and upper limits.
    let cases = [
        (Asphalt, 0.23, 0.15, 11.5, 0.99..=1.0, 0.01..=0.14, 0.20..=0.27),
        (Asphalt, 0.23, 0.28, 6.0, 0.99..=1.0, 0.01..=0.14, 0.20..=0.28),
        (Asphalt, 0.23, 0.08, 21.0, 0.99..=1.0, 0.02..=0.30, 0.15..=0.24),
        (Asphalt, 0.23, 0.043, 40.0, 0.95..=1.0, 0.80..=1.0, 0.0..=0.05),
        (Asphalt, 0.23, 0.027, 65.0, 0.1..=0.50, 0.80..=1.0, 0.0..=0.05),
        (Leaves, 0.45, 0.6, 12.0, 0.99..=1.0, 0.01..=0.14, 0.28..=0.37),
        (Leaves, 0.45, 0.6, 45.0, 0.97..=1.0, 0.25..=0.60, 0.05..=0.20),
        (Render, 0.62, 0.8, 12.0, 0.99..=1.0, 0.0..=0.16, 0.32..=0.41),
        (Render, 0.62, 0.8, 45.0, 0.97..=1.0, 0.10..=0.45, 0.08..=0.25),
    ];
    for (pattern, rho, cos, range_m, returns, zeros, mean) in cases {
        let material = Material::matt(Semantic::Building, [0.3; 3], pattern, rho);
        let got = statistics(None, Some(surface(&material, range_m, cos, 0)), &clear());
        assert!(
            returns.contains(&got.0) && zeros.contains(&got.1) && mean.contains(&got.2),
            "{rho} {range_m}: {got:?}"
        );
    }
}

#[test]
fn black_paint_is_lost_beyond_25_m_and_silver_beyond_70_m() {
    let mut paint = Material::matt(Semantic::Car, [0.1; 3], Pattern::Plain, 0.07);
    paint.lidar.coat_index = 1.5;
    let of = |paint: &Material, range_m| statistics(None, Some(surface(paint, range_m, 0.8, 1)), &clear());
    let at = |range_m| of(&paint, range_m).0;
    assert!(at(30.0) > 0.99 && at(40.0) > 0.9 && at(80.0) < 0.2, "{} {} {}", at(30.0), at(40.0), at(80.0));
    paint.lidar.reflectance = 0.006;
    let (near, far) = (of(&paint, 9.0), of(&paint, 30.0));
    assert!(near.0 > 0.8 && near.1 > 0.95 && far.0 < 0.1, "{near:?} {far:?}");
}

#[test]
fn glass_answers_where_it_is_dusty_and_lets_the_rest_through() {
    let mut glass = Material::matt(Semantic::Car, [0.1; 3], Pattern::Plain, 0.04);
    glass.transmission = 0.8;
    glass.lidar.transmission = 0.8;
    let seat = Material::matt(Semantic::Car, [0.1; 3], Pattern::Plain, 0.4);
    let mut stream = Stream::from_seed("glass", 0);
    let (mut own, mut inside, n) = (0, 0, 20_000);
    for _ in 0..n {
        let draws = Draws::new(stream.next_u64(), 0);
        match receive(Some(surface(&glass, 8.0, 0.7, 3)), Some(surface(&seat, 9.0, 0.9, 3)), &clear(), 1.0, &draws) {
            Some(r) if r.range_m < 8.5 => own += 1,
            Some(_) => inside += 1,
            None => {}
        }
    }
    let (own, inside) = (f64::from(own) / f64::from(n), f64::from(inside) / f64::from(n));
    assert!((own - 0.45).abs() < 0.02 && (own + inside - 1.0).abs() < 0.01, "{own} {inside}");
    let sky_behind = statistics(Some(surface(&glass, 8.0, 0.7, 3)), None, &clear());
    assert!((sky_behind.0 - 0.45).abs() < 0.02, "{sky_behind:?}");
}

#[test]
fn snow_on_a_pane_returns_itself_and_snow_on_black_paint_is_bright() {
    let mut glass = Material::matt(Semantic::Car, [0.1; 3], Pattern::Plain, 0.04);
    (glass.transmission, glass.lidar.transmission) = (0.8, 0.8);
    let paint = Material::matt(Semantic::Car, [0.02; 3], Pattern::Plain, 0.01);
    let of_snow = |material, range_m, snow| HitSurface { snow_cover: snow, ..surface(material, range_m, 0.3, 3) };
    let seat = Some(surface(&paint, 9.0, 0.9, 3));
    let mut stream = Stream::from_seed("snow", 0);
    let n = 5000;
    let from_pane = (0..n).filter(|_| {
        let returned = receive(Some(of_snow(&glass, 8.0, 0.3)), seat, &clear(), 1.0, &Draws::new(stream.next_u64(), 0));
        returned.is_some_and(|r| r.range_m < 8.5)
    });
    // Beside the snow, dust.
    assert!((0.73..0.77).contains(&(from_pane.count() as f64 / f64::from(n))));
    let roof = |snow| statistics(None, Some(of_snow(&paint, 30.0, snow)), &clear());
    let (bare, white) = (roof(0.0), roof(0.9));
    assert!(bare.0 < 0.2 && white.0 > 0.99 && white.2 > 0.2, "{bare:?} {white:?}");
}

#[test]
fn plates_saturate_and_fog_takes_what_is_far() {
    let mut plate = Material::matt(Semantic::Car, [0.9; 3], Pattern::Plain, 0.9);
    plate.lidar.retro = true;
    assert!(statistics(None, Some(surface(&plate, 30.0, 0.9, 1)), &clear()).2 > 0.95);
    let wall = Material::matt(Semantic::Building, [0.5; 3], Pattern::Plain, 0.15);
    let fog = air_of("light_fog");
    let (near, far) = (surface(&wall, 10.0, 0.9, 0), surface(&wall, 70.0, 0.9, 0));
    assert!(statistics(None, Some(near), &fog).0 > 0.98);
    let mut stream = Stream::from_seed("far", 0);
    let mut seen = |air| {
        let is_seen = |r: Return| r.range_m > 60.0;
        (0..4000)
            .filter(|_| receive(None, Some(far), air, 1.0, &Draws::new(stream.next_u64(), 0)).is_some_and(is_seen))
            .count()
    };
    let (foggy, dry) = (seen(&fog), seen(&clear()));
    assert!(dry > 2800 && foggy * 2 < dry, "{foggy} {dry}");
}

const MODES: [ReturnMode; 5] =
    [ReturnMode::Strongest, ReturnMode::Last, ReturnMode::First, ReturnMode::Dual, ReturnMode::Triple];

#[test]
fn each_mode_reports_its_echoes_of_those_that_are_detected() {
    let receiver = of_gain(1.0);
    let draws = Draws::new(0, 0);
    let matt = |reflectance| Material::matt(Semantic::Building, [0.5; 3], Pattern::Render, reflectance);
    let echo = |range_m, reflectance| first_echo(None, Some(surface(&matt(reflectance), range_m, 1.0, 0)), &draws);
    let of = |mode, reflectances: [f32; 4]| -> Vec<(u8, f64)> {
        let echoes: Vec<_> = [10.0, 15.0, 20.0, 25.0].into_iter().zip(reflectances).collect();
        let mut echoes = echoes.iter().filter(|e| e.1 > 0.0).map(|(range_m, reflectance)| echo(*range_m, *reflectance));
        let echoes = [(); 4].map(|()| echoes.next().flatten());
        let points = written(echoes, &clear(), mode, &receiver, &draws);
        points.iter().map(|(number, point)| (*number, point.range_m.round())).collect()
    };
    // Power falls with the square of the range: the second is the strongest, then the third, the fourth, the first.
    let all = [0.01, 0.8, 0.5, 0.4];
    let expected: [&[(u8, f64)]; 5] =
        [&[(2, 15.0)], &[(4, 25.0)], &[(1, 10.0)], &[(2, 15.0), (4, 25.0)], &[(2, 15.0), (3, 20.0), (4, 25.0)]];
    for (mode, expected) in MODES.into_iter().zip(expected) {
        assert_eq!(of(mode, all), expected, "{mode:?}");
    }
    // What is not detected has no number, and a lone echo is all that any mode reports.
    assert_eq!(of(ReturnMode::Dual, [0.8, 1e-4, 0.4, 1e-4]), [(1, 10.0), (2, 20.0)]);
    assert!(MODES.iter().all(|mode| of(*mode, [0.0, 0.8, 0.0, 0.0]) == [(1, 15.0)]));
    assert!(MODES.iter().all(|mode| of(*mode, [0.0, 1e-4, 1e-4, 0.0]).is_empty()));
}

#[test]
fn dual_is_the_strongest_and_the_last_behind_drops_and_flakes() {
    let wall = Material::matt(Semantic::Building, [0.5; 3], Pattern::Plain, 0.1);
    let receiver = of_gain(1.0);
    let snow = Air::new(&Weather::of_air(0.0, 0.0, 4.0, 0.0).expect("valid"), &receiver.receiver, 6.0);
    let mut stream = Stream::from_seed("last", 0);
    let (mut hidden, n) = (0, 20_000);
    for _ in 0..n {
        let draws = Draws::new(stream.next_u64(), 0);
        let echo = first_echo(None, Some(surface(&wall, 25.0, 0.9, 7)), &draws);
        let [strongest, last, first, dual, triple] =
            MODES.map(|mode| written([echo, None, None, None], &snow, mode, &receiver, &draws));
        let mut both = [strongest.clone(), last.clone()].concat();
        both.sort_by_key(|point| point.0);
        both.dedup();
        assert_eq!(dual, both);
        assert!(first.iter().chain(&dual).all(|point| triple.contains(point)) && triple.len() <= 3);
        // The last echo that is detected is the wall's, whatever stands before it.
        if strongest.iter().any(|(_, point)| point.actor_id == 0) {
            hidden += last.iter().filter(|(_, point)| (point.range_m - 25.0).abs() < 0.3).count();
        }
    }
    assert!((n / 200..n / 4).contains(&hidden), "{hidden}");
}

#[test]
fn what_the_air_returns_does_not_grow_with_what_stands_behind_it() {
    // In dense fog a plate at 40 m is a thousand times as bright as the bumper beside it.
    let fog = air_of("dense_fog");
    let receiver = of_gain(1.0);
    let mut stream = Stream::from_seed("ghosts", 0);
    let mut plate = Material::matt(Semantic::Car, [0.9; 3], Pattern::Plain, 0.9);
    plate.lidar.retro = true;
    let bumper = Material::matt(Semantic::Car, [0.9; 3], Pattern::Plain, 0.9);
    let (mut ghosts, mut of_plate) = ([0; 2], 0);
    for _ in 0..5000 {
        let draws = Draws::new(stream.next_u64(), 0);
        for (ghosts, material) in ghosts.iter_mut().zip([&plate, &bumper]) {
            let echo = first_echo(None, Some(surface(material, 40.0, 0.9, 7)), &draws);
            let points = written([echo, None, None, None], &fog, ReturnMode::Strongest, &receiver, &draws);
            *ghosts += points.iter().filter(|(_, point)| point.range_m < 35.0).count();
            of_plate += usize::from(std::ptr::eq(material, &plate) && points.iter().any(|(_, p)| p.actor_id == 7));
        }
    }
    assert!(ghosts[0] <= ghosts[1] && of_plate > 4000, "{ghosts:?} {of_plate}");
}

#[test]
fn a_target_of_10_percent_is_detected_half_of_the_time_at_the_detection_range() {
    for detection_range_m in [40.0, 220.0] {
        let mut receiver = of_gain(1.0);
        receiver.receiver.detection_range_m = detection_range_m;
        receiver.max_range_m = 1e3;
        let share = |reflectance, range_m| {
            let wall = Material::matt(Semantic::Building, [0.5; 3], Pattern::Render, reflectance);
            let mut stream = Stream::from_seed("sheet", 0);
            let is_detected = |_: &i32| {
                let draws = Draws::new(stream.next_u64(), 0);
                let echo = first_echo(None, Some(surface(&wall, range_m, 1.0, 0)), &draws);
                !written([echo, None, None, None], &clear(), ReturnMode::Strongest, &receiver, &draws).is_empty()
            };
            (0..4000).filter(is_detected).count() as f64 / 4000.0
        };
        assert!((share(0.1, detection_range_m) - 0.5).abs() < 0.03);
        // As data sheets have it: nine times in ten at five sixths of the range, and 80 % at 2.83 times the range.
        assert!((share(0.1, detection_range_m / 1.2) - 0.9).abs() < 0.02);
        assert!((share(0.8, detection_range_m * 8_f64.sqrt()) - 0.5).abs() < 0.03);
    }
}

#[test]
fn fog_ends_what_is_seen_where_a_chamber_s_did() {
    // Bijelic et al. (2018): below 40 m of visibility an HDL-64 sees no farther than 25 m, whatever it looks at.
    let seen_m = |visibility_m: f64, reflectance: f64| {
        let alpha = math::ln(20.0) / visibility_m;
        let air = Air::new(&Weather::of_air(alpha, 0.0, 0.0, 0.0).expect("valid"), &Receiver::default(), 20.0);
        let power = |r: f64| reflectance / (r * r) * air.transmittance(r);
        (0..).map(|k| 1.0 + 0.1 * f64::from(k)).find(|r| power(*r) < Receiver::default().threshold()).expect("some")
    };
    let at = |visibility_m| [0.05, 0.5, 0.9].map(|reflectance| seen_m(visibility_m, reflectance));
    assert!(at(40.0).iter().all(|m| (15.0..31.0).contains(m)), "{:?}", at(40.0));
    assert!((at(40.0).iter().sum::<f64>() / 3.0 - 25.0).abs() < 2.0, "{:?}", at(40.0));
    assert!(at(20.0).iter().all(|m| *m < 18.0) && at(100.0).iter().all(|m| *m > 25.0));
}
