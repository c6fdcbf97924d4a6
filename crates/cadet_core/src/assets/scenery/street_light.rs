//! What street lamps send out at night.

use std::sync::Arc;

use super::materials::furniture_slot as slot;
use super::pole::{self, PoleKind};
use crate::lamp::{CD_PER_INTENSITY, Lamp, LampBeam};
use crate::material::{Palette, Pattern};
use crate::math::Vec3;
use crate::rng::Stream;

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
struct Head {
    at: Vec3,
    candela: f32,
    beam: LampBeam,
    reach_m: f32,
    /// Of what shines, as a share of the camera's lamp radiance.
    lens: f32,
}

/// A head that is cut off at the sides, and one that shines to all sides.
const CUT_OFF: LampBeam = LampBeam::Luminaire { cos_ends: 0.10, cos_full: 0.32 };
const GLOBE: LampBeam = LampBeam::Luminaire { cos_ends: -0.30, cos_full: 0.40 };
/// Straight down: a residential lamp of 4.5 m makes 17 lx below it, an arm lamp of 7.5 m 20.
const SMALL_CD: f32 = 340.0;
const TALL_CD: f32 = 1100.0;
const SPAN_CD: f32 = 850.0;
const SMALL_REACH_M: f32 = 32.0;
const TALL_REACH_M: f32 = 48.0;

impl StreetLight {
    /// One by their shares.
    #[must_use]
    pub fn draw(stream: &mut Stream) -> Self {
        [Self::Sodium, Self::Warm, Self::Neutral][stream.weighted(&SHARES)]
    }

    /// The palette of a lamp that is lit at night; other poles keep theirs.
    #[must_use]
    pub fn on_pole(self, kind: PoleKind, variant: usize, palette: &Arc<Palette>) -> Arc<Palette> {
        let Some((at, is_globe)) = pole::lamp_head(kind, variant) else { return Arc::clone(palette) };
        let beam = if is_globe { GLOBE } else { CUT_OFF };
        let head = match kind {
            PoleKind::ArmLamp => Head { at, candela: TALL_CD, beam, reach_m: TALL_REACH_M, lens: 2.5 },
            _ => Head { at, candela: SMALL_CD, beam, reach_m: SMALL_REACH_M, lens: 1.2 },
        };
        self.lit(palette, &head)
    }

    /// The palette of a lamp on a wire, whose lens is at this height.
    #[must_use]
    pub fn on_wire(self, lens_m: f32, palette: &Arc<Palette>) -> Arc<Palette> {
        let at = Vec3::Z * lens_m;
        self.lit(palette, &Head { at, candela: SPAN_CD, beam: CUT_OFF, reach_m: TALL_REACH_M, lens: 2.0 })
    }

    fn lit(self, palette: &Arc<Palette>, head: &Head) -> Arc<Palette> {
        let color = COLORS[self as usize];
        let mut materials = palette.materials().to_vec();
        let lens = &mut materials[usize::from(slot::ACCENT)];
        (lens.albedo, lens.pattern) = (color.map(|c| c * head.lens), Pattern::Lamp);
        let lamp = Lamp {
            beam: head.beam,
            at: head.at,
            ahead: -Vec3::Z,
            left: Vec3::Y,
            intensity: color.map(|c| c * (head.candela / CD_PER_INTENSITY)),
            reach_m: head.reach_m,
        };
        let at_night = Palette::new(materials).with_lamps(vec![lamp]);
        Arc::new(Palette::clone(palette).with_night(at_night))
    }
}
