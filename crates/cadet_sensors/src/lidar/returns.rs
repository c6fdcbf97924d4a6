//! From the surface that returns a beam to what reaches the receiver: what the air leaves of it, and returns itself.

use super::air::{Air, Scatterer, Sprayed};
use super::draws::Draws;
use super::echo::Echo;
use super::return_mode::ReturnMode;
use super::ring_receiver::RingReceiver;
use cadet_base::material::Semantic;

/// What reaches the receiver of one beam: a target's echo, or that of fog, a drop or a flake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arrival {
    pub range_m: f64,
    /// Reflectance / range^2.
    pub power: f64,
    /// The power by which it is detected: a retroreflector's is a thousand times what it would be of a diffuse surface.
    pub detected_power: f64,
    /// True if it overflows the receiver.
    pub saturates: bool,
    /// What the slant of a surface leaves of its peak.
    pub peak_share: f64,
    /// Standard deviation of its reading.
    pub reading_noise: f64,
    pub actor_id: i32,
    /// [`Semantic::Sky`] for fog, drops and flakes.
    pub semantic: Semantic,
}

/// Standard deviation of the reading of a drop, a flake or fog.
const AIR_NOISE: f64 = 0.05;
/// What reaches the receiver of an echo, of the air, and of the spray before it; None for nothing.
#[inline]
pub(super) fn arrival(
    echo: Option<Echo>,
    (air, spray): (&Air, &Sprayed),
    mode: ReturnMode,
    receiver: &RingReceiver,
    draws: &Draws,
) -> Option<Arrival> {
    if air.is_clear() {
        return echo.map(|e| of_target(&e, clear_power(&e, air), receiver));
    }
    let (range_m, clear_power) =
        echo.map_or((f64::INFINITY, 0.0), |e| (e.range_m, clear_power(&e, air) * spray.transmittance));
    let bright = echo.map_or(1.0, |e| e.brightness());
    let meeting = air.meet(range_m, clear_power * bright, draws.air_key);
    let power = clear_power * meeting.transmittance;
    let share = echo.map_or(1.0, |e| receiver.detected_share(&e));
    let detected = |power: f64| receiver.receiver.detects(power * share, draws.detection_chance);
    // The last echo that is detected is the target's, whatever stands before it.
    let air_return = spray.or_stronger(meeting.air_return, power * bright, air);
    if let Some(air_return) = air_return.filter(|_| mode == ReturnMode::Strongest || !detected(power)) {
        let power = air_return.reflectance / (air_return.range_m * air_return.range_m);
        return Some(Arrival {
            range_m: air_return.range_m,
            power,
            // Fog returns in the place of a target, which must have been detected without it; a drop is detected by itself.
            detected_power: if air_return.from == Scatterer::Fog { clear_power * share } else { power },
            saturates: false,
            peak_share: 1.0,
            reading_noise: AIR_NOISE,
            actor_id: 0,
            semantic: Semantic::Sky,
        });
    }
    echo.map(|e| of_target(&e, power, receiver))
}

fn of_target(echo: &Echo, power: f64, receiver: &RingReceiver) -> Arrival {
    Arrival {
        range_m: echo.range_m,
        power,
        detected_power: power * receiver.detected_share(echo),
        saturates: echo.retro,
        peak_share: receiver.peak_share(echo),
        reading_noise: echo.reading_noise,
        actor_id: echo.actor_id,
        semantic: echo.semantic,
    }
}

/// Power of an echo at the receiver were there nothing in the air, in units of reflectance / range^2.
#[inline]
fn clear_power(echo: &Echo, air: &Air) -> f64 {
    let is_ground = echo.semantic.is_ground();
    let reflectance =
        if is_ground { air.ground(echo.semantic, echo.reflectance, echo.cos_incidence) } else { echo.reflectance };
    reflectance / (echo.range_m * echo.range_m)
}

/// Power of an echo at the receiver, in units of reflectance / range^2, in the mean of what the air leaves of it.
pub(super) fn echo_power(echo: &Echo, air: &Air) -> f64 {
    clear_power(echo, air) * air.transmittance(echo.range_m)
}

