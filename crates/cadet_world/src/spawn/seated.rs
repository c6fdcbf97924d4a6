//! People who sit: on the seats of a town, and where the user wants them.

use std::sync::Arc;

use super::newcomers::on_foot;
use super::placed::{Start, check_stays, start_on_foot};
use super::spawner::Spawner;
use crate::agents::{Actor, AgentKind, Fixture};
use crate::arena::Arena;
use crate::body::Upright;
use crate::course::{Course, Overlap};
use crate::look::PersonLook;
use crate::params::walking::BODY_M;
use cadet_assets::person::PersonModel;
use cadet_base::actor::ObjectClass;
use cadet_base::error::Result;
use cadet_base::frames;
use cadet_base::math::DPose3;
use cadet_base::rng::Stream;
use cadet_town::Town;

/// Height of the seat of who is put somewhere without one: a chair's.
const SEAT_M: f64 = 0.46;
/// Seats this near to each other are used or left alone together.
const TOGETHER_M: f64 = 12.0;

impl Spawner<'_> {
    /// Seats people near the ego, some seats beside each other; nobody gets up.
    pub(super) fn seat_people(&mut self, town: &Town) {
        let (ego, _) = self.arena.ego_place();
        for (k, seat) in town.seats.iter().enumerate() {
            let mut stream = self.key.indexed("seat", k as u64);
            let at = seat.world_from_seat.translation.truncate();
            // Seats of one place share their luck: a bench is full or empty rather than half of either.
            let place = (at / TOGETHER_M).floor();
            let index = (place.x as i64 as u64) << 32 | (place.y as i64 as u64 & 0xffff_ffff);
            let is_used = self.key.indexed("seats of a place", index).unit() < self.config.seat_occupancy.sqrt();
            let is_taken = stream.unit() < self.config.seat_occupancy.sqrt();
            if !(is_used && is_taken) || (at - ego).length() > self.config.parking_radius_m {
                continue;
            }
            let model = PersonModel::sitting(stream.next_u64(), seat.height_m);
            let body = seated(&model, &seat.world_from_seat, &mut stream);
            let here = body.at();
            if self.arena.people().all(|(_, other)| (other.center - here).length() > 2.0 * BODY_M) {
                self.arena.put(sitter(model, body));
            }
        }
    }
}

/// Somebody on a seat.
fn sitter(model: PersonModel, body: Upright) -> AgentKind {
    let look = PersonLook { model: Arc::new(model), phase: 0.0 };
    Fixture::Person(Actor { body, look }).into()
}

/// Puts somebody on a seat, turned a little on it.
fn seated(model: &PersonModel, world_from_seat: &DPose3, stream: &mut Stream) -> Upright {
    let yaw_rad = frames::yaw_of(world_from_seat) + stream.clipped_normal(0.0, 0.08);
    let turned = frames::upright(world_from_seat.translation, yaw_rad);
    let position = turned.transform_point(model.seat_from_box());
    Upright::standing(position, yaw_rad)
}

/// Adds somebody who sits at a chair's height with the middle of the box at a place; returns the id.
///
/// # Errors
/// As [`super::placed::add_vehicle`] and [`check_stays`].
pub(crate) fn add_seated(arena: &mut Arena, model_seed: u64, course: &Course, overlap: Overlap) -> Result<i32> {
    check_stays(course)?;
    let Start { at, yaw_rad, .. } = start_on_foot(arena, ObjectClass::PersonSitting, course, overlap)?;
    let model = PersonModel::sitting(model_seed, SEAT_M);
    let body = on_foot(arena, at, yaw_rad)?;
    Ok(arena.put_placed(sitter(model, body)))
}
