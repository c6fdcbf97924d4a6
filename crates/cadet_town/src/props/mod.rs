//! Prop placement: houses, gardens, hedges, trees, lamps and signs along a network; a function of network and seed.

mod median;
mod overhead_line;
mod roundabout_island;
mod sidewalk_edge;
mod signal_heads;

pub(crate) use roundabout_island::is_island;

use crate::ground::Ground;
use crate::ground::land::Land;
use crate::lots::Lots;
use crate::network::{ParkingSpot, RightOfWay, RoadNetwork, Walkway};
use crate::placement::{Placer, PropConfig, PropFootprint, Site};
use crate::plots::{Paving, StreetStyle, belt, frontages, garden};
use crate::signals::Signals;
use crate::street_things::{PlotOnStreet, StreetThings};
use crate::{countryside, plots, street_things};
use cadet_base::instance::Instance;
use cadet_base::rng::StreamKey;

/// What stands along the streets of a town.
#[derive(Debug)]
pub(crate) struct Props {
    /// Everything that stands.
    pub instances: Vec<Instance>,
    /// Drives of garages, where a car may stand.
    pub drives: Vec<ParkingSpot>,
    /// Things in the way of who walks or parks, and seats.
    pub things: StreetThings,
    /// What stands where.
    pub standing: Vec<PropFootprint>,
}

/// Places the props of a network.
pub(crate) fn place_props(
    key: &StreamKey,
    (network, signals): (&RoadNetwork, &mut Signals),
    ground: &Ground,
    (parking, walkways, lots): (&[ParkingSpot], &[Walkway], &Lots),
    config: &PropConfig,
) -> Props {
    let site = Site::new(ground);
    let mut taken = lots.taken();
    let mut placer = Placer::new(&site);
    let mut drives = Vec::new();
    let mut on_lots = lots.place(key, config.greenery, &mut placer);
    let frontages = frontages(network, &site);
    let styles: Vec<StreetStyle> = frontages.iter().map(|f| StreetStyle::of(key, f, config)).collect();
    let stream = |name: &str, index: usize| key.indexed(name, index as u64);
    let mut plots_on_streets = Vec::new();
    for (i, (frontage, style)) in frontages.iter().zip(&styles).enumerate() {
        let plots = plots::lay_out(frontage, style, &site, &mut taken, &mut stream("plots", i));
        let mut things = stream("things/lots", i);
        for plot in plots {
            // What is built on a vacant plot takes the place of its garden.
            let is_cleared = street_things::is_cleared(&plot, config.clutter, &mut things);
            if !is_cleared {
                let mut s = stream("garden", plots_on_streets.len());
                garden::fill(&plot, style, &mut s, &mut placer, &mut drives);
            }
            plots_on_streets.push(PlotOnStreet { plot, frontage: i, is_cleared });
        }
        // Roundabouts have signs of their own.
        let lane = frontage.lane.map(|id| network.lane(id)).filter(|lane| !network.ends_at_roundabout(lane));
        let right_of_way = lane.and_then(|lane| RightOfWay::of(lane, network, signals));
        sidewalk_edge::furnish(frontage, right_of_way, style, &mut stream("streetside", i), &mut placer);
    }
    let mut paving = Paving::new(plots_on_streets.iter().map(|l| &l.plot));
    for (frontage, _) in frontages.iter().zip(&styles).filter(|(_, style)| style.city.is_some()) {
        paving.pave(frontage, &mut placer);
    }
    median::furnish(key, network, config.greenery, &mut placer);
    roundabout_island::furnish(key, network, config.greenery, &mut placer);
    overhead_line::string(key, network, &mut placer);
    belt::plant(&mut key.stream("belt"), config.greenery, config.belt_m, &frontages, &taken, &mut placer);
    let mut posts = signal_heads::place(signals, key, &mut placer);
    let streets =
        street_things::StreetLayout { frontages: &frontages, styles: &styles, plots_on_streets: &plots_on_streets };
    let mut things = street_things::place(key, &streets, (parking, &drives), walkways, config, &mut placer);
    things.obstacles.append(&mut posts);
    things.obstacles.append(&mut on_lots.obstacles);
    things.seats.append(&mut on_lots.seats);
    Props { instances: placer.instances, drives, things, standing: placer.standing }
}

/// Places what stands in open country.
pub(crate) fn place_in_country(
    key: &StreamKey,
    (network, signals): (&RoadNetwork, &Signals),
    land: &Land,
    ground: &Ground,
    config: &PropConfig,
) -> Props {
    let site = Site::new(ground);
    let mut placer = Placer::new(&site);
    let frontages = frontages(network, &site);
    let drives = countryside::furnish(key, (network, signals, land), &frontages, config, &mut placer);
    Props { instances: placer.instances, drives, things: StreetThings::default(), standing: placer.standing }
}

