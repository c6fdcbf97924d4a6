//! Weather on a scan that was recorded in clear air: anyone's KITTI file, or one of ours.

use super::Air;
use super::particles::CLOSED_M;
use crate::lidar::{LaserReceiver, Receiver};
use crate::weather::Weather;
use cadet_base::error::{Error, Result, finite};
use cadet_base::math;
use cadet_base::rng::{CounterRng, nearly_normal};

/// What became of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i8)]
pub enum Fate {
    /// Still there: dimmer, and a little noisier in range.
    Kept = 0,
    /// Too weak to be detected.
    Lost = 1,
    /// Answered by fog, a drop or a flake in front of it.
    Scattered = 2,
}

/// A recorded scan after weather.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Weathered {
    /// The points that are left, in the order of the scan.
    pub points_velo: Vec<[f32; 4]>,
    /// What became of each point of the scan, the lost ones too.
    pub fate: Vec<Fate>,
}

/// Points that lie this near to a level ground plane are ground; farther away by a share of the range more.
const GROUND_TOLERANCE_M: f64 = 0.2;
const GROUND_TOLERANCE_SHARE: f64 = 0.01;

/// Puts the air of `weather` between a sensor with this receiver in the frame's origin and the points (x, y, z in
/// meters, intensity 0..=1) that it saw in clear air, and wets what lies within 0.2 m plus 1 % of the range of the
/// plane `z = -sensor_height_m`.
///
/// A point's reflectance is taken to be its intensity, as in LISA. It was detected, so it had the least power that is detected
/// or more; where its intensity says less, how much more is drawn (Pareto, exponent 3). Points that fall below the threshold
/// are lost. Ranges get what the receiver's noise of the weaker echo has more than that of the echo in clear air.
///
/// # Determinism
/// A point's fate depends on itself, on the weather and on `seed`, not on its neighbors: a scan may be cut in pieces.
///
/// # Errors
/// [`Error::NotFinite`] or [`Error::OutOfRange`] for bad weather, coordinates or intensities.
pub fn weather_recorded(
    points_velo: &[[f32; 4]],
    weather: &Weather,
    receiver: &Receiver,
    sensor_height_m: f64,
    seed: u64,
) -> Result<Weathered> {
    weather.check()?;
    receiver.check()?;
    let _ = finite("sensor_height_m", sensor_height_m)?;
    let air = Air::new(weather, receiver, LaserReceiver::default().focus_m);
    let mut out =
        Weathered { points_velo: Vec::with_capacity(points_velo.len()), fate: Vec::with_capacity(points_velo.len()) };
    for point in points_velo {
        check(point)?;
        let (fate, left) = weather_point(*point, &air, receiver, sensor_height_m, seed);
        out.fate.push(fate);
        if fate != Fate::Lost {
            out.points_velo.push(left);
        }
    }
    Ok(out)
}

fn check(point: &[f32; 4]) -> Result<()> {
    for value in point {
        let _ = finite("a number of points_velo", f64::from(*value))?;
    }
    if !(0.0..=1.0).contains(&point[3]) {
        let value = point[3].to_string();
        return Err(Error::OutOfRange { what: "an intensity of points_velo", value, expected: "0 to 1".to_owned() });
    }
    Ok(())
}

fn weather_point(point: [f32; 4], air: &Air, receiver: &Receiver, sensor_height_m: f64, seed: u64) -> (Fate, [f32; 4]) {
    let threshold = receiver.threshold();
    let [x, y, z, intensity] = point.map(f64::from);
    let range_m = (x * x + y * y + z * z).sqrt();
    if range_m < CLOSED_M {
        return (Fate::Kept, point);
    }
    let is_ground = (z + sensor_height_m).abs() < GROUND_TOLERANCE_M + GROUND_TOLERANCE_SHARE * range_m;
    let wet = if is_ground { air.wet_share(intensity, -z / range_m) } else { 1.0 };
    let meeting = air.meet(range_m, CounterRng::key(seed, beam_names(receiver.divergence_rad, x, y, z)));
    let share = meeting.transmittance * wet;
    let moved = |to_m: f64, intensity: f64| {
        let scale = to_m / range_m;
        [(x * scale) as f32, (y * scale) as f32, (z * scale) as f32, intensity.min(1.0) as f32]
    };
    let power = (intensity / (range_m * range_m)).max(threshold);
    let in_air = meeting.echoes.into_iter().flatten().max_by(|a, b| a.power.total_cmp(&b.power));
    if let Some(echo) = in_air.filter(|echo| echo.power > (power * share).max(threshold)) {
        return (Fate::Scattered, moved(echo.range_m, echo.power * echo.range_m * echo.range_m));
    }
    if share >= 1.0 {
        return (Fate::Kept, point);
    }
    let mut rng = CounterRng::new(CounterRng::key(seed, point_names(point)));
    let margin = 1.0 / math::cbrt(1.0 - rng.unit());
    let before = (intensity / (range_m * range_m)).max(threshold * margin);
    if before * share < threshold {
        return (Fate::Lost, point);
    }
    let [was_m, is_m] = [before, before * share].map(|power| receiver.noise_m(power));
    let noise_m = (is_m * is_m - was_m * was_m).max(0.0).sqrt() * nearly_normal(rng.next_u64());
    (Fate::Kept, moved((range_m + noise_m).max(0.0), intensity * share))
}