/// Whether the receiver detects an echo; `detection_chance` is uniform in [0, 1).
pub(super) fn is_echo_detected(echo: &Echo, air: &Air, receiver: &RingReceiver, detection_chance: f64) -> bool {
    receiver.receiver.detects(echo_power(echo, air) * receiver.detected_share(echo), detection_chance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lidar::echo::{HitSurface, first_echo};
    use crate::lidar::echo_batch::EchoBatch;
    use crate::lidar::{LidarSpec, Receiver, Scan};
    use crate::sense::LaserRing;
    use crate::weather::Weather;
    use cadet_base::material::{Material, Pattern};
    use cadet_base::rng::Stream;

    fn surface(material: &Material, range_m: f64, cos_incidence: f64, actor_id: i32) -> HitSurface<'_> {
        HitSurface { range_m, cos_incidence, material, texture_factor: 1.0, snow_cover: 0.0, actor_id }
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

    /// The point that a receiver of that gain writes of what arrives from one beam.
    fn written(arrival: Option<Arrival>, laser_gain: f64, draws: &Draws) -> Option<Return> {
        let mut batch = EchoBatch::new();
        batch.push(&arrival?, draws, 0, [[0.0; 3], [1.0, 0.0, 0.0]]);
        let mut out = Scan::default();
        batch.receive(&of_gain(laser_gain), 0, &mut out);
        let range_m = *out.range_m.first()?;
        Some(Return { range_m, intensity: f64::from(out.points_velo[0][3]), actor_id: out.actor_id[0] })
    }

    fn receive(
        transparent: Option<HitSurface<'_>>,
        opaque: Option<HitSurface<'_>>,
        air: &Air,
        laser_gain: f64,
        draws: &Draws,
    ) -> Option<Return> {
        let echo = first_echo(transparent, opaque, draws);
        written(
            arrival(echo, (air, &Sprayed::NOT), ReturnMode::Strongest, &of_gain(laser_gain), draws),
            laser_gain,
            draws,
        )
    }

    fn clear() -> Air {
        air_of("clear_noon")
    }

    fn air_of(weather: &str) -> Air {
        Air::new(&Weather::preset(weather).expect("exists"), &Receiver::default())
    }

    /// Share of beams that return, share of zeros among them, mean intensity, over all lasers of KITTI's sensor.
    fn statistics(transparent: Option<HitSurface<'_>>, opaque: Option<HitSurface<'_>>, air: &Air) -> (f64, f64, f64) {
        let mut stream = Stream::from_seed("returns", 1);
        let n = 20_000;
        let lasers = LidarSpec::hdl64e_kitti().laser_receivers;
        let all: Vec<Return> = (0..n)
            .filter_map(|i| receive(transparent, opaque, air, lasers[i % lasers.len()].gain, &Draws::new(&mut stream)))
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
            let draws = Draws::new(&mut stream);
            match receive(Some(surface(&glass, 8.0, 0.7, 3)), Some(surface(&seat, 9.0, 0.9, 3)), &clear(), 1.0, &draws)
            {
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
            let returned = receive(Some(of_snow(&glass, 8.0, 0.3)), seat, &clear(), 1.0, &Draws::new(&mut stream));
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
        let (foggy, dry) = (statistics(None, Some(far), &fog).0, statistics(None, Some(far), &clear()).0);
        assert!(dry > 0.7 && foggy < 0.5 * dry, "{foggy} {dry}");
    }

    #[test]
    fn drops_and_flakes_hide_targets_from_the_strongest_return_but_not_from_the_last() {
        let wall = Material::matt(Semantic::Building, [0.5; 3], Pattern::Plain, 0.3);
        let target = Some(surface(&wall, 12.0, 0.9, 7));
        let receiver = of_gain(1.0);
        let snow = Air::new(&Weather::of_air(0.0, 0.0, 4.0, 0.0).expect("valid"), &receiver.receiver);
        let mut stream = Stream::from_seed("last", 0);
        let (mut hidden, n) = (0, 20_000);
        for _ in 0..n {
            let draws = Draws::new(&mut stream);
            let by = |mode| {
                written(
                    arrival(first_echo(None, target, &draws), (&snow, &Sprayed::NOT), mode, &receiver, &draws),
                    1.0,
                    &draws,
                )
            };
            let (strongest, last) = (by(ReturnMode::Strongest), by(ReturnMode::Last));
            if strongest.is_some_and(|r| r.actor_id == 0) {
                hidden += 1;
                let last = last.expect("the flake or the wall");
                assert!(last.actor_id == 0 || (last.range_m - 12.0).abs() < 0.3);
                hidden -= i32::from(last.actor_id == 0);
            } else {
                assert_eq!(strongest, last);
            }
        }
        assert!((n / 50..n / 4).contains(&hidden), "{hidden}");
    }
}
