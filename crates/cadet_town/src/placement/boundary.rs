//! What stands between a garden and the sidewalk.

use std::sync::Arc;

use cadet_assets::props::{PICKET, RAILING, SCREEN, Shipped, WALL, WIRE};
use cadet_assets::scenery::materials::plant_palette;
use cadet_assets::scenery::{hedge, num_variants};
use cadet_base::material::Palette;
use cadet_base::rng::Stream;

/// What stands between a garden and the sidewalk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Boundary {
    /// A hedge of a variant.
    Hedge(usize),
    /// A fence or wall of a variant.
    Fence(Shipped, usize),
    /// Nothing.
    Open,
}

impl Boundary {
    /// By the shares of a South German suburb.
    pub fn draw(stream: &mut Stream) -> Self {
        let [.., hedges] = num_variants();
        let variant = stream.below(PICKET.num_variants());
        match stream.weighted(&[0.35, 0.12, 0.18, 0.15, 0.05, 0.05, 0.10]) {
            0 => Self::Hedge(stream.below(hedges)),
            k @ 1..=5 => Self::Fence([PICKET, RAILING, WALL, SCREEN, WIRE][k - 1], variant),
            _ => Self::Open,
        }
    }

    /// A fence or wall of a kind, of any variant.
    pub fn fence(kind: Shipped, s: &mut Stream) -> Self {
        Self::Fence(kind, s.below(kind.num_variants()))
    }

    /// A palette for it.
    pub fn palette(self, s: &mut Stream) -> Arc<Palette> {
        match self {
            Self::Hedge(variant) => plant_palette(s, variant % 2 == 0),
            Self::Fence(kind, variant) => kind.palette(variant, s),
            Self::Open => WALL.palette(0, s),
        }
    }

    /// Depth across its run.
    pub fn depth_m(self) -> f64 {
        match self {
            Self::Hedge(variant) => hedge(variant, 0).footprint_size().y,
            Self::Fence(..) => 0.34,
            Self::Open => 0.0,
        }
    }
}
