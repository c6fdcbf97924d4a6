//! What stands beside country roads: where it should, and nothing on them.

use strum::VariantArray;

use crate::countryside::horizon;
use crate::ground::land::Crop;
use crate::ground::{FARTHEST_M, GroundKind, extent};
use crate::testing::{things, town};
use crate::{LaneKind, Layout, PropConfig, SuburbConfig, Town};
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::{DistanceFrom, edges};
use cadet_base::rng::{Stream, StreamKey};

fn country(seed: u64) -> (Town, Layout) {
    let usual = SuburbConfig::default();
    let suburb = SuburbConfig { country_share: 1.0, blocks: (2, 2), block_m: (150.0, 240.0), ..usual };
    town(seed, &suburb, &PropConfig::default())
}

fn motorway(seed: u64) -> (Town, Layout) {
    town(seed, &SuburbConfig { motorway_share: 1.0, ..SuburbConfig::default() }, &PropConfig::default())
}

fn road_edges(town: &Town) -> DistanceFrom {
    DistanceFrom::new(town.ground.carriageway_outline().iter().flat_map(|ring| edges(ring)), FARTHEST_M)
}

/// Of paved ways to farms, which lie on the verge, nothing is told here: they have no footprint.
#[test]
fn nothing_stands_on_a_road_and_no_branch_hangs_over_one_lower_than_a_van() {
    for seed in 0..8 {
        let (country, Layout { standing, .. }) = if seed < 4 { country(seed) } else { motorway(seed) };
        assert!(standing.len() > 800, "seed {seed}: {} things", standing.len());
        for standing in &standing {
            let on_road = |p: DVec2| country.ground.kind_at(p.x, p.y) == Some(GroundKind::Road);
            assert!(!standing.rect.samples(0.4).any(on_road), "seed {seed}: {standing:?}");
        }
        let on_lane = |p: DVec3| {
            country.network.driving().any(|l| {
                let (s_m, off_m) = l.project(p);
                off_m < l.width_at(s_m) / 2.0 - 0.3
            })
        };
        for instance in things(&country).iter().filter(|i| i.palette.has_vegetation()).step_by(3) {
            let low: Vec<DVec3> = instance.shape.levels[0]
                .1
                .places()
                .step_by(5)
                .map(|p| instance.world_from_local.transform_point(p.as_dvec3()))
                .filter(|p| country.ground.height_at(p.x, p.y).is_some_and(|z| p.z - z < 2.2))
                .collect();
            let near = low.iter().filter(|p| country.ground.kind_at(p.x, p.y) == Some(GroundKind::Road));
            assert_eq!(
                near.filter(|p| on_lane(**p)).count(),
                0,
                "seed {seed}: {}",
                instance.world_from_local.translation
            );
        }
    }
}

#[test]
fn delineators_stand_half_a_meter_from_the_asphalt_fifty_meters_apart() {
    let (mut count, mut apart_m) = (0, Vec::new());
    for seed in 0..6 {
        let (country, Layout { standing, .. }) = country(seed);
        let edges = road_edges(&country);
        let posts: Vec<DVec2> =
            standing.iter().filter(|s| s.name.starts_with("delineator")).map(|s| s.rect.center).collect();
        count += posts.len();
        for (i, post) in posts.iter().enumerate() {
            let off_m = edges.distance_m(*post);
            assert!((off_m - 0.5).abs() < 0.12, "seed {seed}: {off_m} m from the asphalt");
            // They are placed one after the other along one side of a road; the next side's first is seldom as far.
            let to_next_m = posts.get(i + 1).map_or(0.0, |n| (*n - *post).length());
            if (0.84..1.1).contains(&(to_next_m / 50.0)) {
                apart_m.push(to_next_m);
            }
        }
    }
    assert!(count > 300 && 10 * apart_m.len() > 6 * count, "{count} posts, {} neighbors", apart_m.len());
    // The chord of a bend is shorter than its arc: by 2 m at a radius of 50 m.
    let along = apart_m.iter().filter(|m| (**m - 50.0).abs() < 2.5).count();
    assert!(20 * along > 19 * apart_m.len(), "{along} of {}", apart_m.len());
}

