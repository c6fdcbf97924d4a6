//! What stands between a garden and the sidewalk.

use cadet_assets::props::{PICKET, RAILING, SCREEN, Shipped, WALL, WIRE};
use cadet_assets::scenery::num_variants;
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
    /// By the shares of a South German suburb; `low` ones do not hide the garden.
    pub fn draw(stream: &mut Stream) -> Self {
        let [.., hedges] = num_variants();
        let variant = stream.below(PICKET.num_variants());
        match stream.weighted(&[0.35, 0.12, 0.18, 0.15, 0.05, 0.05, 0.10]) {
            0 => Self::Hedge(stream.below(hedges)),
            1 => Self::Fence(PICKET, variant),
            2 => Self::Fence(RAILING, variant),
            3 => Self::Fence(WALL, variant),
            4 => Self::Fence(SCREEN, variant),
            5 => Self::Fence(WIRE, variant),
            _ => Self::Open,
        }
    }
}
