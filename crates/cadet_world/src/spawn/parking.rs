//! Parked cars: in the parking places of a town, each row as full as its street.

use std::sync::Arc;

use super::config::{PARKED_MIX, PARKED_RARE, TrafficConfig, YARD_RARE, YARD_VANS_SHARE};
use super::newcomers::parked_vehicle;
use super::spawner::Spawner;
use crate::agents::Fixture;
use crate::footprint::Footprint;
use crate::look::TurnSignal;
use cadet_assets::vehicle::{Opening, VehicleModel};
use cadet_base::actor::ObjectClass;
use cadet_base::error::{Error, Result};
use cadet_base::math::{self, DVec3};
use cadet_base::rng::Stream;
use cadet_town::{ParkingSpot, SpotKind, Town};

/// Share of the cars along a curb that stand against the traffic, and of those at an angle that were backed in.
const WRONG_WAY_SHARE: f64 = 0.05;
const BACKED_IN_SHARE: f64 = 0.2;
const BACKED_IN_LOTS_SHARE: f64 = 0.25;
const BACKED_IN_YARDS_SHARE: f64 = 0.5;
/// Share of the curbs where nobody parks.
const EMPTY_ROWS_SHARE: f64 = 0.5;
/// Room that a parked vehicle needs along its spot beyond its length.
const LEAST_GAP_M: f64 = 0.3;
/// How much a vehicle may be longer than its spot in a row, at a neighbor's cost, and wider than any spot.
const MOST_OVER_SPOT_M: f64 = 2.2;
const MOST_OVER_WIDTH_M: f64 = 0.45;
const RARE_OVER_WIDTH_M: f64 = 0.3;
/// Share of the vans at a curb that stand there to deliver, with their hazard lights on.
const DELIVERING_SHARE: f64 = 0.06;
/// Share of the parked cars of which something stands open: the tailgate, or on drives, where nobody passes, a door.
const OPEN_SHARE: f64 = 0.02;

/// Room between a parked vehicle and the middle of every lane.
pub(super) const OFF_LANES_M: f64 = 1.25;
/// Room between a parked vehicle and the middle of every lane for bicycles.
const OFF_CYCLE_LANES_M: f64 = 0.75;

/// Occupancy of drives and side streets: fuller than the streets that the ego drives along.
fn beside_ego_way(occupancy: f64) -> f64 {
    math::pow(occupancy, 0.35)
}

