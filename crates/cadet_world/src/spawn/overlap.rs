//! Whether somebody stands already where an agent is to be put.

use crate::agents::ActorView;
use crate::arena::Arena;
use crate::course::Overlap;
use crate::footprint::Footprint;
use crate::params::LEVEL_M;
use crate::params::walking::BODY_M;
use crate::slot::{EGO, Slot};
use cadet_base::actor::ObjectClass;
use cadet_base::error::{Error, Result};
use cadet_base::math::{DVec2, DVec3};

/// Nobody appears where somebody who comes the other way will be by then, and the room kept beside that.
const TOWARD_S: f64 = 6.0;
const BESIDE_ONCOMING_M: f64 = 0.2;

/// What an agent covers in the plane.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Cover {
    /// A vehicle's box.
    Box(Footprint),
    /// A person's trunk.
    Trunk(DVec3),
}

impl Cover {
    fn of(actor: ActorView<'_>, arena: &Arena) -> Self {
        match actor.body.person() {
            Some(person) => Self::Trunk(person.position),
            None => Self::Box(actor.footprint(&arena.physics)),
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Box(a), Self::Box(b)) => a.overlaps(b),
            (Self::Trunk(a), Self::Trunk(b)) => {
                (*a - *b).truncate().length() < 2.0 * BODY_M && (a.z - b.z).abs() < LEVEL_M
            }
            (Self::Box(a), Self::Trunk(p)) | (Self::Trunk(p), Self::Box(a)) => {
                let at = p.truncate();
                a.distance_m(at) < BODY_M && a.is_level_with(at, p.z)
            }
        }
    }

    fn at(&self) -> DVec2 {
        match self {
            Self::Box(footprint) => footprint.center,
            Self::Trunk(at) => at.truncate(),
        }
    }
}

/// Whether a vehicle goes the other way and would be at a newcomer's place soon: who is overtaking has looked already.
pub(super) fn comes_toward(vehicle: &Footprint, newcomer: &Footprint) -> bool {
    vehicle.heading.dot(newcomer.heading) < 0.0 && vehicle.swept(TOWARD_S).overlaps(&newcomer.grown(BESIDE_ONCOMING_M))
}

/// Refuses a place where somebody else than `own` stands, unless that is allowed.
///
/// # Errors
/// [`Error::Scene`], naming the other agent.
pub(crate) fn check_free(
    arena: &Arena,
    own: Option<Slot>,
    class: ObjectClass,
    cover: &Cover,
    overlap: Overlap,
) -> Result<()> {
    let others = arena.present().filter(|(slot, _)| overlap == Overlap::Refuse && Some(*slot) != own);
    let mut others = others.flat_map(|(_, agent)| agent.actors());
    let Some((id, other)) = others.find(|(_, actor)| cover.overlaps(&Cover::of(*actor, arena))) else {
        return Ok(());
    };
    let who = if own == Some(EGO) { "the ego".to_owned() } else { format!("a {}", class.kitti_name()) };
    let whom = if id == arena.ego().id {
        "the ego (id 0)".to_owned()
    } else {
        format!("the {} of id {id}", other.look.class().kitti_name())
    };
    let DVec2 { x, y } = cover.at();
    Err(Error::Scene { reason: format!("{who} at ({x}, {y}) would overlap {whom}; overlap=\"allow\" puts it there") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_appears_before_who_comes_toward_the_place() {
        let at = |x: f64, y: f64, heading: DVec2, mps: f64| Footprint {
            center: DVec2::new(x, y),
            heading,
            half_length_m: 2.2,
            half_width_m: 0.9,
            z_m: 0.0,
            velocity: heading * mps,
        };
        let newcomer = at(0.0, 0.0, DVec2::X, 0.0);
        assert!(comes_toward(&at(60.0, 0.5, -DVec2::X, 13.0), &newcomer), "overtakes");
        assert!(!comes_toward(&at(60.0, 3.0, -DVec2::X, 13.0), &newcomer), "in its own lane");
        assert!(!comes_toward(&at(90.0, 0.5, -DVec2::X, 13.0), &newcomer), "far away");
        assert!(!comes_toward(&at(-10.0, 0.5, -DVec2::X, 13.0), &newcomer), "is past");
        assert!(!comes_toward(&at(-60.0, 0.0, DVec2::X, 13.0), &newcomer), "follows");
        assert!(comes_toward(&at(2.0, 0.0, -DVec2::X, 0.0), &newcomer), "stands there");
    }
}
