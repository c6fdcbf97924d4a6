//! What one street has in common: its houses, boundaries, trees and lamps, drawn once a street.

use strum::VariantArray;

use crate::placement::{Boundary, PropConfig};
use crate::plots::{Frontage, LotUse};
use cadet_assets::props::{ARM_LAMP, LAMP, Shipped, WALL, WIRE};
use cadet_assets::scenery::{HouseKind, StreetLight, num_variants};
use cadet_base::rng::{Stream, StreamKey};

/// Share of the streets with closed rows whose lamps hang on wires.
const WIRES_SHARE: f64 = 0.6;

/// What goes with closed rows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CityStyle {
    /// Spacing of lamps on wires, if there are any.
    pub lamp_every_m: Option<f64>,
    /// Spacing of trees in pits, if there are any.
    pub tree_every_m: Option<f64>,
}

/// The trees along a street.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StreetTrees {
    pub every_m: f64,
    pub variant: usize,
}

/// The lamps along a street.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StreetLamps {
    pub kind: Shipped,
    pub variant: usize,
    pub every_m: f64,
}

/// The hyper-parameters of one street: scenes differ from each other more than the houses of one.
#[derive(Debug, Clone)]
pub(crate) struct StreetStyle {
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
    /// The trees along it, if there are any.
    pub street_trees: Option<StreetTrees>,
    pub lamps: StreetLamps,
    /// The light of its lamps.
    pub street_light: StreetLight,
    /// Share of plots left open: gardens and meadows.
    pub vacant_share: f64,
    /// Share of plots with bins at the gate.
    pub bin_share: f64,
    /// Closed rows of tall houses at the sidewalk, and what goes with them.
    pub city: Option<CityStyle>,
    /// What the lots are for, where they take the place of houses.
    pub lots: Option<LotUse>,
}

impl StreetStyle {
    /// The style of the road behind a frontage.
    pub fn of(key: &StreamKey, frontage: &Frontage, config: &PropConfig) -> Self {
        let style = Self::draw(key, frontage.road, frontage.speed_limit_mps, config);
        let lots = [
            ("car park street", config.car_park_share, LotUse::CarPark),
            ("industrial street", config.industrial_share, LotUse::Industry),
            ("campus street", config.campus_share, LotUse::Campus),
        ];
        let stream = |name: &str| key.indexed(name, u64::from(frontage.road));
        if let Some((_, _, usage)) = lots.iter().find(|(name, share, _)| stream(name).chance(*share)) {
            style.with_lots(*usage, &mut stream("lot street"), config.greenery)
        } else if stream("city street").chance(config.city_share) {
            style.in_the_city(&mut stream("city style"), config.greenery)
        } else if frontage.is_main_road {
            style.beside_main_road(&mut stream("main road"), config.greenery)
        } else {
            style
        }
    }

    /// Flats behind lawns, or no houses at all: woods, hedges, meadows.
    fn beside_main_road(self, s: &mut Stream, greenery: f64) -> Self {
        let [_, trees, hedges] = num_variants();
        let is_built = s.chance(0.5);
        let boundary = match s.weighted(&[0.45, 0.15, 0.1, 0.3]) {
            0 => Boundary::Hedge(s.below(hedges)),
            1 => Boundary::fence(WIRE, s),
            2 => Boundary::fence(WALL, s),
            _ => Boundary::Open,
        };
        let has_trees = s.chance((0.9 * greenery).min(1.0));
        Self {
            houses: [HouseKind::Flats, [HouseKind::Block, HouseKind::Flats, HouseKind::Terrace][s.below(3)]],
            setback_m: s.range(5.0, 8.0),
            boundary,
            trees_per_100_m2: greenery * if is_built { s.range(0.9, 2.2) } else { s.range(2.0, 4.5) },
            street_trees: has_trees.then(|| StreetTrees { every_m: s.range(7.0, 12.0), variant: s.below(trees) }),
            vacant_share: if is_built { s.range(0.15, 0.4) } else { s.range(0.75, 0.97) },
            ..self
        }
    }

    /// Lots in place of houses; what they leave is green.
    fn with_lots(self, usage: LotUse, s: &mut Stream, greenery: f64) -> Self {
        let [.., hedges] = num_variants();
        let lamps = match usage {
            LotUse::Industry => {
                StreetLamps { kind: ARM_LAMP, variant: s.below(ARM_LAMP.num_variants()), every_m: s.range(30.0, 40.0) }
            }
            // Of 4 m.
            LotUse::Campus => StreetLamps { kind: LAMP, variant: 0, every_m: s.range(18.0, 26.0) },
            LotUse::CarPark => self.lamps,
        };
        let boundary = match s.weighted(&[0.4, 0.3, 0.3]) {
            0 => Boundary::Hedge(s.below(hedges)),
            1 => Boundary::fence(WIRE, s),
            _ => Boundary::Open,
        };
        Self {
            setback_m: 6.0,
            boundary,
            trees_per_100_m2: greenery * s.range(0.6, 1.6),
            street_trees: None,
            lamps,
            vacant_share: 1.0,
            bin_share: 0.0,
            lots: Some(usage),
            ..self
        }
    }

    /// Rows without gaps or front gardens.
    fn in_the_city(self, s: &mut Stream, greenery: f64) -> Self {
        let (has_wires, has_trees) = (s.chance(WIRES_SHARE), s.chance((0.5 * greenery).min(1.0)));
        Self {
            houses: [HouseKind::Block; 2],
            setback_m: 0.0,
            boundary: Boundary::fence(WALL, s),
            trees_per_100_m2: 0.6 * self.trees_per_100_m2,
            street_trees: None,
            vacant_share: 0.0,
            bin_share: 0.0,
            city: Some(CityStyle {
                lamp_every_m: has_wires.then(|| s.range(24.0, 34.0)),
                tree_every_m: has_trees.then(|| s.range(8.0, 13.0)),
            }),
            ..self
        }
    }

    fn draw(key: &StreamKey, road: u32, speed_limit_mps: f64, config: &PropConfig) -> Self {
        let mut stream = key.indexed("street", u64::from(road));
        let s = &mut stream;
        let kind = |s: &mut Stream| HouseKind::VARIANTS[s.weighted(&config.house_shares)];
        let houses = [kind(s), kind(s)];
        let fast = speed_limit_mps > 10.0;
        let lamp_kind = if fast { ARM_LAMP } else { LAMP };
        let [_, trees, _] = num_variants();
        Self {
            houses,
            main_share: s.range(0.6, 0.95),
            setback_m: s.clipped_normal(4.8, 1.3).clamp(2.2, 8.0),
            boundary: Boundary::draw(s),
            trees_per_100_m2: config.greenery * s.range(0.6, 1.9),
            street_trees: s
                .chance((0.6 * config.greenery).min(0.9))
                .then(|| StreetTrees { every_m: s.range(8.0, 13.5), variant: s.below(trees) }),
            lamps: StreetLamps {
                kind: lamp_kind,
                variant: s.below(lamp_kind.num_variants()),
                every_m: s.range(25.0, 35.0),
            },
            vacant_share: s.range(0.02, 0.16),
            bin_share: if s.chance(0.2) { 0.85 } else { 0.25 },
            street_light: StreetLight::draw(&mut key.indexed("street light", u64::from(road))),
            city: None,
            lots: None,
        }
    }
}