#[cfg(test)]
mod tests {
    use strum::VariantArray;

    use super::*;
    use crate::ground::GroundKind;
    use crate::network::Lane;
    use crate::street_things::tests::kind_of;
    use crate::testing::{assert_apart, shared_map, things, town};
    use crate::{Layout, SuburbConfig, Town};
    use cadet_assets::scenery::HouseKind;
    use cadet_base::math::{DVec2, DVec3};
    use cadet_sensors::sense::PosedScene;

    fn suburb(seed: u64) -> (Town, Layout) {
        town(seed, &SuburbConfig { blocks: (3, 3), ..Default::default() }, &PropConfig::default())
    }

    /// Things, benches, and rails on sidewalks and in bays have tests of their own.
    fn is_furniture(standing: &&PropFootprint) -> bool {
        let is_other = ["bench", "guard-rail"].iter().any(|kind| standing.name.starts_with(kind));
        is_other || kind_of(&standing.name).is_some()
    }

    fn is_house(standing: &PropFootprint) -> bool {
        let kind = standing.name.split('/').next().unwrap();
        kind == "garage" || HouseKind::VARIANTS.iter().any(|k| k.as_ref() == kind)
    }

    #[test]
    fn nothing_stands_in_the_way_and_houses_keep_apart() {
        for seed in [1, 2, 3] {
            let (Town { ground, .. }, Layout { standing, .. }) = suburb(seed);
            let mut houses = Vec::new();
            for standing in standing.iter().filter(|s| !is_furniture(s)) {
                let kinds: Vec<GroundKind> =
                    standing.rect.samples(0.5).filter_map(|p| ground.kind_at(p.x, p.y)).collect();
                assert!(!kinds.contains(&GroundKind::Road), "seed {seed}: {standing:?} on the road");
                let at_the_edge = standing.rect.half.max_element() < 0.75;
                let paved = kinds.iter().filter(|k| **k == GroundKind::Sidewalk).count();
                assert!(at_the_edge || paved == 0, "seed {seed}: {standing:?} on the sidewalk");
                if is_house(standing) {
                    houses.push(standing);
                }
            }
            assert!(houses.len() > 40, "seed {seed}: {} houses", houses.len());
            assert_apart(&houses, &format!("seed {seed}"));
        }
    }

    #[test]
    fn give_way_signs_stand_where_lanes_yield() {
        let (mut num_lanes, mut num_signs) = (0, 0);
        for seed in 0..6 {
            let suburb = SuburbConfig { main_share: 1.0, blocks: (3, 3), ..Default::default() };
            let (Town { network, signals, .. }, Layout { standing, .. }) = town(seed, &suburb, &PropConfig::default());
            let does_yield = |l: &&Lane| {
                let right_of_way = RightOfWay::of(l, &network, &signals);
                l.junction.is_none() && right_of_way == Some(RightOfWay::Yield) && !network.ends_at_roundabout(l)
            };
            let ends: Vec<DVec3> =
                network.driving().filter(does_yield).filter_map(|l| l.center.last().copied()).collect();
            for sign in standing.iter().filter(|s| s.name.starts_with("triangle-sign")) {
                let apart_m = ends.iter().map(|end| (end.truncate() - sign.rect.center).length());
                assert!(apart_m.fold(f64::INFINITY, f64::min) < 10.0, "seed {seed}: {sign:?} where nobody yields");
                num_signs += 1;
            }
            num_lanes += ends.len();
        }
        assert!(num_lanes > 10 && 3 * num_signs > 2 * num_lanes, "{num_signs} signs for {num_lanes} lanes");
    }

    #[test]
    fn houses_face_a_street() {
        let (Town { ground, .. }, Layout { standing, .. }) = suburb(4);
        for house in standing.iter().filter(|s| is_house(s)) {
            let reach = |axis: DVec2| {
                let paved = |m: &usize| {
                    let p = house.rect.center + axis * (house.rect.half.x + *m as f64 * 0.5);
                    ground.kind_at(p.x, p.y).is_some_and(|k| k != GroundKind::Terrain)
                };
                (0..60).find(paved)
            };
            let front = reach(house.rect.axis).unwrap_or_else(|| panic!("{house:?} faces no street"));
            assert!(front < 44, "{house:?}: {front} half meters to the sidewalk");
        }
    }

