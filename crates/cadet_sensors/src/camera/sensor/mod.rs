//! The sensor: exposure, color filters, and noise.

mod exposure;
mod mosaic;
mod noise;

pub(super) use exposure::{Exposure, MeteredPixels};
pub use exposure::{Gain, LastGain, Metering};
#[cfg(test)]
pub(super) use exposure::{
    LUMA_WEIGHTS, MEAN_LUMA, MeteredPixel, NIGHT_MEAN_LUMA, VEILING_GLARE_SHARE, balanced, gain_at_night,
    gain_for_mean_luma,
};
pub(super) use noise::{MIDDLE_PX, ROWS_BEFORE, blur, expose};
