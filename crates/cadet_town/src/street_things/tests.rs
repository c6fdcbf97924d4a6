//! Things stand apart, off the lanes, before no door, and people get past.

use crate::ground::GroundKind;
use crate::placement::{PropFootprint, Site};
use crate::plots::frontages;
use crate::roadside::walkways;
use crate::street_things::*;
use crate::testing::town;
use crate::{SuburbConfig, Town};
use cadet_assets::props::{OwnProps, Prop, shipped};
use cadet_base::plane::OrientedRect;

const SEEDS: [u64; 4] = [1, 2, 3, 4];

fn placed(seed: u64, clutter: f64) -> (Town, Vec<PropFootprint>) {
    with_props(seed, &PropConfig { clutter, ..Default::default() })
}

fn with_props(seed: u64, config: &PropConfig) -> (Town, Vec<PropFootprint>) {
    let main_share = if seed.is_multiple_of(2) { 1.0 } else { 0.0 };
    let (town, layout) = town(seed, &SuburbConfig { blocks: (3, 3), main_share, ..Default::default() }, config);
    (town, layout.standing)
}

/// The prop's name, if it is placed by a rule of its file, or among the things that stand together.
pub(crate) fn kind_of(name: &str) -> Option<&str> {
    const TOGETHER: [&str; 14] = [
        "large-container",
        "glass-bank",
        "clothes-bank",
        "transformer",
        "cycle-hoop",
        "bus-shelter",
        "billboard",
        "barrier",
        "mound",
        "tall-plant",
        "carport",
        "cafe-table",
        "cafe-chair",
        "parasol",
    ];
    let kind = name.split('/').next()?;
    let has_rule = |prop: &Arc<Prop>| prop.name() == kind && kind != "bench" && !prop.places().is_empty();
    (TOGETHER.contains(&kind) || shipped().iter().any(has_rule)).then_some(kind)
}

#[test]
fn things_overlap_nothing_and_keep_off_lanes() {
    for seed in SEEDS {
        let (Town { network, ground, parking, .. }, standing) = placed(seed, 1.5);
        let things: Vec<_> = standing.iter().filter(|s| kind_of(&s.name).is_some()).collect();
        assert!(things.len() > 100, "seed {seed}: {}", things.len());
        let bays: Vec<OrientedRect> = parking.iter().map(|spot| spot.rect().grown(0.12)).collect();
        for thing in &things {
            let is_parked = |p: DVec2| bays.iter().any(|bay| bay.contains(p, 0.0));
            for p in thing.rect.samples(0.3) {
                let is_road = ground.kind_at(p.x, p.y) == Some(GroundKind::Road);
                assert!(!is_road || is_parked(p), "seed {seed}: {thing:?} at {p} on the road");
            }
            for lane in network.driving() {
                let near = lane.center.iter().map(|p| p.truncate()).filter(|p| (*p - thing.rect.center).length() < 5.0);
                for p in near {
                    assert!(!thing.rect.contains(p, 1.2), "seed {seed}: {thing:?} in a lane at {p}");
                }
            }
        }
        let solid = |s: &&PropFootprint| s.rect.half.x > 0.01;
        for (i, a) in standing.iter().enumerate().filter(|(_, s)| kind_of(&s.name).is_some()) {
            for (j, b) in standing.iter().enumerate().filter(|(_, s)| solid(s)) {
                let is_far = (a.rect.center - b.rect.center).length() > 16.0;
                assert!(i == j || is_far || !a.rect.overlaps(&b.rect), "seed {seed}: {a:?} and {b:?}");
            }
        }
    }
}

#[test]
fn people_get_past_what_stands_on_sidewalks() {
    for seed in SEEDS {
        let (Town { ground, obstacles, .. }, _) = placed(seed, 1.5);
        assert!(obstacles.len() > 20, "seed {seed}: {}", obstacles.len());
        for walkway in walkways(&ground) {
            let room_m = walkway.width_m / 2.0 - 0.1;
            for pair in walkway.center.windows(2) {
                let (p, along) = (pair[0].truncate(), (pair[1] - pair[0]).truncate().normalize_or(DVec2::X));
                let near: Vec<_> = obstacles.iter().filter(|o| (o.center - p).length() < 6.0).copied().collect();
                // Some line of those that people walk along keeps half a person's width from everything.
                let is_free = |lateral: f64| {
                    let at = p + along.perp() * lateral;
                    near.iter().all(|rect| !rect.contains(at, 0.3))
                };
                let lines = (0..=16).map(|k| room_m * (f64::from(k) / 8.0 - 1.0));
                assert!(
                    lines.into_iter().any(is_free),
                    "seed {seed}: no way past at {p}, {room_m} m of room: {near:?}"
                );
            }
        }
    }
}