    #[test]
    fn the_same_key_gives_the_same_town_of_any_kind() {
        let (suburb, props) = (SuburbConfig::default(), PropConfig::default());
        let country = SuburbConfig { country_share: 1.0, ..suburb.clone() };
        let car_parks = PropConfig { car_park_share: 1.0, ..props.clone() };
        for (suburb, props) in [(&suburb, &props), (&country, &props), (&suburb, &car_parks)] {
            let told = |(town, Layout { standing, .. }): (Town, Layout)| {
                let of = |i: &Instance| (i.world_from_local, i.shape.levels.len(), i.palette.materials()[0].albedo);
                let poses: Vec<_> = things(&town).iter().map(of).collect();
                [
                    format!("{poses:?}"),
                    format!("{standing:?} {:?}", town.parking),
                    format!("{:?}", town.ground.vertices),
                ]
            };
            let first = told(town(5, suburb, props));
            assert!(first == told(town(5, suburb, props)));
            // On the same streets another key decides what stands there.
            let network = crate::generate_suburb(&StreamKey::scene(5), suburb).unwrap().network;
            let other = told(Town::laid_out(&StreamKey::scene(6), "test", network, props).unwrap());
            assert!(first[0] != other[0] && first[1] != other[1]);
        }
    }

    /// Houses, all else that stands within 50 m of the middle of some lanes, and the triangles in sight there.
    fn around_lanes(config: &PropConfig) -> Vec<[usize; 3]> {
        let mut found = Vec::new();
        for seed in 0..2 {
            let (town, Layout { standing, .. }) = town(seed, &SuburbConfig::default(), config);
            let lanes: Vec<_> = town.network.driving().filter(|l| l.length_m() > 40.0).collect();
            for lane in lanes.iter().step_by(lanes.len() / 5) {
                let viewer = lane.pose_at(lane.length_m() / 2.0).translation + DVec3::Z * 1.7;
                let is_near = |s: &&PropFootprint| (s.rect.center - viewer.truncate()).length() < 50.0;
                let near: Vec<&PropFootprint> = standing.iter().filter(is_near).collect();
                let houses = near.iter().filter(|s| is_house(s)).count();
                let scene = PosedScene::new(things(&town), viewer);
                found.push([houses, near.len() - houses, scene.num_triangles()]);
            }
        }
        found
    }

    #[test]
    fn streets_are_lined_but_not_too_heavy() {
        let found = around_lanes(&PropConfig::default());
        let (houses_and_more, triangles) =
            (found.iter().map(|f| f[0] + f[1]).sum::<usize>(), found.iter().map(|f| f[2]).sum::<usize>());
        let least = |k: usize| found.iter().map(|f| f[k]).min().unwrap();
        assert!(found.len() >= 10);
        // Plots are 14 to 30 m wide and lie on both sides of 100 m; each has its trees, hedges and fences.
        assert!(least(0) >= 4 && least(1) >= 30, "{found:?}");
        assert!(found.iter().all(|f| f[2] < 900_000), "{found:?}");
        // The same streets without greenery are bare of plants, which are most of the triangles; fences and lamps stay.
        let bare = around_lanes(&PropConfig { greenery: 0.0, ..Default::default() });
        let of = |k: usize| bare.iter().map(|f| f[k]).sum::<usize>();
        assert!(2 * of(2) < triangles && of(0) + of(1) < houses_and_more, "{bare:?} of {found:?}");
    }

    #[test]
    fn imported_maps_have_props_clear_of_their_streets() {
        for map in ["Town01.xodr", "Town02.xodr"] {
            let Some(network) = shared_map(map) else { continue };
            let props = PropConfig::default();
            let (town, Layout { standing, .. }) = Town::laid_out(&StreamKey::scene(1), map, network, &props).unwrap();
            for standing in standing.iter().filter(|s| !is_furniture(s)) {
                let on_road = |p: DVec2| town.ground.kind_at(p.x, p.y) == Some(GroundKind::Road);
                assert!(!standing.rect.samples(0.5).any(on_road), "{map}: {standing:?} on the road");
            }
            let houses = standing.iter().filter(|s| is_house(s)).count();
            assert!(houses > 80, "{map}: {houses} houses");
        }
    }

    #[test]
    fn a_bad_configuration_names_the_value() {
        let bad = PropConfig { greenery: 3.0, ..Default::default() };
        assert_eq!(bad.check().unwrap_err().to_string(), "greenery is 3, expected 0 to 2");
        assert!(PropConfig { house_shares: [0.0; 6], ..Default::default() }.check().is_err());
        assert!(PropConfig { belt_m: f64::NAN, ..Default::default() }.check().is_err());
    }
}
