//! How a camera makes values of light: exposure, noise, white balance, and the curve of its response.

use std::sync::Arc;

use macro_rules_attribute::apply;

use cadet_base::error::{Error, Result, finite};
use cadet_base::math;

/// The largest value of an image.
pub(crate) const WHITE_VALUE: f32 = 255.0;
/// The camera's gains for R, G, B, beside the exposure: with them lit gray and the mean color are KITTI's.
pub(crate) const WHITE_BALANCE: [f32; 3] = [0.93, 1.0, 1.14];
/// Stops by which an exposure may be corrected.
pub const MOST_EXPOSURE_EV: f64 = 8.0;
/// The most that the noise's standard deviation is multiplied by.
pub const MOST_NOISE: f64 = 16.0;
/// Factors of a white balance.
pub const WHITE_BALANCE_FACTORS: std::ops::RangeInclusive<f64> = 0.125..=8.0;
/// Steps of light from black to white, each with its value.
const RESPONSE_STEPS: usize = 4096;
/// The points that a curve may have.
pub const CURVE_POINTS: std::ops::RangeInclusive<usize> = 2..=1024;
/// sRGB (IEC 61966-2-1): below this light values are proportional to it, above a power of it.
const SRGB_LINEAR_BELOW: f64 = 0.003_130_8;
/// 2^23: added to a number it leaves the nearest integer in the lowest bits.
const ROUNDER: f32 = 8_388_608.0;

/// What users may change of a camera whose images are by default those of KITTI's cameras.
#[derive(Debug, Clone, PartialEq)]
pub struct Development {
    /// Factor of the light against what the meter gives.
    pub gain: f32,
    /// Factor of the noise's standard deviation.
    pub noise: f32,
    /// Factors of R, G, and B beside the camera's own white balance.
    pub white_balance: [f32; 3],
    /// From light to values.
    pub response: Response,
}

impl Default for Development {
    fn default() -> Self {
        Self { gain: 1.0, noise: 1.0, white_balance: [1.0; 3], response: Response::Linear }
    }
}

impl Development {
    /// The gains of R, G, and B: the camera's own with the user's.
    pub(crate) fn balance(&self) -> [f32; 3] {
        std::array::from_fn(|k| WHITE_BALANCE[k] * self.white_balance[k])
    }

    /// Checks what was asked for.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] beyond the limits of this module; [`Error::NotFinite`].
    pub fn new(exposure_ev: f64, noise: f64, white_balance: [f64; 3], response: Response) -> Result<Self> {
        let within = |what, value: f64, least, most| {
            if (least..=most).contains(&finite(what, value)?) {
                return Ok(value as f32);
            }
            Err(Error::OutOfRange { what, value: value.to_string(), expected: format!("{least} to {most}") })
        };
        let stops = within("exposure_ev", exposure_ev, -MOST_EXPOSURE_EV, MOST_EXPOSURE_EV)?;
        let (least, most) = (*WHITE_BALANCE_FACTORS.start(), *WHITE_BALANCE_FACTORS.end());
        let [r, g, b] = white_balance.map(|factor| within("white_balance", factor, least, most));
        Ok(Self {
            gain: math::pow(2.0, f64::from(stops)) as f32,
            noise: within("noise", noise, 0.0, MOST_NOISE)?,
            white_balance: [r?, g?, b?],
            response,
        })
    }
}

/// From linear light to values, both 0 to 255.
#[derive(Debug, Clone, PartialEq)]
pub enum Response {
    /// Values are the light: KITTI's cameras'.
    Linear,
    /// Values of equal steps of light from 0 to 255, which rise.
    Curve(Arc<[f32]>),
}

impl Response {
    /// As sRGB encodes light (IEC 61966-2-1).
    #[must_use]
    pub fn srgb() -> Self {
        Self::of(
            |light| {
                if light <= SRGB_LINEAR_BELOW { 12.92 * light } else { 1.055 * math::pow(light, 1.0 / 2.4) - 0.055 }
            },
        )
    }

