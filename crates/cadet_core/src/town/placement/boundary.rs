//! What stands between a garden and the sidewalk.

use crate::assets::scenery::{FenceKind, num_variants};
use crate::rng::Stream;

/// What stands between a garden and the sidewalk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::town) enum Boundary {
    /// A hedge of a variant.
    Hedge(usize),
    /// A fence or wall of a variant.
    Fence(FenceKind, usize),
    /// Nothing.
    Open,
}

impl Boundary {
    /// By the shares of a South German suburb; `low` ones do not hide the garden.
    pub fn draw(stream: &mut Stream) -> Self {
        let [_, _, fences, hedges, ..] = num_variants();
        let variant = stream.below(fences);
        match stream.weighted(&[0.35, 0.12, 0.18, 0.15, 0.05, 0.05, 0.10]) {
            0 => Self::Hedge(stream.below(hedges)),
            1 => Self::Fence(FenceKind::Picket, variant),
            2 => Self::Fence(FenceKind::Railing, variant),
            3 => Self::Fence(FenceKind::Wall, variant),
            4 => Self::Fence(FenceKind::Screen, variant),
            5 => Self::Fence(FenceKind::Wire, variant),
            _ => Self::Open,
        }
    }
}
