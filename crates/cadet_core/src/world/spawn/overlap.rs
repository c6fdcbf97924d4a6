//! Whether somebody stands already where an agent is to be put.

use crate::actor::ObjectClass;
use crate::error::{Error, Result};
use crate::math::DVec2;
use crate::world::agent::Agent;
use crate::world::arena::Arena;
use crate::world::body::Body;
use crate::world::control::BODY_M;
use crate::world::course::Overlap;
use crate::world::footprint::Footprint;
use crate::world::slot::{EGO, Slot};

/// What an agent covers in the plane.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Cover {
    /// A vehicle's box.
    Box(Footprint),
    /// A person's trunk.
    Trunk(DVec2),
}

impl Cover {
    fn of(agent: &Agent, arena: &Arena) -> Self {
        match &agent.body {
            Body::Upright(body) => Self::Trunk(body.at()),
            _ => Self::Box(agent.footprint(&arena.physics)),
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Box(a), Self::Box(b)) => a.overlaps(b),
            (Self::Trunk(a), Self::Trunk(b)) => (*a - *b).length() < 2.0 * BODY_M,
            (Self::Box(a), Self::Trunk(p)) | (Self::Trunk(p), Self::Box(a)) => {
                (a.closest_point(*p) - *p).length() < BODY_M
            }
        }
    }

    fn at(&self) -> DVec2 {
        match self {
            Self::Box(footprint) => footprint.center,
            Self::Trunk(at) => *at,
        }
    }
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
    let others = arena.agents.iter().enumerate().filter(|(slot, _)| overlap == Overlap::Refuse && Some(*slot) != own);
    let Some((slot, other)) = others.into_iter().find(|(_, agent)| cover.overlaps(&Cover::of(agent, arena))) else {
        return Ok(());
    };
    let who = if own == Some(EGO) { "the ego".to_owned() } else { format!("a {}", class.kitti_name()) };
    let whom = if slot == EGO {
        "the ego (id 0)".to_owned()
    } else {
        format!("the {} of id {}", other.class.kitti_name(), other.id)
    };
    let DVec2 { x, y } = cover.at();
    Err(Error::Scene { reason: format!("{who} at ({x}, {y}) would overlap {whom}; overlap=\"allow\" puts it there") })
}
