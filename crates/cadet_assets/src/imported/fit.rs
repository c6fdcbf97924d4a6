//! Whether a user's mesh has a size of its class, how it comes into its box frame, and what stands out of it.

use std::collections::BTreeMap;

use crate::source_mesh::{SourceMesh, SourceTriangle};
use cadet_base::actor::ObjectClass;
use cadet_base::geometry::Bounds;
use cadet_base::math::{DVec3, Vec3};

/// What can pass for a vehicle, for somebody on foot or on a seat, whose arms may be stretched out, and for a rider:
/// length, width, height in meters.
const VEHICLE_M: [(f64, f64); 3] = [(1.0, 30.0), (0.3, 5.0), (0.3, 6.0)];
const PERSON_M: [(f64, f64); 3] = [(0.1, 2.5), (0.1, 2.5), (0.4, 2.5)];
const CYCLIST_M: [(f64, f64); 3] = [(0.8, 3.5), (0.2, 1.5), (0.7, 2.5)];
/// Of more parts or materials than these none is looked for.
const MOST_GROUPS: usize = 2_000;

/// Moves a mesh into its box frame.
pub(super) struct Fit {
    foot: Vec3,
    scale: Vec3,
    /// Length, width and height, meters.
    pub size: DVec3,
}

impl Fit {
    /// Checks the size; the reason where it is none of its class.
    pub(super) fn new(class: ObjectClass, bounds: &Bounds, wanted: Option<DVec3>) -> Result<Self, String> {
        let found = bounds.size();
        let is_flat = found.min_element() < 1e-4 * found.max_element();
        if !found.is_finite() || is_flat {
            return Err(format!("no body: its bounds are {:.3} x {:.3} x {:.3}", found.x, found.y, found.z));
        }
        let size = wanted.unwrap_or(found.as_dvec3());
        let is_person = matches!(class, ObjectClass::Pedestrian | ObjectClass::PersonSitting);
        let limits_m = match class {
            _ if is_person => PERSON_M,
            ObjectClass::Cyclist => CYCLIST_M,
            _ => VEHICLE_M,
        };
        for ((side, (lo, hi)), value) in ["long", "wide", "high"].iter().zip(limits_m).zip(size.to_array()) {
            if !(lo..=hi).contains(&value) {
                let which = match (wanted, *side) {
                    (Some(_), _) => "size_lwh",
                    (None, "high") => "scale and up",
                    (None, _) => "scale",
                };
                let name = class.kitti_name();
                return Err(format!("{value:.3} m {side}, expected {lo} to {hi} m for a {name}: check {which}"));
            }
        }
        // Arms reach out farther than feet do.
        if found.y > found.x && !is_person {
            let (x, y) = (found.x, found.y);
            return Err(format!("wider ({y:.2} m) than long ({x:.2} m): turn its front to +x with yaw_deg"));
        }
        let foot = Vec3::new(bounds.center().x, bounds.center().y, bounds.min.z);
        Ok(Self { foot, scale: wanted.map_or(Vec3::ONE, |w| w.as_vec3() / found), size })
    }

    pub(super) fn point(&self, p: Vec3) -> Vec3 {
        (p - self.foot) * self.scale
    }
}

/// The reason why a mesh has no size of its class, and the part or material without which it would have one.
pub(super) fn or_what_to_leave_out(
    reason: String,
    class: ObjectClass,
    source: &SourceMesh,
    triangles: &[SourceTriangle],
) -> String {
    let part = |t: &SourceTriangle| source.parts[t.part as usize].last().filter(|name| !name.is_empty());
    let material = |t: &SourceTriangle| Some(&source.materials[t.material as usize].name).filter(|n| !n.is_empty());
    match outlier(class, triangles, part).or_else(|| outlier(class, triangles, material)) {
        None => reason,
        Some(name) => format!(
            "{reason}; without {name:?} it would do: materials.leave_out = [{name:?}] in assets.toml leaves that out"
        ),
    }
}

/// The one name without whose triangles the rest, at least half of all, has a size of the class.
fn outlier<'a>(
    class: ObjectClass,
    triangles: &[SourceTriangle],
    name_of: impl Fn(&SourceTriangle) -> Option<&'a String>,
) -> Option<&'a String> {
    let mut groups: BTreeMap<Option<&String>, (Bounds, usize)> = BTreeMap::new();
    for triangle in triangles {
        let (bounds, count) = groups.entry(name_of(triangle)).or_insert((Bounds::EMPTY, 0));
        *bounds = union(bounds, &Bounds::of(triangle.corners));
        *count += 1;
    }
    if groups.len() > MOST_GROUPS {
        return None;
    }
    let without = |name| {
        let others = groups.iter().filter(|(other, _)| **other != name);
        others.fold(Bounds::EMPTY, |bounds, (_, (other, _))| union(&bounds, other))
    };
    let is_outlier = |name: Option<&'a String>, count: usize| {
        name.is_some() && 2 * count <= triangles.len() && Fit::new(class, &without(name), None).is_ok()
    };
    groups.iter().find(|(name, (_, count))| is_outlier(**name, *count)).and_then(|(name, _)| *name)
}

fn union(a: &Bounds, b: &Bounds) -> Bounds {
    Bounds { min: a.min.min(b.min), max: a.max.max(b.max) }
}