    /// Straight between points (light, value), shares of white.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for points that do not lead from (0, 0) to (1, 1), the lights rising and the values not falling.
    pub fn through(points: &[[f64; 2]]) -> Result<Self> {
        let is_rising = points.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] <= pair[1][1]);
        if !CURVE_POINTS.contains(&points.len())
            || points.first() != Some(&[0.0; 2])
            || points.last() != Some(&[1.0; 2])
            || !is_rising
        {
            let (value, expected) = (format!("{points:?}"), "points that rise from (0, 0) to (1, 1)".to_owned());
            return Err(Error::OutOfRange { what: "response", value, expected });
        }
        Ok(Self::of(|light| {
            let above = points.partition_point(|[x, _]| *x < light).max(1);
            let ([x1, y1], [x2, y2]) = (points[above - 1], points[above]);
            y1 + (y2 - y1) * (light - x1) / (x2 - x1)
        }))
    }

    fn of(value: impl Fn(f64) -> f64) -> Self {
        let steps = (0..=RESPONSE_STEPS).map(|i| value(i as f64 / RESPONSE_STEPS as f64) as f32 * WHITE_VALUE);
        Self::Curve(steps.collect())
    }

    /// The mean light at which the meter aims against that behind a linear response: half of it where values rise faster than the
    /// light at first. KITTI's images have a mean of 36 % of white; a photographic meter takes 18 %, middle gray, which sRGB
    /// gives a value of 118.
    #[must_use]
    pub fn aim_factor(&self) -> f32 {
        match self {
            Self::Linear => 1.0,
            Self::Curve(_) => 0.5,
        }
    }

    /// Balances the light of a row's pixels, R, G, and B each for itself, and rounds it to 8 bits, interleaved.
    pub(crate) fn write(&self, light: &[Vec<f32>; 3], white_balance: [f32; 3], out: &mut [u8]) {
        match self {
            Self::Linear => round(light, white_balance, out),
            Self::Curve(values) => {
                for (i, out) in out.iter_mut().enumerate() {
                    let light = light[i % 3][i / 3] * white_balance[i % 3];
                    let at = light.clamp(0.0, WHITE_VALUE) * (RESPONSE_STEPS as f32 / WHITE_VALUE);
                    let step = (at as usize).min(RESPONSE_STEPS - 1);
                    let value = values[step] + (values[step + 1] - values[step]) * (at - step as f32);
                    *out = (value + ROUNDER).to_bits() as u8;
                }
            }
        }
    }
}

#[apply(for_wide_registers)]
fn round([red, green, blue]: &[Vec<f32>; 3], [r, g, b]: [f32; 3], out: &mut [u8]) {
    let pixels = out.as_chunks_mut::<3>().0;
    let n = pixels.len();
    let (red, green, blue) = (&red[..n], &green[..n], &blue[..n]);
    for i in 0..n {
        // Rounded to the nearest by the mantissa's last bits.
        let value = |light: f32| (light.clamp(0.0, WHITE_VALUE) + ROUNDER).to_bits() as u8;
        pixels[i] = [value(red[i] * r), value(green[i] * g), value(blue[i] * b)];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_give_their_values() {
        let light = [0.0, 0.5, 2.5, 63.75, 200.0, 255.0, 300.0, -3.0];
        let values = |response: &Response| {
            let mut out = [0; 24];
            response.write(
                &[light.to_vec(), light.map(|v| v / 2.0).to_vec(), light.to_vec()],
                [1.0, 2.0, 1.0],
                &mut out,
            );
            let [first, second, third] = [0, 1, 2].map(|k| std::array::from_fn(|i| out[3 * i + k]));
            assert!(first == second && second == third);
            first
        };
        // By the standard's tables.
        assert_eq!(values(&Response::srgb()), [0, 6, 25, 137, 229, 255, 255, 0]);
        let bent = Response::through(&[[0.0, 0.0], [0.25, 0.5], [1.0, 1.0]]).expect("a curve");
        assert_eq!(values(&bent), [0, 1, 5, 128, 218, 255, 255, 0]);
        assert_eq!(values(&Response::Linear), [0, 0, 2, 64, 200, 255, 255, 0]);
    }

    #[test]
    fn what_is_out_of_range_is_refused_by_name() {
        let refused = |ev, noise, balance| {
            Development::new(ev, noise, balance, Response::Linear).expect_err("refused").to_string()
        };
        assert!(refused(9.0, 1.0, [1.0; 3]).contains("exposure_ev"));
        assert!(refused(0.0, -1.0, [1.0; 3]).contains("noise"));
        assert!(refused(0.0, 1.0, [1.0, 0.0, 1.0]).contains("white_balance"));
        assert!(refused(f64::NAN, 1.0, [1.0; 3]).contains("exposure_ev"));
        for points in [&[[0.0, 0.0]][..], &[[0.0, 0.1], [1.0, 1.0]], &[[0.0, 0.0], [0.5, 0.6], [0.5, 0.7], [1.0, 1.0]]]
        {
            assert!(Response::through(points).expect_err("refused").to_string().contains("response"));
        }
        let usual = Development::new(0.0, 1.0, [1.0; 3], Response::Linear).expect("KITTI's");
        assert_eq!(usual, Development::default());
        assert!((Development::new(1.0, 1.0, [1.0; 3], Response::Linear).expect("a stop").gain - 2.0).abs() < 1e-6);
    }
}
