//! The designs that traffic is made of: each is made once a process, when it is first asked for, and depends on its
//! class and number only. Actors wear them stretched to sizes of their own.

use std::sync::{Arc, OnceLock};

use super::VehicleModel;
use super::dimensions::Dimensions;
use super::work;
use cadet_base::actor::ObjectClass;
use cadet_base::error::Result;
use cadet_base::math::DVec3;
use cadet_base::rng::Stream;

const NUM_CARS: usize = 132;
const NUM_VANS: usize = 64;
const NUM_TRUCKS: usize = 60;
const NUM_MISC: usize = 112;
/// The most that a design is stretched along any axis where there is another choice.
const MOST_STRETCH: f64 = 1.06;

type Cell = OnceLock<Arc<VehicleModel>>;

/// The designs of a class, and the extents of each.
struct Shelf {
    cells: &'static [Cell],
    sizes_lwh: &'static OnceLock<Vec<DVec3>>,
}

static CARS: [Cell; NUM_CARS] = [const { Cell::new() }; NUM_CARS];
static VANS: [Cell; NUM_VANS] = [const { Cell::new() }; NUM_VANS];
static TRUCKS: [Cell; NUM_TRUCKS] = [const { Cell::new() }; NUM_TRUCKS];
static MISC: [Cell; NUM_MISC] = [const { Cell::new() }; NUM_MISC];
static CAR_SIZES: OnceLock<Vec<DVec3>> = OnceLock::new();
static VAN_SIZES: OnceLock<Vec<DVec3>> = OnceLock::new();
static TRUCK_SIZES: OnceLock<Vec<DVec3>> = OnceLock::new();
static MISC_SIZES: OnceLock<Vec<DVec3>> = OnceLock::new();

fn shelf(class: ObjectClass) -> Shelf {
    match class {
        ObjectClass::Car => Shelf { cells: &CARS, sizes_lwh: &CAR_SIZES },
        ObjectClass::Truck => Shelf { cells: &TRUCKS, sizes_lwh: &TRUCK_SIZES },
        ObjectClass::Misc => Shelf { cells: &MISC, sizes_lwh: &MISC_SIZES },
        _ => Shelf { cells: &VANS, sizes_lwh: &VAN_SIZES },
    }
}

/// The extents of the vehicle of a seed.
fn size_of_seed(class: ObjectClass, model_seed: u64) -> Result<DVec3> {
    match class {
        ObjectClass::Truck | ObjectClass::Misc => Ok(work::size_of_seed(class, model_seed)),
        _ => Ok(Dimensions::of_seed(class, model_seed)?.size_lwh()),
    }
}

/// By which factor a design is stretched most, or pressed.
fn stretch(from_lwh: DVec3, to_lwh: DVec3) -> f64 {
    (to_lwh / from_lwh).max(from_lwh / to_lwh).max_element()
}

/// By which factor the nearest design is stretched.
#[cfg(test)]
pub(super) fn least_stretch(class: ObjectClass, true_lwh: DVec3) -> Result<f64> {
    Ok(stretches(class, true_lwh)?.into_iter().fold(f64::INFINITY, f64::min))
}

fn stretches(class: ObjectClass, true_lwh: DVec3) -> Result<Vec<f64>> {
    let Shelf { cells, sizes_lwh } = shelf(class);
    // Refuses classes without designs.
    let first = size_of_seed(class, 0)?;
    let sizes_lwh = sizes_lwh.get_or_init(|| {
        let rest = (1..cells.len() as u64).filter_map(|k| size_of_seed(class, k).ok());
        std::iter::once(first).chain(rest).collect()
    });
    Ok(sizes_lwh.iter().map(|size| stretch(*size, true_lwh)).collect())
}

/// One of the designs whose extents are about `true_lwh`, or else the nearest.
///
/// # Errors
/// [`cadet_base::error::Error::Scene`] for a class without designs.
pub(super) fn design_near(class: ObjectClass, true_lwh: DVec3, s: &mut Stream) -> Result<Arc<VehicleModel>> {
    let (stretches, cells) = (stretches(class, true_lwh)?, shelf(class).cells);
    let least = stretches.iter().copied().fold(f64::INFINITY, f64::min);
    let most = least.max(MOST_STRETCH);
    let near: Vec<usize> = (0..cells.len()).filter(|k| stretches[*k] <= most).collect();
    let number = near[s.below(near.len())];
    if let Some(design) = cells[number].get() {
        return Ok(Arc::clone(design));
    }
    let made = Arc::new(VehicleModel::generate(class, number as u64)?);
    Ok(Arc::clone(cells[number].get_or_init(|| made)))
}
