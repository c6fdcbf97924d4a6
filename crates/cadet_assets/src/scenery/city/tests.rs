//! Properties of houses of closed rows, checked with plain ray casts.

use strum::VariantArray;

use super::super::materials::house_slot;
use super::super::tests::check_closed;
use super::super::{House, HouseKind, city_house, house, num_variants};
use super::*;
use crate::rays::hits;

fn every_house() -> impl Iterator<Item = (CityKind, House)> {
    let houses = |&kind: &CityKind| (0..NUM_CITY_HOUSES[kind as usize]).map(move |k| (kind, city_house(kind, k)));
    CityKind::VARIANTS.iter().flat_map(houses)
}

#[test]
fn walls_and_roofs_are_closed_from_every_side() {
    check_closed("closed city", every_house().map(|(_, house)| house.model), 400, 0.9);
}

#[test]
fn heights_and_sizes_are_those_of_an_inner_city() {
    for (_, House { model, .. }) in every_house() {
        let size = model.footprint_size();
        // Of closed rows: 12 to 14 m deep, fronts of 12 to 20 m (narrower ones fill gaps), eaves at 10 to 17 m.
        assert!((12.0..=14.0).contains(&size.x) && (6.0..=20.0).contains(&size.y), "{}: {size}", model.name);
        assert!((13.0..=27.0).contains(&model.height_m), "{}: {} m", model.name, model.height_m);
    }
}

#[test]
fn shops_are_looked_into_and_beams_go_on_behind_their_glass() {
    let mut num_deep = 0;
    for (_, House { model, .. }) in every_house() {
        let mesh: &Mesh = &model.shape.levels[0].1;
        let glass = &model.palette.materials()[usize::from(house_slot::GLASS)].lidar;
        assert!((0.3..0.9).contains(&glass.transmission), "{}", glass.transmission);
        let front = model.footprint_max.x as f32;
        let mut y = -model.footprint_max.y as f32 + 0.5;
        while f64::from(y) < model.footprint_max.y - 0.5 {
            // At the eyes' height of somebody on the sidewalk.
            let seen = hits(mesh, Vec3::new(front + 3.0, y, 1.6), -Vec3::X, |_| true);
            y += 0.37;
            let Some(near) = seen.first() else { panic!("{}: a hole at {y}", model.name) };
            if near.slot != house_slot::GLASS {
                continue;
            }
            let behind = seen.iter().find(|hit| hit.slot != house_slot::GLASS);
            let far = behind.unwrap_or_else(|| panic!("{}: nothing behind glass at {y}", model.name));
            let deep_m = far.range_m - near.range_m;
            assert!(deep_m > 0.04 && deep_m < 4.5, "{}: {seen:?}", model.name);
            num_deep += usize::from(deep_m > 1.5 && far.slot == city_slot::INSIDE);
        }
    }
    // Most panes show the room behind the goods: no wall stands directly behind the glass.
    assert!(num_deep > 40, "{num_deep}");
}

#[test]
fn every_house_between_others_has_a_door_at_the_height_of_the_sidewalk() {
    for (kind, house) in every_house() {
        let (model, doorways) = (&house.model, house.doorways_m());
        if kind == CityKind::Row {
            assert!(!doorways.is_empty(), "{}", model.name);
        }
        let mesh: &Mesh = &model.shape.levels[0].1;
        for [y0, y1] in doorways {
            let door = (y0 + y1) / 2.0;
            // Somebody who walks in at the door meets nothing in front of the wall.
            let front = model.footprint_max.x as f32;
            let first = hits(mesh, Vec3::new(front + 2.0, door as f32, 1.2), -Vec3::X, |_| true)[0].range_m;
            assert!(first > 1.99, "{}: something {first} m before the door at {door}", model.name);
        }
    }
}

#[test]
fn doorways_are_where_doors_are_drawn_at_the_front() {
    let rows = every_house().map(|(_, house)| house);
    let [variants, ..] = num_variants();
    let in_gardens = HouseKind::VARIANTS.iter().flat_map(|&k| (0..variants).map(move |v| house(k, v)));
    for house in rows.chain(in_gardens) {
        let (model, doorways) = (&house.model, house.doorways_m());
        let mesh: &Mesh = &model.shape.levels[0].1;
        let doors = mesh.triangles().filter(|(_, slot)| *slot == house_slot::DOOR);
        let corners = doors.flat_map(|(corners, _)| corners.map(|p| p.as_dvec3()));
        let at_front = corners.filter(|p| p.x > model.footprint_max.x - 0.6);
        // The wall of a cut corner begins beside the front, and its niches reach a little over that end.
        let is_front = |y: f64| house.corner().is_none_or(|c| y * c.side < model.footprint_max.y - c.cut_m - 0.05);
        let drawn: Vec<f64> = at_front.map(|p| p.y).filter(|y| is_front(*y)).collect();
        let is_in = |y: f64, [y0, y1]: [f64; 2]| (y0 - 1e-4..y1 + 1e-4).contains(&y);
        for y in &drawn {
            assert!(doorways.iter().any(|d| is_in(*y, *d)), "{}: a door at {y} out of {doorways:?}", model.name);
        }
        for doorway in &doorways {
            assert!(drawn.iter().any(|y| is_in(*y, *doorway)), "{}: no door in {doorway:?}", model.name);
        }
    }
}
