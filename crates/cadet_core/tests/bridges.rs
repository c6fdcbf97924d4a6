//! Roads that pass over others: two surfaces, one above the other.

#![allow(clippy::unwrap_used)]

use cadet_core::math::{DVec2, DVec3};
use cadet_core::rng::StreamKey;
use cadet_core::town::{GroundKind, PropConfig, RoadNetwork, Town, load_map_with_warnings};

/// A straight road of two lanes and sidewalks, 400 m long, with its middle at the origin, along x or y: on the level, or up
/// to a height by ramps of 5 %, from 150 m before its middle on.
fn road(id: u32, is_along_y: bool, height_m: f64, has_ramps: bool) -> String {
    let place = if is_along_y { "x='0' y='-200' hdg='1.5707963267948966'" } else { "x='-200' y='0' hdg='0'" };
    let ramp_m = height_m / 0.05;
    let elevation = if has_ramps {
        let end_m = 350.0;
        format!(
            "<elevation s='0' a='0' b='0' c='0' d='0'/><elevation s='{}' a='0' b='0.05' c='0' d='0'/>\
             <elevation s='{}' a='{height_m}' b='0' c='0' d='0'/>\
             <elevation s='{}' a='{height_m}' b='-0.05' c='0' d='0'/>\
             <elevation s='{end_m}' a='0' b='0' c='0' d='0'/>",
            400.0 - end_m,
            400.0 - end_m + ramp_m,
            end_m - ramp_m,
        )
    } else {
        format!("<elevation s='0' a='{height_m}' b='0' c='0' d='0'/>")
    };
    let side = |sign: &str| {
        let lane = |id: u32, kind: &str, width_m: f64| {
            format!("<lane id='{sign}{id}' type='{kind}'><width sOffset='0' a='{width_m}' b='0' c='0' d='0'/></lane>")
        };
        lane(1, "driving", 3.5) + &lane(2, "sidewalk", 2.0)
    };
    format!(
        "<road name='' length='400' id='{id}' junction='-1'><planView><geometry s='0' {place} length='400'><line/>\
         </geometry></planView><elevationProfile>{elevation}</elevationProfile><lanes><laneSection s='0'>\
         <left>{}</left><center><lane id='0' type='none'/></center><right>{}</right></laneSection></lanes></road>",
        side(""),
        side("-")
    )
}

fn map(roads: &[String]) -> String {
    format!("<OpenDRIVE><header revMajor='1' revMinor='4'/>{}</OpenDRIVE>", roads.concat())
}

/// A road on the level, and one that leads over it.
fn towns() -> [(&'static str, f64, Town); 2] {
    [("on the level", 10.0, false), ("on ramps", 6.0, true)].map(|(name, height_m, has_ramps)| {
        let text = map(&[road(1, false, 0.0, false), road(2, true, height_m, has_ramps)]);
        let town = Town::from_opendrive(&StreamKey::scene(1), name, &text, &PropConfig::default()).unwrap();
        assert!(town.map_warnings.is_empty(), "{name}: {:?}", town.map_warnings);
        (name, height_m, town)
    })
}

/// Bumps and dips, and what the ground swings beside an abutment.
const OFF_M: f64 = 0.12;

#[test]
fn each_road_has_a_surface_of_its_own_without_steps() {
    for (name, _, town) in towns() {
        for lane in town.network.driving() {
            for aside in [-0.45, 0.0, 0.45] {
                let mut before: Option<f64> = None;
                for k in 4..(lane.length_m() * 4.0) as usize - 4 {
                    let pose = lane.pose_at(k as f64 / 4.0);
                    let p = pose.transform_point(DVec3::Y * (aside * lane.width_at(k as f64 / 4.0)));
                    let (z, kind) = town.ground.surface_near(p).unwrap();
                    assert_eq!(kind, GroundKind::Road, "{name}: {p}");
                    assert!((z - p.z).abs() < OFF_M, "{name}: {z} at {p}");
                    let rises_m = pose.rotation.mul_vec3(DVec3::X).z.abs() / 4.0;
                    assert!(before.is_none_or(|b| (z - b).abs() < rises_m + 0.035), "{name}: {before:?} {z} at {p}");
                    before = Some(z);
                }
            }
        }
    }
}

#[test]
fn casting_down_on_a_bridge_meets_two_surfaces_and_below_it_is_room_for_a_truck() {
    for (name, height_m, town) in towns() {
        let at = |z: f64| town.ground.surface_near(DVec3::new(1.0, 1.0, z)).unwrap().0;
        assert!((at(height_m) - height_m).abs() < OFF_M && at(0.0).abs() < OFF_M, "{name}");
        assert!(town.ground.height_at(1.0, 1.0).unwrap().abs() < OFF_M, "{name}: the ground is the lower one");
        // Nothing of what is seen comes into the lanes below, or above them lower than 4 m.
        let mut above_m = f64::INFINITY;
        for instance in &town.scenery {
            let mesh = instance.shape.levels[0].1.clone();
            for (corners, _) in mesh.triangles() {
                let corners = corners.map(|p| instance.world_from_local.transform_point(p.as_dvec3()));
                let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
                let is_below_deck = corners.iter().any(|p| p.y.abs() < 3.2 && p.x.abs() < 5.0);
                if is_below_deck && middle.z > 0.3 {
                    above_m = above_m.min(corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min));
                }
            }
        }
        assert!(above_m > 4.0 && above_m < height_m, "{name}: {above_m}");
    }
}