#[test]
fn no_thing_stands_before_a_door() {
    for seed in SEEDS {
        let key = StreamKey::scene(seed);
        let (Town { network, ground, .. }, standing) = placed(seed, 1.5);
        let site = Site::new(&ground);
        // The plots as they were laid out: independent of what the furnisher remembers of ways.
        let mut taken = Occupancy::default();
        for (i, frontage) in frontages(&network, &site).iter().enumerate() {
            let style = StreetStyle::of(&key, frontage, &PropConfig::default());
            let mut s = key.indexed("plots", i as u64);
            for plot in crate::plots::lay_out(frontage, &style, &site, &mut taken, &mut s) {
                let Some(house) = &plot.house else { continue };
                let wall = plot.at(house.along_m, house.setback_m);
                for [y0, y1] in house.house.doorways_m() {
                    // A meter before the door; the house looks against the plot's outward way.
                    let before = wall - plot.along * ((y0 + y1) / 2.0) - plot.out() * 1.0;
                    let blocked = standing.iter().find(|s| kind_of(&s.name).is_some() && s.rect.contains(before, 0.4));
                    assert!(blocked.is_none(), "seed {seed}: {blocked:?} before a door at {before}");
                }
            }
        }
    }
}

#[test]
fn there_is_as_much_as_was_asked_for() {
    let count = |seed: u64, clutter: f64| {
        let (_, standing) = placed(seed, clutter);
        standing.iter().filter(|s| kind_of(&s.name).is_some()).count()
    };
    for seed in [1, 2] {
        assert_eq!(count(seed, 0.0), 0);
        let (some, more) = (count(seed, 0.5), count(seed, 1.5));
        assert!(some > 20 && more > 2 * some, "seed {seed}: {some}, {more}");
    }
    // Of every kind there is some in a few suburbs.
    let mut seen: Vec<String> = Vec::new();
    for seed in 0..6 {
        seen.extend(placed(seed, 1.5).1.iter().filter_map(|s| kind_of(&s.name).map(str::to_owned)));
    }
    let names = shipped().iter().map(|prop| prop.name()).filter(|name| kind_of(name).is_some());
    let missing: Vec<&str> = names.filter(|name| !seen.iter().any(|s| s == name) && *name != "carport").collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn without_clutter_all_else_stands_where_it_stood() {
    let ((town, without), (_, with)) = (placed(1, 0.0), placed(1, 1.0));
    assert!(town.obstacles.is_empty() && town.seats.is_empty());
    let houses = |standing: &[PropFootprint]| {
        let big = standing.iter().filter(|s| s.rect.half.x > 2.5 && kind_of(&s.name).is_none());
        big.map(|s| (s.name.clone(), s.rect.center)).collect::<Vec<_>>()
    };
    let kept: Vec<_> = houses(&with);
    assert!(kept.len() > 40 && kept.iter().all(|h| houses(&without).contains(h)));
}

#[test]
fn seats_are_over_the_ground_that_their_furniture_stands_on() {
    for seed in SEEDS {
        let (Town { ground, seats, .. }, _) = placed(seed, 1.5);
        assert!(seats.len() > 4, "seed {seed}: {}", seats.len());
        for seat in &seats {
            let at = seat.world_from_seat.translation;
            let z = ground.height_at(at.x, at.y).unwrap();
            assert!((at.z - z).abs() < 0.1, "seed {seed}: {seat:?} over {z}");
            assert!((0.4..0.5).contains(&seat.height_m));
        }
    }
}

#[test]
fn props_at_sidewalks_look_at_the_street_or_at_the_traffic_beside_them() {
    let sign = |faces: &str| {
        let part = "{ of = \"steel\", box = \"-0.02, 0, -0.1, 0.3, 0, 2\" }";
        let place = format!("where = \"sidewalk\"\nevery_m = 15\nfaces = \"{faces}\"");
        (format!("{faces}-sign.toml"), format!("levels_m = [20, 40, 90]\nparts = [{part}]\n[[place]]\n{place}\n"))
    };
    let own = OwnProps::parse(&[sign("street"), sign("traffic")]).unwrap();
    let (Town { network, ground, .. }, standing) = with_props(1, &PropConfig { own, ..Default::default() });
    let edges = frontages(&network, &Site::new(&ground));
    for (name, facing) in [("street-sign/", DVec2::Y), ("traffic-sign/", -DVec2::X)] {
        let signs: Vec<OrientedRect> = standing.iter().filter(|s| s.name.starts_with(name)).map(|s| s.rect).collect();
        assert!(signs.len() > 10, "{} of {name}", signs.len());
        for rect in signs {
            let beside = |s_m: &(&Frontage, f64)| (s_m.0.at(s_m.1) - rect.center).length();
            let places = edges.iter().flat_map(|e| (0..e.length_m() as usize * 4).map(move |k| (e, k as f64 / 4.0)));
            let (edge, s_m) = places.min_by(|a, b| beside(a).total_cmp(&beside(b))).unwrap();
            // Along the traffic beside it, and to the left of that, where the street is.
            let along = edge.along(s_m);
            let seen = DVec2::new(rect.axis.dot(along), rect.axis.dot(along.perp()));
            assert!((seen - facing).length() < 0.2, "{name}: {seen}");
            // Its back or its side is at the sidewalk's outer edge.
            let reach_m = edge.along(s_m).perp().dot(rect.center - edge.at(s_m));
            let half_m = if facing == DVec2::Y { rect.half.x } else { rect.half.y };
            assert!((reach_m - half_m - 0.06).abs() < 0.03, "{name}: {reach_m}");
        }
    }
}
