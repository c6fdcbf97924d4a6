//! Large buildings are closed, of their size, and open at their gates.

use strum::VariantArray;

use super::super::materials::house_slot as slot;
use super::super::tests::check_closed;
use super::super::{SceneryModel, hall};
use super::*;

fn every_hall() -> impl Iterator<Item = (HallKind, SceneryModel)> {
    HallKind::VARIANTS.iter().flat_map(|&kind| (0..HALL_VARIANTS).map(move |k| (kind, hall(kind, k))))
}

#[test]
fn walls_and_roofs_are_closed_from_every_side() {
    check_closed("halls", every_hall().map(|(_, model)| model), 400, 0.85);
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
