//! Lots: nothing on them overlaps, floats, or stands on a street, and their bays are free.

use crate::lots::*;
use crate::testing::town;
use crate::{GroundKind, Layout, SpotKind, SuburbConfig, Town};
use cadet_base::material::{Pattern, Semantic};
use cadet_base::plane::OrientedRect;

/// Of car parks, works, and institutes.
fn built(seed: u64, place: usize) -> (Town, Layout) {
    let blocks = SuburbConfig { blocks: (2, 2), block_m: (100.0, 150.0), ..Default::default() };
    let usual = PropConfig::default();
    let (suburb, props) = match place {
        0 => (SuburbConfig { aisle_share: 0.7, ..blocks }, PropConfig { car_park_share: 1.0, ..usual }),
        1 => (SuburbConfig { industrial_share: 1.0, ..blocks }, PropConfig { industrial_share: 1.0, ..usual }),
        _ => (SuburbConfig { campus_share: 1.0, ..blocks }, PropConfig { campus_share: 1.0, ..usual }),
    };
    town(seed, &suburb, &props)
}

#[test]
fn bays_are_paved_level_and_free_of_everything() {
    for (seed, place) in (0..10).flat_map(|seed| [(seed, 0), (seed, 1)]) {
        let (Town { ground, .. }, Layout { lots, standing, .. }) = built(seed, place);
        let spots = lots.parking(&ground);
        assert!(spots.len() > 30, "{place}, seed {seed}: {} bays", spots.len());
        let rects: Vec<OrientedRect> = spots.iter().map(ParkingSpot::rect).collect();
        for (i, (rect, spot)) in rects.iter().zip(&spots).enumerate() {
            let name = format!("{place}, seed {seed}: the bay at {}", rect.center);
            let near = |o: &OrientedRect| (o.center - rect.center).length() < 45.0;
            assert!(rects[..i].iter().filter(|o| near(o)).all(|o| !o.overlaps(rect)), "{name} overlaps another");
            let found = standing.iter().find(|s| near(&s.rect) && s.rect.overlaps(rect));
            assert!(found.is_none(), "{name}: {found:?}");
            assert!(rect.samples(0.8).all(|p| ground.kind_at(p.x, p.y) == Some(GroundKind::Terrain)), "{name}: street");
            for corner in rect.corners() {
                let z = ground.height_at(corner.x, corner.y).unwrap();
                let local = spot.world_from_spot.inverse().transform_point(corner.extend(z));
                assert!(local.z.abs() < 0.12, "{name}: a corner is {} m off", local.z);
            }
        }
    }
}

#[test]
fn buildings_and_furniture_keep_apart_and_off_streets() {
    for (seed, place) in (0..10).flat_map(|seed| [(seed, 0), (seed, 1), (seed, 2)]) {
        let (Town { ground, .. }, Layout { lots, standing, .. }) = built(seed, place);
        assert!(lots.lots.len() > 3, "{place}, seed {seed}: {} lots", lots.lots.len());
        let names: Vec<&str> =
            lots.lots.iter().flat_map(|l| &l.layout.items).map(|i| i.drawn.model.name.as_str()).collect();
        let of_lots: Vec<_> = standing.iter().filter(|s| names.contains(&s.name.as_str())).collect();
        let is_hall = |name: &str| ["market", "works", "office", "institute"].iter().any(|k| name.starts_with(k));
        assert!(of_lots.iter().any(|s| is_hall(&s.name)), "{place}, seed {seed}: no building");
        for (i, a) in of_lots.iter().enumerate() {
            let is_on_street = |p: DVec2| ground.kind_at(p.x, p.y) != Some(GroundKind::Terrain);
            assert!(!is_hall(&a.name) || !a.rect.samples(1.0).any(is_on_street), "{place}, seed {seed}: {a:?}");
            for b in &of_lots[..i] {
                let is_far = (a.rect.center - b.rect.center).length() > 90.0;
                assert!(is_far || !a.rect.overlaps(&b.rect), "{place}, seed {seed}: {a:?} and {b:?}");
            }
        }
    }
}

#[test]
fn walls_of_halls_reach_into_the_ground_all_round() {
    for (seed, place) in (0..6).flat_map(|seed| [(seed, 0), (seed, 1), (seed, 2)]) {
        let (Town { ground, scenery, .. }, _) = built(seed, place);
        let halls = scenery[ground.tiles.len()..]
            .iter()
            .filter(|i| i.shape.bounds.min.z < -1.5 && i.shape.bounds.size().y > 12.0);
        for hall in halls {
            let (min, max) = (hall.shape.bounds.min.as_dvec3(), hall.shape.bounds.max.as_dvec3());
            for (x, y) in [(min.x, min.y), (min.x, max.y), (max.x, min.y), (max.x, max.y)] {
                let foot = hall.world_from_local.transform_point(DVec3::new(x, y, min.z));
                let z = ground.height_at(foot.x, foot.y).unwrap();
                assert!(z > foot.z, "{place}, seed {seed}: a wall ends {} m above the ground", foot.z - z);
            }
        }
    }
}

#[test]
fn yards_are_where_they_were_planned_and_lines_lie_on_them() {
    for (seed, place) in [(0, 0), (1, 1), (2, 2)] {
        let (Town { network, ground, .. }, Layout { lots, .. }) = built(seed, place);
        let site = Site::new(&ground);
        let yard = |p: DVec2| {
            ground.tiles.iter().any(|tile| {
                let local = p - tile.world_from_local.translation.truncate();
                tile.shape.levels[0].1.triangles().any(|(corners, slot)| {
                    let m = &tile.palette.materials()[usize::from(slot)];
                    let [a, b, c] = corners.map(|p| p.truncate().as_dvec2());
                    let side = |u: DVec2, v: DVec2| (v - u).perp_dot(local - u) >= 0.0;
                    m.semantic == Semantic::Road
                        && m.pattern != Pattern::Plain
                        && side(a, b)
                        && side(b, c)
                        && side(c, a)
                })
            })
        };
        for lot in lots.lots.iter().take(4) {
            for (_, [a0, a1, d0, d1]) in &lot.layout.paved {
                let middle = lot.at(DVec2::new((a0 + a1) / 2.0, d0.max(1.0).midpoint(*d1)));
                assert!(site.is_street(middle) || yard(middle), "{place}, seed {seed}: no yard at {middle}");
            }
        }
        // The ground still follows the lanes.
        for p in network.driving().flat_map(|l| l.center.iter().step_by(7)) {
            assert!((ground.height_at(p.x, p.y).unwrap() - p.z).abs() < 0.1, "{place}, seed {seed}: at {p}");
        }
    }
}

#[test]
fn there_are_yards_for_trucks_and_seats_on_campuses() {
    let spots = (0..4).flat_map(|seed| built(seed, 1).0.parking);
    let yards = spots.filter(|s| s.kind == SpotKind::Yard).count();
    assert!(yards > 8, "{yards}");
    let seats: usize = (0..4).map(|seed| built(seed, 2).0.seats.len()).sum();
    assert!(seats > 20, "{seats}");
}