impl Spawner<'_> {
    /// Fills the parking places near the ego.
    pub(super) fn park_cars(&mut self, town: &Town) -> Result<()> {
        let config = self.config;
        let mut stream = self.key.stream("parked cars");
        let (ego, _) = self.arena.ego_place();
        let own = self.arena.ego().actor().footprint(&self.arena.physics).grown(1.0);
        let parked_mix = config.shares(&PARKED_MIX, &[]);
        let way = self.ego_way();
        let graph = &self.arena.streets.graph;
        let on_way: Vec<u32> = way.iter().flat_map(|r| r.lanes.iter()).map(|l| graph.lane(*l).road).collect();
        for spot in &town.parking {
            // Every place draws the same numbers whether it is filled or not, so that places don't depend on another.
            let seed = stream.next_u64();
            let mut draw = Stream::from_seed("parking place", seed);
            let at = spot.world_from_spot.translation;
            if (at.truncate() - ego).length() > config.parking_radius_m
                || !self.is_taken(spot, config, &on_way, &mut draw)
            {
                continue;
            }
            let is_usual_yard = spot.kind == SpotKind::Yard && config.vehicle_shares.is_empty();
            let van_share = if is_usual_yard { YARD_VANS_SHARE } else { parked_mix[1].1 };
            let over_m = if spot.kind == SpotKind::Parallel { MOST_OVER_SPOT_M } else { 0.0 };
            let model = match self.user_models.draw(&mut draw, &parked_mix, |m| fits(spot, over_m, m)) {
                Some(model) => model,
                None => match rare_model(spot, over_m, config, seed)? {
                    Some(model) => model,
                    None => parked_model(spot, over_m, van_share, &mut draw)?,
                },
            };
            if !fits(spot, over_m, &model) {
                continue;
            }
            let outlier = draw.chance(0.05);
            let yaw_sd_deg: f64 = if outlier { 7.0 } else { 1.6 };
            let turned_share = match spot.kind {
                SpotKind::Angled => BACKED_IN_SHARE,
                SpotKind::Lot => BACKED_IN_LOTS_SHARE,
                SpotKind::Yard => BACKED_IN_YARDS_SHARE,
                SpotKind::Parallel | SpotKind::Drive => WRONG_WAY_SHARE,
            };
            let wrong_way = if draw.chance(turned_share) { math::PI } else { 0.0 };
            let slack_m = (spot.length_m - model.size_lwh.x).max(0.0) / 2.0;
            let mut along_m = draw.clipped_normal(0.0, 0.35).clamp(-slack_m, slack_m);
            // A vehicle longer than its spot takes room from one neighbor.
            let over_m = (model.size_lwh.x + LEAST_GAP_M - spot.length_m).max(0.0) / 2.0;
            if draw.chance(0.5) {
                along_m = -along_m;
            }
            let shift_m = if draw.chance(0.5) { over_m } else { -over_m };
            let aside_m = draw.clipped_normal(0.0, 0.1);
            let yaw = cadet_base::frames::yaw_of(&spot.world_from_spot)
                + wrong_way
                + draw.clipped_normal(0.0, yaw_sd_deg.to_radians());
            let free = |shift_m: f64| {
                let along_m = along_m + shift_m;
                let place = spot.world_from_spot.transform_point(DVec3::new(along_m, aside_m, 0.0));
                let rectangle = Footprint::of_upright(model.size_lwh, place, yaw);
                let clear = !rectangle.overlaps(&own)
                    && self.arena.around.standing.iter().all(|o| !o.overlaps(&rectangle.grown(0.25)))
                    && self.arena.streets.graph.keeps_off_lanes(&rectangle, OFF_LANES_M)
                    && self.arena.streets.graph.keeps_off_cycle_lanes(&rectangle, OFF_CYCLE_LANES_M);
                clear.then_some(place)
            };
            let Some(place) = free(shift_m).or_else(|| free(-shift_m)) else { continue };
            let delivers = model.class == ObjectClass::Van
                && spot.kind == SpotKind::Parallel
                && Stream::from_seed("hazard lights", seed).chance(DELIVERING_SHARE);
            let mut parked = match parked_vehicle(self.arena, model, place, yaw) {
                // A wheel would stand beyond the ground's edge.
                Err(Error::Scene { .. }) => continue,
                parked => parked?,
            };
            parked.look.signal = if delivers { TurnSignal::Hazard } else { TurnSignal::Off };
            if let Some(opening) = opening(spot, seed) {
                parked.look.open(opening);
            }
            self.arena.put(Fixture::Vehicle(parked));
        }
        Ok(())
    }

    fn is_taken(&self, spot: &ParkingSpot, config: &TrafficConfig, on_way: &[u32], draw: &mut Stream) -> bool {
        if matches!(spot.kind, SpotKind::Lot | SpotKind::Yard) {
            return draw.chance(config.parking_occupancy);
        }
        let at = spot.world_from_spot.translation;
        let graph = &self.arena.streets.graph;
        let lane = graph.nearest(at, None, 12.0).map(|at| (graph.lane(at.lane), at.s_m));
        if lane.is_none() || spot.kind == SpotKind::Drive {
            // People with a drive of their own keep the car there, however full the street.
            return draw.chance(beside_ego_way(config.parking_occupancy));
        }
        // One row: the curb of one lane; each has its own occupancy.
        let row = lane.map_or(u64::MAX, |(lane, _)| lane.id.0 as u64);
        let mut street = self.key.indexed("parking row", row);
        if lane.is_some_and(|(l, _)| !on_way.contains(&l.road)) {
            return draw.chance((beside_ego_way(config.parking_occupancy) + street.range(-0.15, 0.15)).min(0.95));
        }
        // The rows that are used are the fuller for it, so that the mean stays.
        let mean = config.parking_occupancy;
        let is_empty = street.chance(EMPTY_ROWS_SHARE.min(1.0 - mean));
        let used = mean / (1.0 - EMPTY_ROWS_SHARE.min(1.0 - mean)).max(1e-9);
        let spread = 0.5 * used.min(1.0 - used);
        let share = used + spread * street.range(-1.0, 1.0);
        draw.chance(share.clamp(0.0, 1.0)) && !is_empty
    }
}

/// What of the car in a parking place stands open, if anything.
fn opening(spot: &ParkingSpot, seed: u64) -> Option<Opening> {
    let mut stream = Stream::from_seed("open door", seed);
    if !stream.chance(OPEN_SHARE) {
        return None;
    }
    let is_door = spot.kind == SpotKind::Drive && stream.chance(0.6);
    let side = if stream.chance(0.7) { Opening::LeftDoor } else { Opening::RightDoor };
    Some(if is_door { side } else { Opening::Tailgate })
}

/// A truck, a trailer or a motorbike for some of the parking places, where it fits.
fn rare_model(spot: &ParkingSpot, over_m: f64, config: &TrafficConfig, seed: u64) -> Result<Option<Arc<VehicleModel>>> {
    let shares = if spot.kind == SpotKind::Yard { &YARD_RARE } else { &PARKED_RARE };
    let Some(class) = config.rare(shares, seed) else { return Ok(None) };
    let model = VehicleModel::of_traffic(class, seed)?;
    // On a sidewalk it would leave no room to walk.
    let is_narrow = model.size_lwh.y <= spot.width_m + RARE_OVER_WIDTH_M;
    Ok((is_narrow && fits(spot, over_m, &model)).then(|| Arc::new(model)))
}

/// A model for a parking place: a car where a van would not fit, if there are cars.
fn parked_model(spot: &ParkingSpot, over_m: f64, van_share: f64, draw: &mut Stream) -> Result<Arc<VehicleModel>> {
    let class = if draw.chance(van_share) { ObjectClass::Van } else { ObjectClass::Car };
    let model = VehicleModel::of_traffic(class, draw.next_u64())?;
    let is_kept = fits(spot, over_m, &model) || van_share >= 1.0;
    let model = if is_kept { model } else { VehicleModel::of_traffic(ObjectClass::Car, draw.next_u64())? };
    Ok(Arc::new(model))
}

/// Whether a vehicle that may reach beyond its spot by `over_m` finds room.
fn fits(spot: &ParkingSpot, over_m: f64, model: &VehicleModel) -> bool {
    model.size_lwh.x + LEAST_GAP_M <= spot.length_m + over_m && model.size_lwh.y <= spot.width_m + MOST_OVER_WIDTH_M
}
