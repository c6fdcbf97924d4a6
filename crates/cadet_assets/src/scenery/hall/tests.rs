//! Large buildings are closed, of their size, and open at their gates.

use strum::VariantArray;

use super::super::materials::house_slot as slot;
use super::super::{SceneryModel, hall};
use super::*;
use crate::rays::hits;
use cadet_base::math::{Vec3, cosf, sinf};

fn every_hall() -> impl Iterator<Item = (HallKind, SceneryModel)> {
    HallKind::VARIANTS.iter().flat_map(|&kind| (0..HALL_VARIANTS).map(move |k| (kind, hall(kind, k))))
}

#[test]
fn walls_and_roofs_are_closed_from_every_side() {
    let mut s = Stream::from_seed("closed halls", 0);
    let (mut num_rays, mut num_backs) = (0, 0);
    for (kind, model) in every_hall() {
        let half = (model.footprint_size() / 2.0).as_vec2();
        for (k, (_, mesh)) in model.shape.levels.iter().enumerate() {
            for _ in 0..80 {
                let target = Vec3::new(range(&mut s, -0.3, 0.3) * half.x, range(&mut s, -0.3, 0.3) * half.y, 0.0)
                    + Vec3::Z * range(&mut s, 0.3, model.height_m as f32 * 0.85);
                let angle = range(&mut s, 0.0, std::f32::consts::TAU);
                let from = target + Vec3::new(cosf(angle), sinf(angle), range(&mut s, -0.01, 0.8)) * 90.0;
                let first = hits(mesh, from, (target - from).normalize(), |_| true).first().copied();
                let faces_us = first.unwrap_or_else(|| panic!("{kind:?} level {k}: open from {from}")).is_outside;
                (num_rays, num_backs) = (num_rays + 1, num_backs + usize::from(!faces_us));
            }
        }
    }
    assert!(500 * num_backs <= num_rays, "{num_backs} of {num_rays} rays meet the back of a face first");
}

#[test]
fn halls_are_of_the_sizes_of_halls_and_stand_in_the_ground() {
    for (kind, model) in every_hall() {
        let (size, height_m) = (model.footprint_size(), model.height_m);
        let (least, most, heights) = match kind {
            HallKind::Market => ((17.0, 22.0), (30.0, 44.0), 5.0..7.5),
            HallKind::Works => ((15.0, 20.0), (40.0, 60.0), 6.0..14.0),
            HallKind::Office => ((10.0, 14.0), (15.0, 34.0), 6.5..14.5),
            HallKind::Institute => ((12.0, 20.0), (16.0, 52.0), 11.0..20.0),
        };
        let name = &model.name;
        assert!(size.x >= least.0 && size.y >= least.1 && size.x <= most.0 && size.y <= most.1, "{name}: {size}");
        assert!(heights.contains(&height_m), "{name}: {height_m} m");
        for (_, mesh) in &model.shape.levels {
            assert!(mesh.bounds.min.z < -1.0, "{name} floats at {}", mesh.bounds.min.z);
        }
        let faces: Vec<usize> = model.shape.levels.iter().map(|l| l.1.num_faces()).collect();
        assert!(faces.windows(2).all(|f| f[1] <= f[0]) && faces[0] < 14_000, "{name}: {faces:?}");
    }
}

#[test]
fn works_have_gates_and_markets_an_entrance_of_glass() {
    let count = |kind: HallKind, slots: [u8; 2]| {
        let of_kind = every_hall().filter(|(k, _)| *k == kind);
        of_kind.filter(|(_, model)| model.shape.levels[0].1.slots().any(|s| slots.contains(&s))).count()
    };
    assert_eq!(count(HallKind::Works, [slot::DOOR; 2]), HALL_VARIANTS);
    assert_eq!(count(HallKind::Market, [slot::GLASS; 2]), HALL_VARIANTS);
    assert_eq!(count(HallKind::Institute, [slot::GLASS, slot::DARK_GLASS]), HALL_VARIANTS);
}
