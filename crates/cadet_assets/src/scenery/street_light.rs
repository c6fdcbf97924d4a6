//! What street lamps send out at night.

use std::sync::Arc;

use super::materials::furniture_slot as slot;
use cadet_base::lamp::{Lamp, LampBeam};
use cadet_base::material::{Palette, Pattern};
use cadet_base::math::Vec3;
use cadet_base::rng::Stream;

/// The light source of a street's lamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreetLight {
    /// High-pressure sodium, 2000 K.
    Sodium,
    /// LED of 3000 K.
    Warm,
    /// LED of 4000 K.
    Neutral,
}

/// Shares of the light sources, in their order, and their colors: linear R, G, B of luma 1.
const SHARES: [f64; 3] = [0.3, 0.4, 0.3];
const COLORS: [[f32; 3]; 3] = [[1.72, 0.86, 0.16], [1.28, 0.96, 0.55], [1.08, 0.98, 0.90]];

/// Where the light of a lamp comes from and how strong it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Head {
    /// In the model's frame.
    pub at: Vec3,
    /// Straight down: 340 cd make 17 lx below a residential lamp of 4.5 m, 1100 cd make 20 lx below 7.5 m.
    pub downward_cd: f32,
    /// Whether it shines to all sides, not only down.
    pub is_globe: bool,
    /// Nothing is lit beyond.
    pub reach_m: f32,
    /// The slot of what shines, and its radiance as a share of the camera's lamp radiance.
    pub lens: u8,
    /// See there.
    pub radiance: f32,
}

/// A head that is cut off at the sides, and one that shines to all sides.
const CUT_OFF: LampBeam = LampBeam::Luminaire { cos_ends: 0.10, cos_full: 0.32 };
const GLOBE: LampBeam = LampBeam::Luminaire { cos_ends: -0.30, cos_full: 0.40 };
/// A lamp on a wire.
const SPAN_CD: f32 = 850.0;
const SPAN_REACH_M: f32 = 48.0;

impl StreetLight {
    /// One by their shares.
    #[must_use]
    pub fn draw(stream: &mut Stream) -> Self {
        [Self::Sodium, Self::Warm, Self::Neutral][stream.weighted(&SHARES)]
    }

    /// The palette of a lamp on a wire, whose lens is at this height.
    #[must_use]
    pub fn on_wire(self, lens_m: f32, palette: &Arc<Palette>) -> Arc<Palette> {
        let (at, downward_cd, reach_m) = (Vec3::Z * lens_m, SPAN_CD, SPAN_REACH_M);
        self.lit(palette, &Head { at, downward_cd, is_globe: false, reach_m, lens: slot::ACCENT, radiance: 2.0 })
    }

    /// A palette with a lamp that is lit at night.
    #[must_use]
    pub fn lit(self, palette: &Arc<Palette>, head: &Head) -> Arc<Palette> {
        let color = COLORS[self as usize];
        let mut materials = palette.materials().to_vec();
        let lens = &mut materials[usize::from(head.lens)];
        (lens.albedo, lens.pattern) = (color.map(|c| c * head.radiance), Pattern::Lamp);
        let beam = if head.is_globe { GLOBE } else { CUT_OFF };
        let lamp = Lamp::of_candela(beam, head.at, [-Vec3::Z, Vec3::Y], color, head.downward_cd, head.reach_m);
        let at_night = Palette::new(materials).with_lamps(vec![lamp]);
        Arc::new(Palette::clone(palette).with_night(at_night))
    }
}