#[test]
fn the_ground_has_the_section_of_its_roadside_and_no_curb() {
    for seed in 0..3 {
        let (country, Layout { land, roughness, .. }) = country(seed);
        let (roadside, ground, edges) = (&land.unwrap().roadside, &country.ground, road_edges(&country));
        let mut s = Stream::from_seed("sections", seed);
        let lanes: Vec<_> = country.network.driving().filter(|l| l.junction.is_none() && l.length_m() > 60.0).collect();
        let mut worst = [0.0_f64; 4];
        for _ in 0..300 {
            let lane = lanes[s.below(lanes.len())];
            let pose = lane.pose_at(s.range(25.0, lane.length_m() - 25.0));
            let out = -(pose.rotation * DVec3::Y).truncate().normalize();
            let edge = pose.translation.truncate() + out * (lane.width_at(0.0) / 2.0);
            // Heights over the road's smooth surface, which goes on beside it: at the bends of the section, where the
            // ground has its corners. Its triangles are 3.5 m long there, and bumps between them are cut off.
            let smooth = |p: DVec2| ground.height_at(p.x, p.y).unwrap() - roughness.height_m(p);
            let on_road = smooth(edge - out * 0.4);
            for (k, bend_m) in roadside.bends_m().into_iter().enumerate() {
                let p = edge + out * bend_m;
                if (edges.distance_m(p) - bend_m).abs() > 0.05 {
                    continue;
                }
                assert_eq!(ground.kind_at(p.x, p.y), Some(GroundKind::Terrain), "seed {seed}");
                let off = smooth(p) - on_road - roadside.height_m(p, bend_m);
                worst[k] = worst[k].max(off.abs());
            }
            // No step where the asphalt ends.
            let step = smooth(edge + out * 0.06) - smooth(edge - out * 0.06);
            assert!(step.abs() < 0.03, "seed {seed}: a step of {step} m");
        }
        // The crossfall of 2.5 % goes on for 4 m.
        assert!(worst.iter().all(|w| *w < 0.17), "seed {seed}: {worst:?}");
    }
}

#[test]
fn nobody_walks_or_parks_and_land_has_fields_of_all_kinds() {
    let mut crops = Vec::new();
    for seed in 0..6 {
        let (country, Layout { land, .. }) = country(seed);
        assert!(country.walkways.is_empty());
        let spots = crate::parking_spots(&country.network, &country.ground, &StreamKey::scene(seed));
        assert!(spots.is_empty(), "seed {seed}: {} places to park", spots.len());
        let none = [LaneKind::Sidewalk, LaneKind::Parking, LaneKind::Median];
        assert!(country.network.lanes.iter().all(|l| !none.contains(&l.kind)));
        crops.extend(country.ground.fields().iter().map(|(crop, _)| *crop));
        let (edges, reach_m) = (road_edges(&country), land.unwrap().roadside.reach_m());
        for p in country.ground.fields().iter().flat_map(|(_, rings)| rings.iter().flatten()) {
            let off_m = edges.distance_m(*p);
            assert!(off_m > reach_m + 0.9, "seed {seed}: a field {off_m} m from the asphalt, ditch to {reach_m}");
        }
    }
    for crop in Crop::VARIANTS {
        assert!(crops.iter().filter(|c| *c == crop).count() >= 8, "{crop:?}");
    }
}

#[test]
fn the_land_ends_at_hills_all_round() {
    let (country, _) = country(2);
    let hills = horizon::hills(&StreamKey::scene(2), &country.ground);
    let (min, max) = extent(&country.network);
    let corners: Vec<DVec3> = hills.shape.levels[0].1.places().map(|p| p.as_dvec3()).collect();
    let is_edge = |p: &DVec3| p.x <= min.x + 0.01 || p.y <= min.y + 0.01 || p.x >= max.x - 0.01 || p.y >= max.y - 0.01;
    let mut edges = 0;
    for p in country.ground.vertices.iter().map(|p| p.as_dvec3()).filter(is_edge) {
        let near = || corners.iter().filter(|c| (c.truncate() - p.truncate()).length() < 9.0);
        let (low, high) = near().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), c| (lo.min(c.z), hi.max(c.z)));
        assert!(low < p.z && high > p.z + 5.0, "{p}: hills from {low} to {high}");
        edges += 1;
    }
    assert!(edges > 100);
}

#[test]
fn barriers_part_a_motorway_without_a_gap_and_nothing_hangs_low_over_its_lanes() {
    for seed in 0..4 {
        let (motorway, Layout { standing, .. }) = motorway(seed);
        let kinds = ["concrete-barrier", "double-rail", "motorway-rail"];
        let barriers: Vec<DVec2> =
            standing.iter().filter(|s| kinds.iter().any(|k| s.name.starts_with(k))).map(|s| s.rect.center).collect();
        for lane in motorway.network.of_kind(LaneKind::Median) {
            for p in lane.center.iter().step_by(4) {
                let near = barriers.iter().map(|b| (*b - p.truncate()).length()).fold(f64::INFINITY, f64::min);
                assert!(near < 7.0, "seed {seed}: {near} m from {p}");
            }
        }
        // Bridges and gantries: over every lane what hangs is 4.5 m up (RAA).
        for instance in things(&motorway).iter().filter(|i| !i.palette.has_vegetation()) {
            let mesh = &instance.shape.levels[0].1;
            for corner in mesh.places() {
                let p = instance.world_from_local.transform_point(corner.as_dvec3());
                let Some(z) = motorway.ground.height_at(p.x, p.y) else { continue };
                if p.z - z < 0.3 || p.z - z > 4.5 || motorway.ground.kind_at(p.x, p.y) != Some(GroundKind::Road) {
                    continue;
                }
                let over = motorway.network.driving().find(|l| {
                    let (s_m, off_m) = l.project(p);
                    off_m < l.width_at(s_m) / 2.0
                });
                assert!(over.is_none(), "seed {seed}: something {} m over a lane at {p}", p.z - z);
            }
        }
    }
}
