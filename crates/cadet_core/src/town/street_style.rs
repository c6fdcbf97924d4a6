//! What one street has in common: its houses, boundaries, trees and lamps, drawn once a street.

use super::prop_config::PropConfig;
use crate::assets::scenery::{FenceKind, HouseKind, PoleKind, num_variants};
use crate::rng::{Stream, StreamKey};

/// What stands between a garden and the sidewalk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Boundary {
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

/// The hyper-parameters of one street: scenes differ from each other more than the houses of one.
#[derive(Debug, Clone)]
pub(super) struct StreetStyle {
    /// The kind of most of its houses, and the kind of some.
    pub houses: [HouseKind; 2],
    /// Share of the first kind.
    pub main_share: f64,
    /// Setback of houses with a front garden.
    pub setback_m: f64,
    /// The boundary of most plots.
    pub boundary: Boundary,
    /// Trees a 100 m² of garden.
    pub trees_per_100_m2: f64,
    /// Spacing of street trees and their variant, if there are any.
    pub street_trees: Option<(f64, usize)>,
    /// Lamps: kind, variant, spacing.
    pub lamp: (PoleKind, usize, f64),
    /// Share of plots left open: gardens and meadows.
    pub vacant_share: f64,
    /// Share of plots with bins at the gate.
    pub bin_share: f64,
}

impl StreetStyle {
    /// The style of a road.
    pub fn draw(key: &StreamKey, road: u32, speed_limit_mps: f64, config: &PropConfig) -> Self {
        let mut stream = key.indexed("street", u64::from(road));
        let s = &mut stream;
        let kind = |s: &mut Stream| HouseKind::ALL[s.weighted(&config.house_shares)];
        let houses = [kind(s), kind(s)];
        let fast = speed_limit_mps > 10.0;
        let lamp_kind = if fast { PoleKind::ArmLamp } else { PoleKind::Lamp };
        let [_, trees, .., poles, _] = num_variants();
        Self {
            houses,
            main_share: s.range(0.6, 0.95),
            setback_m: s.clipped_normal(4.8, 1.3).clamp(2.2, 8.0),
            boundary: Boundary::draw(s),
            trees_per_100_m2: config.greenery * s.range(0.5, 1.5),
            street_trees: s.chance(0.5 * config.greenery.min(1.6)).then(|| (s.range(8.5, 15.0), s.below(trees))),
            lamp: (lamp_kind, s.below(poles), s.range(25.0, 35.0)),
            vacant_share: s.range(0.02, 0.16),
            bin_share: if s.chance(0.2) { 0.85 } else { 0.25 },
        }
    }
}
