use super::*;
use cadet_base::math::PI;

/// As optics see it that lose nothing of what is near.
fn air(fog: f64, rain: f64, snow: f64) -> Air {
    Air::new(&Weather::of_air(fog, rain, snow, 0.0).expect("valid"), &Receiver::default(), 0.0)
}

fn key(k: u64) -> u64 {
    CounterRng::key(7, [k, 0, 0])
}

#[test]
fn clear_air_does_nothing_at_all() {
    for name in ["clear_noon", "cloudy_sunset", "dusk"] {
        let air = Air::new(&Weather::preset(name).expect("exists"), &Receiver::default(), 6.0);
        for range_m in [79.0, 0.1, f64::INFINITY] {
            assert_eq!(air.meet(range_m, 3), Meeting { transmittance: 1.0, echoes: [None; 2] });
        }
        assert_eq!(air.ground(Semantic::Road, 0.2, 0.1).to_bits(), 0.2_f64.to_bits());
    }
}

#[test]
fn fog_halves_an_echo_where_its_extinction_says() {
    let half = math::ln(2.0) / (2.0 * 0.06);
    assert!((air(0.06, 0.0, 0.0).meet(half, 0).transmittance - 0.5).abs() < 1e-12);
    // Thin fog returns less than what any receiver detects, and still dims.
    let thin = air(1e-6, 0.0, 0.0);
    assert!(thin.fog.is_none() && thin.meet(50.0, 0).transmittance < 1.0);
}

/// Bright particles counted by throwing every particle of the cone, large and small, as LISA does.
#[test]
fn bright_particles_are_as_many_as_in_a_cone_full_of_them() {
    let usual = Receiver::default();
    let [rain, snow] = [(25.0, 0.0), (0.0, 2.0)].map(|(r, s)| Weather::of_air(0.0, r, s, 0.0).expect("valid"));
    let water = (0.328_f64 / 2.328) * (0.328 / 2.328);
    for (weather, rho, receiver, focus_m) in [
        (rain.clone(), water, usual, 0.0),
        // The receiver says how wide the cone is, how weak an echo may be, and what its optics lose.
        (rain, water, Receiver { divergence_rad: 4e-3, detection_range_m: 35.0, ..usual }, 0.0),
        (snow, 0.3, usual, 6.0),
    ] {
        let (divergence, least) = (receiver.divergence_rad, 0.6 * receiver.threshold());
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
                let of_focus = r / focus_m;
                let near = if r < focus_m { of_focus * of_focus * of_focus } else { 1.0 };
                let xi = if r < 0.9 { 0.0 } else { near };
                let power = rho * math::exp(-2.0 * alpha * r) * xi * share / (r * r);
                if power > least {
                    (count, shares, ranges) = (count + 1.0, shares + share, ranges + r);
                    best = best.max(power);
                }
            }
            strongest_count += f64::from(u8::from(best > 0.0));
        }
        let air = Air::new(&weather, &receiver, focus_m);
        let particles = air.rain.as_ref().or(air.snow.as_ref()).expect("something falls");
        let (mut ours, mut our_beams, mut our_shares, mut our_ranges) = (0.0, 0.0, 0.0, 0.0);
        for k in 0..beams {
            let before = ours;
            particles.draw(target_m, &mut CounterRng::new(key(k)), |p| {
                (ours, our_shares, our_ranges) = (ours + 1.0, our_shares + p.share, our_ranges + p.echo.range_m);
                assert!(p.echo.power >= least * 0.999 && p.echo.range_m < target_m, "{p:?}");
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
    let (air, alpha) = (Air::new(&weather, &Receiver::default(), 6.0), weather.extinction_per_m());
    for range_m in [3.0, 12.0, 40.0] {
        let n = 60_000;
        let left: Vec<f64> = (0..n).map(|k| air.meet(range_m, key(k)).transmittance).collect();
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
        let all: Vec<Meeting> = (0..8000).map(|k| air.meet(range_m, key(k))).collect();
        let is_kept = |m: &&Meeting| {
            let power = 0.1 / (range_m * range_m) * m.transmittance;
            m.echoes.iter().flatten().all(|echo| echo.power < power)
        };
        let kept = all.iter().filter(is_kept).count() as f64 / all.len() as f64;
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
    let wet = Air::new(&Weather::preset("hard_rain_noon").expect("exists"), &Receiver::default(), 6.0);
    let white = Air::new(&Weather::preset("snow").expect("exists"), &Receiver::default(), 6.0);
    assert!(wet.ground(Semantic::Road, 0.2, 0.1) < 0.05);
    assert_eq!(wet.ground(Semantic::Terrain, 0.2, 0.1), 0.2);
    assert!(white.ground(Semantic::Road, 0.1, 0.5) > 0.4 && white.ground(Semantic::Terrain, 0.1, 0.5) > 0.4);
}
