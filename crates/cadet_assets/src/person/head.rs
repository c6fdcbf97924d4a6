//! Neck, head, hair, and headwear.

use super::clothes::slot;
use super::frame::{Frame, SIDES};
use super::proportions::{Headwear, Proportions};
use super::tube::{Ring, Tubes};
use cadet_base::math::Vec3;

pub(crate) fn add_head(tubes: &mut Tubes, p: &Proportions, frame: &Frame, level: usize) {
    let k = p.head_m / 0.223;
    // The head stays upright whatever the trunk does.
    let chin = frame.spine(p.chin_m) + Vec3::X * 0.012;
    let ring = |z: f32, dx: f32, x: f32, y: f32, slot: u8, level: usize| {
        Ring::new(chin + Vec3::new(dx * k, 0.0, z * p.head_m), [Vec3::Z, Vec3::X], [x * k, y * k], slot, level)
    };
    let skin = slot::SKIN;
    let head = [
        ring(0.0, 0.038, 0.034, 0.032, skin, 0),
        ring(0.07, 0.028, 0.058, 0.048, skin, 2),
        ring(0.22, 0.014, 0.078, 0.060, skin, 1),
        ring(0.38, 0.008, 0.090, 0.068, skin, 0),
        ring(0.55, 0.002, 0.095, 0.074, skin, 2),
        ring(0.72, 0.0, 0.095, 0.075, skin, 0),
        ring(0.88, -0.002, 0.078, 0.062, skin, 1),
        ring(0.96, -0.004, 0.050, 0.040, skin, 2),
    ];
    tubes.tube(&head, SIDES[level][3], level, -1.0);
    if level == 0 {
        let nose = [
            ring(0.34, 0.100, 0.018, 0.016, skin, 0),
            ring(0.40, 0.100, 0.014, 0.013, skin, 0),
            ring(0.52, 0.092, 0.008, 0.009, skin, 0),
        ];
        tubes.tube(&nose, 6, 0, -1.0);
    }
    let h = slot::HAIR;
    let hair = match p.headwear {
        Headwear::ShortHair => vec![
            ring(0.20, -0.040, 0.042, 0.052, h, 0),
            ring(0.36, -0.034, 0.064, 0.070, h, 1),
            ring(0.58, -0.022, 0.082, 0.082, h, 2),
            ring(0.74, -0.012, 0.096, 0.084, h, 1),
            ring(0.84, -0.004, 0.094, 0.078, h, 0),
            ring(0.95, -0.006, 0.072, 0.060, h, 2),
            ring(1.02, -0.010, 0.040, 0.034, h, 1),
        ],
        Headwear::LongHair => vec![
            ring(-0.42, -0.060, 0.022, 0.075, h, 1),
            ring(-0.22, -0.060, 0.036, 0.088, h, 2),
            ring(0.10, -0.045, 0.055, 0.090, h, 1),
            ring(0.36, -0.034, 0.070, 0.088, h, 0),
            ring(0.58, -0.024, 0.086, 0.089, h, 2),
            ring(0.74, -0.012, 0.098, 0.087, h, 1),
            ring(0.86, -0.004, 0.094, 0.078, h, 0),
            ring(0.96, -0.006, 0.072, 0.060, h, 2),
            ring(1.03, -0.010, 0.040, 0.034, h, 1),
        ],
        Headwear::Hat => vec![
            ring(0.66, 0.030, 0.138, 0.090, h, 1),
            ring(0.70, 0.022, 0.132, 0.092, h, 2),
            ring(0.74, -0.002, 0.106, 0.088, h, 1),
            ring(0.90, -0.004, 0.098, 0.082, h, 0),
            ring(1.0, -0.006, 0.078, 0.064, h, 2),
            ring(1.05, -0.006, 0.040, 0.034, h, 0),
        ],
        Headwear::Helmet => vec![
            ring(0.52, -0.030, 0.092, 0.086, h, 1),
            ring(0.62, -0.008, 0.124, 0.100, h, 2),
            ring(0.74, -0.004, 0.132, 0.102, h, 0),
            ring(0.90, -0.008, 0.118, 0.090, h, 1),
            ring(1.03, -0.012, 0.084, 0.064, h, 2),
            ring(1.09, -0.014, 0.044, 0.034, h, 0),
        ],
    };
    tubes.tube(&hair, SIDES[level][3], level, -1.0);
}