#[test]
fn people_walk_over_the_bridge_and_under_it() {
    for (name, height_m, town) in towns() {
        let near_middle = |z: f64| {
            let is_there = |p: &&DVec3| p.truncate().length() < 9.0 && (p.z - z).abs() < 0.4;
            town.walkways.iter().flat_map(|w| &w.center).filter(is_there).count()
        };
        let counts = [near_middle(0.12), near_middle(height_m + 0.12)];
        let ends: Vec<_> =
            town.walkways.iter().map(|w| (w.center[0], w.center[w.center.len() - 1], w.center.len())).collect();
        assert!(counts.iter().all(|n| *n >= 12), "{name}: {counts:?} {ends:?}");
        for walkway in &town.walkways {
            for pair in walkway.center.windows(2) {
                let climbs = (pair[1] - pair[0]).z.abs() / (pair[1] - pair[0]).truncate().length();
                assert!(climbs < 0.2, "{name}: {pair:?}");
            }
        }
    }
}

#[test]
fn nothing_stands_under_a_bridge_or_on_it() {
    for (name, _, town) in towns() {
        let deck_reach = |p: DVec2| p.x.abs() < 7.0 && p.y.abs() < 12.0;
        let stands = town.obstacles.iter().filter(|o| deck_reach(o.center)).count();
        assert_eq!(stands, 0, "{name}");
        assert!(town.parking.iter().all(|s| !deck_reach(s.world_from_spot.translation.truncate())), "{name}");
    }
}

#[test]
fn roads_that_no_bridge_can_part_are_named() {
    let warnings = |roads: &[String]| load_map_with_warnings("map", &map(roads)).unwrap().1;
    let low = warnings(&[road(1, false, 0.0, false), road(2, true, 2.0, false)]);
    assert!(low.len() == 1 && low[0].contains("cross at heights 2 and 0 m") && low[0].contains("3.5 m"), "{low:?}");
    assert!(warnings(&[road(1, false, 0.0, false), road(2, true, 1.0, false)]).is_empty());
    assert!(warnings(&[road(1, false, 0.0, false), road(2, true, 5.0, false)]).is_empty());
}

#[test]
fn a_network_without_crossings_has_one_surface() {
    let text = map(&[road(1, false, 0.0, false)]);
    let network: RoadNetwork = load_map_with_warnings("map", &text).unwrap().0;
    let ground = cadet_core::town::Ground::new(&network).unwrap();
    for p in network.lanes.iter().flat_map(|l| &l.center) {
        let above = ground.surface_near(*p + DVec3::Z * 9.0).map(|(z, _)| z);
        assert_eq!(above, ground.height_at(p.x, p.y), "{p}");
    }
}
