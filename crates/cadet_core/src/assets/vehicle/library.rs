//! The designs that traffic is made of: each is made once a process, when it is first asked for, and depends on its
//! class and number only.

use std::sync::{Arc, OnceLock};

use super::VehicleModel;
use crate::actor::ObjectClass;

const CARS: usize = 96;
const VANS: usize = 24;

type Cell = OnceLock<Arc<VehicleModel>>;

static CAR_CELLS: [Cell; CARS] = [const { Cell::new() }; CARS];
static VAN_CELLS: [Cell; VANS] = [const { Cell::new() }; VANS];

fn cells(class: ObjectClass) -> &'static [Cell] {
    match class {
        ObjectClass::Car => &CAR_CELLS,
        _ => &VAN_CELLS,
    }
}

/// How many designs a class has: Car or Van.
#[must_use]
pub fn num_designs(class: ObjectClass) -> usize {
    cells(class).len()
}

/// A design of a Car, or else of a Van: `VehicleModel::generate(class, number)`, shared. Larger numbers wrap.
#[must_use]
pub fn design(class: ObjectClass, number: usize) -> Arc<VehicleModel> {
    let class = if class == ObjectClass::Car { class } else { ObjectClass::Van };
    let cells = cells(class);
    let number = number % cells.len();
    Arc::clone(cells[number].get_or_init(|| Arc::new(VehicleModel::generate(class, number as u64))))
}
