//! Things are solid, stand on the ground, and keep within what they say they cover.

use std::collections::BTreeMap;

use super::super::{OVERHEAD_M, SceneryModel, thing};
use super::*;
use crate::material::Pattern;
use crate::math::Vec3;

fn every_thing() -> impl Iterator<Item = (ThingKind, SceneryModel)> {
    ThingKind::ALL.into_iter().flat_map(|kind| (0..THING_VARIANTS).map(move |k| (kind, thing(kind, k))))
}

/// By how many edges a mesh without its panes and leaves is open, and what it encloses.
fn holes(model: &SceneryModel, mesh: &Mesh) -> (usize, f32) {
    let is_solid = |slot: u8| {
        let m = &model.palette.materials()[usize::from(slot)];
        m.transmission == 0.0 && m.pattern != Pattern::Leaves
    };
    let place = |i: u32| {
        let p = mesh.vertices[i as usize];
        [p.x, p.y, p.z].map(|c| (c * 2e4).round() as i64)
    };
    let mut passed: BTreeMap<([i64; 3], [i64; 3]), i32> = BTreeMap::new();
    let mut volume = 0.0;
    for (face, _) in mesh.faces.iter().zip(&mesh.slots).filter(|(_, slot)| is_solid(**slot)) {
        let [a, b, c] = face.map(|i| mesh.vertices[i as usize]);
        volume += a.dot(b.cross(c)) / 6.0;
        for k in 0..3 {
            let (p, q) = (place(face[k]), place(face[(k + 1) % 3]));
            *passed.entry((p.min(q), p.max(q))).or_default() += if p < q { 1 } else { -1 };
        }
    }
    (passed.values().filter(|n| **n != 0).count(), volume)
}

#[test]
fn things_are_closed_and_turned_outwards_at_every_level() {
    for (kind, model) in every_thing() {
        for (_, mesh) in &model.shape.levels {
            let (open, volume) = holes(&model, mesh);
            if matches!(kind, ThingKind::ClippedBush | ThingKind::ShrubBed) {
                continue; // Nothing but leaves.
            }
            assert!(open == 0 && volume > 1e-4, "{}: {open} open edges, {volume} m3", model.name);
        }
    }
}

/// Each solid alone: a box that is turned inside out takes from the volume of the others.
#[test]
fn every_solid_of_a_thing_is_turned_outwards() {
    for (_, model) in every_thing() {
        for (_, mesh) in &model.shape.levels {
            let mut surface: Vec<usize> = (0..mesh.vertices.len()).collect();
            fn root(surface: &mut [usize], mut i: usize) -> usize {
                while surface[i] != i {
                    surface[i] = surface[surface[i]];
                    i = surface[i];
                }
                i
            }
            let mut at: BTreeMap<[i64; 3], usize> = BTreeMap::new();
            for (i, p) in mesh.vertices.iter().enumerate() {
                let first = *at.entry([p.x, p.y, p.z].map(|c| (c * 2e4).round() as i64)).or_insert(i);
                let (a, b) = (root(&mut surface, i), root(&mut surface, first));
                surface[a] = b;
            }
            for face in &mesh.faces {
                for k in [1, 2] {
                    let (a, b) = (root(&mut surface, face[0] as usize), root(&mut surface, face[k] as usize));
                    surface[a] = b;
                }
            }
            let mut volumes: BTreeMap<usize, f32> = BTreeMap::new();
            for (face, slot) in mesh.faces.iter().zip(&mesh.slots) {
                let m = &model.palette.materials()[usize::from(*slot)];
                if m.transmission > 0.0 || m.pattern == Pattern::Leaves {
                    continue;
                }
                let origin = mesh.vertices[root(&mut surface, face[0] as usize)];
                let [a, b, c] = face.map(|i| mesh.vertices[i as usize] - origin);
                *volumes.entry(root(&mut surface, face[0] as usize)).or_default() += a.dot(b.cross(c)) / 6.0;
            }
            assert!(volumes.values().all(|v| *v > 0.0), "{}: {volumes:?}", model.name);
        }
    }
}

#[test]
fn things_stand_on_the_ground_within_their_footprint_at_every_level() {
    for (kind, model) in every_thing() {
        let size = model.footprint_size();
        assert!(size.min_element() > 0.01 && size.max_element() < 7.0, "{}: {size}", model.name);
        for (_, mesh) in &model.shape.levels {
            let name = &model.name;
            assert!(mesh.vertices.iter().all(|p| p.is_finite()), "{name}");
            assert!(mesh.bounds.min.z < 0.04, "{name} floats at {}", mesh.bounds.min.z);
            // Far leaves are large.
            let slack =
                if matches!(kind, ThingKind::ClippedBush | ThingKind::ShrubBed | ThingKind::Tub) { 0.3 } else { 0.04 };
            let top = f64::from(mesh.bounds.max.z);
            assert!((top - model.height_m).abs() < slack + 0.21, "{name}: {top} of {}", model.height_m);
            for p in mesh.vertices.iter().filter(|p| f64::from(p.z) < OVERHEAD_M) {
                let at = p.truncate().as_dvec2();
                let over = (at - model.footprint_max).max(model.footprint_min - at).max_element();
                assert!(over < slack, "{name}: {p} of {} to {}", model.footprint_min, model.footprint_max);
            }
        }
        let faces: Vec<usize> = model.shape.levels.iter().map(|l| l.1.faces.len()).collect();
        assert!(faces.windows(2).all(|f| f[1] <= f[0]) && faces[2] <= 400, "{}: {faces:?}", model.name);
    }
}

#[test]
fn covered_cars_are_of_a_cars_size() {
    for k in 0..THING_VARIANTS {
        let model = thing(ThingKind::CoveredCar, k);
        let size: Vec3 = model.shape.bounds.size();
        assert!((3.3..5.0).contains(&size.x) && (1.5..2.0).contains(&size.y) && (1.3..2.0).contains(&size.z), "{size}");
    }
}
