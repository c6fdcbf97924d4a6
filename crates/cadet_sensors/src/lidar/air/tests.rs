use super::*;
use cadet_base::math::PI;

fn air(fog: f64, rain: f64, snow: f64) -> Air {
    Air::new(&Weather::of_air(fog, rain, snow, 0.0).expect("valid"), &Receiver::default())
}

fn key(k: u64) -> u64 {
    CounterRng::key(7, [k, 0, 0])
}

#[test]
fn clear_air_does_nothing_at_all() {
    for name in ["clear_noon", "cloudy_sunset", "dusk"] {
        let air = Air::new(&Weather::preset(name).expect("exists"), &Receiver::default());
        for (range_m, power) in [(79.0, 1e-9), (0.1, 1.0), (f64::INFINITY, 0.0)] {
            assert_eq!(air.meet(range_m, power, 3), Meeting { transmittance: 1.0, air_return: None });
        }
        assert_eq!(air.ground(Semantic::Road, 0.2, 0.1).to_bits(), 0.2_f64.to_bits());
    }
}

#[test]
fn fog_moves_what_its_own_echo_outshines() {
    let alpha = 0.06;
    let air = air(alpha, 0.0, 0.0);
    let half = math::ln(2.0) / (2.0 * alpha);
    assert!((air.meet(half, 1e-3, 0).transmittance - 0.5).abs() < 1e-12);
    // i_soft > i', with max I = 2.3e-9 s at 0.06 per meter (see fog.rs for the table's own test).
    let peak = (0..500).map(|k| response(alpha, 0.9 + 0.01 * f64::from(k))).fold(0.0, f64::max);
    let beta_over_beta0 = 0.046 * alpha / math::ln(20.0) / (0.596e-6 / PI);
    let mut moved = 0;
    for k in 0..1600 {
        let range_m = 2.0 + 0.05 * k as f64;
        // A point's own intensity cancels: no power is as good as much.
        let meeting = air.meet(range_m, if k % 2 == 0 { 0.0 } else { 0.01 }, key(k));
        let (hard, soft) = (math::exp(-2.0 * alpha * range_m), range_m * range_m * beta_over_beta0 * peak);
        if (hard / soft - 1.0).abs() > 0.01 {
            assert_eq!(meeting.air_return.is_some(), soft > hard, "{range_m}");
        }
        if let Some(air_return) = meeting.air_return {
            moved += 1;
            assert!(air_return.from == Scatterer::Fog && (2.0..8.0).contains(&air_return.range_m), "{air_return:?}");
        }
    }
    assert!(moved > 500, "{moved}");
    assert_eq!(air.meet(f64::INFINITY, 0.0, 1).air_return, None, "the sky was silent and stays so");
}

/// The paper's I(R), by the midpoint rule in time.
fn response(alpha: f64, range_m: f64) -> f64 {
    let (c, tau, n) = (299_792_458.0, 5e-9, 2000);
    let dt = 2.0 * tau / f64::from(n);
    (0..n)
        .map(|i| {
            let t = (f64::from(i) + 0.5) * dt;
            let r = range_m - c * t / 2.0;
            if r <= 0.9 {
                return 0.0;
            }
            let s = math::sin(PI * t / (2.0 * tau));
            s * s * math::exp(-2.0 * alpha * r) * ((r - 0.9) / 0.1).min(1.0) / (r * r) * dt
        })
        .sum()
}

#[test]
fn beta_2_20_has_its_moments() {
    let mut rng = CounterRng::new(1);
    let n = 50_000;
    let all: Vec<f64> = (0..n).map(|_| beta_2_20(&mut rng)).collect();
    let mean = all.iter().sum::<f64>() / f64::from(n);
    let var = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / f64::from(n);
    assert!((mean - 2.0 / 22.0).abs() < 1e-3, "{mean}");
    assert!((var / (40.0 / (22.0 * 22.0 * 23.0)) - 1.0).abs() < 0.04, "{var}");
}