/// The point by its bits.
fn point_names(point: [f32; 4]) -> [u64; 3] {
    let [x, y, z, intensity] = point.map(|v| u64::from((v + 0.0).to_bits()));
    [x | y << 32, z, intensity]
}

/// The cell of directions that a beam fills: points of one beam meet the same drops.
fn beam_names(cell_rad: f64, x: f64, y: f64, z: f64) -> [u64; 3] {
    let flat_m = math::hypot(x, y).max(1e-9);
    // Grows all around, about as the azimuth does: atan2 would cost more than the rest.
    let along = if x.abs() + y.abs() > 0.0 { y / (x.abs() + y.abs()) } else { 0.0 };
    let around = if x >= 0.0 { along } else { 2.0 - along };
    let up = (z / flat_m).clamp(-1e6, 1e6);
    [((around + 2.0) / cell_rad) as u64, (up / cell_rad).floor() as i64 as u64, 0x0BEA]
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::rng::Stream;

    fn cloud(n: usize, name: &str) -> Vec<[f32; 4]> {
        let mut s = Stream::from_seed(name, 0);
        (0..n)
            .map(|_| {
                let (r, turn, up) = (s.range(2.0, 79.0), s.range(0.0, math::TAU), s.range(-0.4, 0.03));
                let zero = s.chance(0.12);
                let intensity = if zero { 0.0 } else { s.range(0.01, 0.6) };
                let (x, y) = (r * math::cos(up) * math::cos(turn), r * math::cos(up) * math::sin(turn));
                [x as f32, y as f32, (r * math::sin(up)) as f32, intensity as f32]
            })
            .collect()
    }

    fn run(points: &[[f32; 4]], air: [f64; 4], seed: u64) -> Weathered {
        let weather = Weather::of_air(air[0], air[1], air[2], air[3]).expect("valid");
        weather_recorded(points, &weather, &Receiver::default(), 1.73, seed).expect("valid")
    }

    const WEATHERS: [[f64; 4]; 5] = [
        [0.06, 0.0, 0.0, 0.0],
        [0.0, 25.0, 0.0, 0.0],
        [0.0, 0.0, 2.0, 0.0],
        [0.0, 5.0, 0.0, 0.8],
        [0.02, 10.0, 1.0, 0.3],
    ];

    #[test]
    fn no_weather_changes_no_bit() {
        let mut points = cloud(5000, "clear");
        points.push([-0.0, 0.0, -0.0, -0.0]);
        points.push([1e30, -3.0, 2.0, 0.5]);
        let got = run(&points, [0.0; 4], 9);
        let bits = |p: &[[f32; 4]]| p.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&got.points_velo), bits(&points));
        assert!(got.fate.iter().all(|f| *f == Fate::Kept));
    }

    #[test]
    fn points_stay_on_their_rays_and_answers_lie_before_them() {
        let points = cloud(20_000, "rays");
        for air in WEATHERS {
            let got = run(&points, air, 1);
            assert_eq!(got.fate.len(), points.len());
            let mut left = got.points_velo.iter();
            for (point, fate) in points.iter().zip(&got.fate).filter(|(_, fate)| **fate != Fate::Lost) {
                let after = left.next().expect("one row a point that is left");
                let [[x, y, z, i], [u, v, w, j]] = [point, after].map(|p| p.map(f64::from));
                let (before_m, after_m) = ((x * x + y * y + z * z).sqrt(), (u * u + v * v + w * w).sqrt());
                let cos = (x * u + y * v + z * w) / (before_m * after_m);
                assert!(cos > 1.0 - 1e-9, "{point:?} {after:?}");
                assert!((0.0..=1.0).contains(&j), "{j}");
                match fate {
                    Fate::Scattered => assert!(after_m < before_m * (1.0 + 1e-6) && after_m > 0.89),
                    _ => assert!((after_m - before_m).abs() < 0.25 && j <= i, "{before_m} {after_m} {i} {j}"),
                }
            }
            assert!(left.next().is_none());
        }
    }

    #[test]
    fn a_scan_may_be_cut_in_pieces_and_seeds_differ() {
        let points = cloud(9000, "pieces");
        for air in WEATHERS {
            let whole = run(&points, air, 4);
            let mut pieces = Weathered::default();
            for piece in points.chunks(1234) {
                let got = run(piece, air, 4);
                pieces.points_velo.extend(got.points_velo);
                pieces.fate.extend(got.fate);
            }
            assert_eq!(whole, pieces);
            assert_ne!(whole, run(&points, air, 5), "{air:?}");
        }
    }

    #[test]
    fn fog_dims_by_beer_and_lambert_and_hides_what_is_far() {
        let points = cloud(4000, "fog");
        let got = run(&points, [0.03, 0.0, 0.0, 0.0], 0);
        let mut left = got.points_velo.iter();
        let (mut hidden, mut far) = (0, 0);
        for (before, fate) in points.iter().zip(&got.fate) {
            let [x, y, z, i] = before.map(f64::from);
            let range_m = (x * x + y * y + z * z).sqrt();
            let after = if *fate == Fate::Lost { None } else { left.next() };
            if *fate == Fate::Kept {
                let expected = i * math::exp(-0.06 * range_m);
                let got = f64::from(after.expect("kept")[3]);
                assert!((got - expected).abs() < 1e-7, "{expected} {got}");
            }
            // Of a fifth of white, exp(-0.06 * 60) / 60^2 is a tenth of what is detected.
            if range_m > 60.0 && i < 0.2 {
                (far, hidden) = (far + 1, hidden + usize::from(*fate != Fate::Kept));
            }
        }
        assert!(far > 100 && hidden * 10 > far * 9, "{hidden} of {far}");
    }

    #[test]
    fn heavier_rain_and_snow_lose_and_scatter_more() {
        let points = cloud(20_000, "rates");
        let kept = |air| run(&points, air, 2).fate.iter().filter(|f| **f == Fate::Kept).count();
        let rain = [0.0, 1e-6, 1.0, 10.0, 50.0, 200.0].map(|rate| kept([0.0, rate, 0.0, 0.0]));
        let snow = [0.0, 1e-9, 0.5, 2.0, 10.0].map(|rate| kept([0.0, 0.0, rate, 0.0]));
        let wet = [0.0, 0.3, 1.0].map(|wetness| kept([0.0, 0.0, 0.0, wetness]));
        assert!(rain.windows(2).all(|w| w[1] <= w[0]) && 4 * rain[5] < 3 * rain[0], "{rain:?}");
        assert!(snow.windows(2).all(|w| w[1] <= w[0]) && snow[4] < snow[0] / 2, "{snow:?}");
        assert!(wet.windows(2).all(|w| w[1] <= w[0]), "{wet:?}");
        // A little weather does little: no cliff beside clear air.
        assert!(rain[1] > rain[0] - 20 && snow[1] > snow[0] - 20, "{rain:?} {snow:?}");
    }

    #[test]
    fn bad_points_are_refused() {
        let clear = Weather::of_air(0.0, 1.0, 0.0, 0.0).expect("valid");
        let text =
            |p: [f32; 4]| weather_recorded(&[p], &clear, &Receiver::default(), 1.73, 0).expect_err("bad").to_string();
        assert!(text([f32::NAN, 0.0, 0.0, 0.0]).contains("points_velo is not finite: NaN"));
        assert!(text([1.0, 0.0, 0.0, 37.0]).contains("an intensity of points_velo is 37, expected 0 to 1"));
        assert_eq!(weather_recorded(&[], &clear, &Receiver::default(), 1.73, 0).expect("valid"), Weathered::default());
        let points = [[3e38, 3e38, 3e38, 0.5], [0.0; 4]];
        let far = weather_recorded(&points, &clear, &Receiver::default(), 1.73, 0).expect("valid");
        assert!(far.points_velo.iter().flatten().all(|v| v.is_finite()));
    }
}
