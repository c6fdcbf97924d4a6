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

/// The most that a design is stretched along any axis where there is another choice.
const MOST_STRETCH: f64 = 1.06;

/// A design's extents, and its model once it is asked for.
struct Design {
    size_lwh: DVec3,
    model: OnceLock<Arc<VehicleModel>>,
}

/// The designs of a class.
///
/// # Errors
/// [`cadet_base::error::Error::Scene`] for a class without designs.
fn designs(class: ObjectClass) -> Result<&'static [Design]> {
    static SHELVES: [OnceLock<Vec<Design>>; 4] = [const { OnceLock::new() }; 4];
    let (shelf, count) = match class {
        ObjectClass::Car => (0, 132),
        ObjectClass::Truck => (1, 60),
        ObjectClass::Misc => (2, 112),
        _ => (3, 64),
    };
    let first = size_of_seed(class, 0)?;
    Ok(SHELVES[shelf].get_or_init(|| {
        let rest = (1..count).filter_map(|k| size_of_seed(class, k).ok());
        std::iter::once(first).chain(rest).map(|size_lwh| Design { size_lwh, model: OnceLock::new() }).collect()
    }))
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
    Ok(designs(class)?.iter().map(|d| stretch(d.size_lwh, true_lwh)).fold(f64::INFINITY, f64::min))
}

/// One of the designs whose extents are about `true_lwh`, or else the nearest.
///
/// # Errors
/// [`cadet_base::error::Error::Scene`] for a class without designs.
pub(super) fn design_near(class: ObjectClass, true_lwh: DVec3, s: &mut Stream) -> Result<Arc<VehicleModel>> {
    let designs = designs(class)?;
    let stretches: Vec<f64> = designs.iter().map(|d| stretch(d.size_lwh, true_lwh)).collect();
    let least = stretches.iter().copied().fold(f64::INFINITY, f64::min);
    let most = least.max(MOST_STRETCH);
    let near: Vec<usize> = (0..designs.len()).filter(|k| stretches[*k] <= most).collect();
    let number = near[s.below(near.len())];
    let cell = &designs[number].model;
    if let Some(model) = cell.get() {
        return Ok(Arc::clone(model));
    }
    let made = Arc::new(VehicleModel::generate(class, number as u64)?);
    Ok(Arc::clone(cell.get_or_init(|| made)))
}