/// Bright particles counted by throwing every particle of the cone, large and small, as LISA does.
#[test]
fn bright_particles_are_as_many_as_in_a_cone_full_of_them() {
    let usual = Receiver::default();
    let [rain, snow] = [(25.0, 0.0), (0.0, 2.0)].map(|(r, s)| Weather::of_air(0.0, r, s, 0.0).expect("valid"));
    let water = (0.328_f64 / 2.328) * (0.328 / 2.328);
    for (weather, rho, receiver) in [
        (rain.clone(), water, usual),
        // The receiver says how wide the cone is and how weak an echo may be.
        (rain, water, Receiver { divergence_rad: 4e-3, threshold: 8e-5, ..usual }),
        (snow, 0.3, usual),
    ] {
        let (divergence, least) = (receiver.divergence_rad, 0.6 * receiver.threshold);
        let alpha = weather.extinction_per_m();
        let sizes = weather.drops().or(weather.flakes()).expect("something falls");
        let target_m = 12.0;
        let mut stream = cadet_base::rng::Stream::from_seed("cone", 0);
        let volume = PI / 12.0 * divergence * divergence * target_m * target_m * target_m;
        let beams = 30_000;
        let (mut count, mut strongest_count, mut shares, mut ranges) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..beams {
            let mut best = 0.0_f64;
            for _ in 0..stream.poisson(sizes.number_per_m3 * volume) {
                let r = target_m * math::cbrt(stream.unit());
                let d = -math::ln(1.0 - stream.unit()) / sizes.slope_per_m;
                let share = (d / (divergence * r) * (d / (divergence * r))).min(1.0);
                let xi = ((r - 0.9) / 0.1).clamp(0.0, 1.0);
                let power = rho * math::exp(-2.0 * alpha * r) * xi * share / (r * r);
                if power > least {
                    (count, shares, ranges) = (count + 1.0, shares + share, ranges + r);
                    best = best.max(power);
                }
            }
            strongest_count += f64::from(u8::from(best > 0.0));
        }
        let air = Air::new(&weather, &receiver);
        let particles = air.rain.as_ref().or(air.snow.as_ref()).expect("something falls");
        let (mut ours, mut our_beams, mut our_shares, mut our_ranges) = (0.0, 0.0, 0.0, 0.0);
        for k in 0..beams {
            let before = ours;
            particles.draw(target_m, &mut CounterRng::new(key(k)), |p| {
                (ours, our_shares, our_ranges) = (ours + 1.0, our_shares + p.share, our_ranges + p.range_m);
                assert!(p.power >= least * 0.999 && p.range_m < target_m, "{p:?}");
            });
            our_beams += f64::from(u8::from(ours > before));
        }
        let near = |ours: f64, theirs: f64, what: &str| {
            // Both are counts: four standard deviations of their difference.
            assert!((ours - theirs).abs() < 4.0 * (ours + theirs).sqrt(), "{what}: {ours} {theirs} of {beams}");
        };
        assert!(count > 500.0, "{count}");
        near(ours, count, "bright particles");
        near(our_beams, strongest_count, "beams with one");
        assert!((our_ranges / ours - ranges / count).abs() < 0.15, "{} {}", our_ranges / ours, ranges / count);
        assert!((our_shares / ours - shares / count).abs() < 0.01, "{} {}", our_shares / ours, shares / count);
    }
}

#[test]
fn flakes_cover_targets_but_dim_them_by_beer_and_lambert_on_average() {
    let weather = Weather::of_air(0.0, 0.0, 2.0, 0.0).expect("valid");
    let (air, alpha) = (Air::new(&weather, &Receiver::default()), weather.extinction_per_m());
    for range_m in [3.0, 12.0, 40.0] {
        let n = 60_000;
        let left: Vec<f64> = (0..n).map(|k| air.meet(range_m, 1.0, key(k)).transmittance).collect();
        let mean = left.iter().sum::<f64>() / n as f64;
        let var = left.iter().map(|t| (t - mean) * (t - mean)).sum::<f64>() / n as f64;
        assert!((mean - math::exp(-2.0 * alpha * range_m)).abs() < 5.0 * (var / n as f64).sqrt(), "{range_m}: {mean}");
        assert!(left.iter().all(|t| (0.0..=1.0).contains(t)) && var > 1e-6, "{var}");
    }
}

#[test]
fn more_weather_leaves_less() {
    // Share of targets at 12 m, as strong as gray paint, that still return; and what is left of them.
    let kept = |fog, rain, snow, range_m: f64| {
        let air = air(fog, rain, snow);
        let all: Vec<Meeting> = (0..8000).map(|k| air.meet(range_m, 0.1 / (range_m * range_m), key(k))).collect();
        let kept = all.iter().filter(|m| m.air_return.is_none()).count() as f64 / all.len() as f64;
        (kept, all.iter().map(|m| m.transmittance).sum::<f64>() / all.len() as f64)
    };
    for rates in [[0.5, 4.0], [4.0, 30.0], [30.0, 150.0]] {
        let [light, heavy] = rates.map(|r| kept(0.0, r, 0.0, 12.0));
        assert!(heavy.0 < light.0 && heavy.1 < light.1, "rain {rates:?}: {light:?} {heavy:?}");
    }
    for rates in [[0.2, 1.0], [1.0, 3.0], [3.0, 10.0]] {
        let [light, heavy] = rates.map(|r| kept(0.0, 0.0, r, 12.0));
        assert!(heavy.0 < light.0 && heavy.1 < light.1, "snow {rates:?}: {light:?} {heavy:?}");
    }
    for range_m in [10.0, 30.0, 60.0] {
        let alphas = [0.001, 0.01, 0.05, 0.2].map(|a| kept(a, 0.0, 0.0, range_m));
        assert!(alphas.windows(2).all(|w| w[1].1 < w[0].1 && w[1].0 <= w[0].0), "{alphas:?}");
        assert!(kept(0.05, 0.0, 0.0, range_m + 1.0).1 < kept(0.05, 0.0, 0.0, range_m).1);
    }
}

#[test]
fn snow_whitens_and_water_darkens_the_ground() {
    let wet = Air::new(&Weather::preset("hard_rain_noon").expect("exists"), &Receiver::default());
    let white = Air::new(&Weather::preset("snow").expect("exists"), &Receiver::default());
    assert!(wet.ground(Semantic::Road, 0.2, 0.1) < 0.05);
    assert_eq!(wet.ground(Semantic::Terrain, 0.2, 0.1), 0.2);
    assert!(white.ground(Semantic::Road, 0.1, 0.5) > 0.4 && white.ground(Semantic::Terrain, 0.1, 0.5) > 0.4);
}
