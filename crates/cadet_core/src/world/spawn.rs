//! Who is where at the start, and who comes when others have gone.

use std::sync::Arc;

use super::car::{Car, footprint};
use super::chassis::Chassis;
use super::driver::{Habits, Obstacle};
use super::parked::{Parked, keeps_off_lanes};
use super::physics::Physics;
use super::route::{CAR_STRAIGHT, EGO_STRAIGHT, LONG_STRAIGHT, Roads, Route};
use super::settle::settle;
use super::{EGO, World, open_lanes};
use crate::actor::{AnnotatedBox, ObjectClass};
use crate::assets::vehicle::VehicleModel;
use crate::error::{Error, Result};
use crate::geometry::{LodSet, MeshBuilder};
use crate::material::{Material, Palette, Pattern, Semantic};
use crate::math::{self, DVec2, DVec3, Vec3};
use crate::rng::{Stream, StreamKey};
use crate::town::{LaneId, ParkingSpot, SpotKind, Town};

/// Steps between two looks at who has gone too far away.
pub(super) const RENEW_EVERY: u64 = 30;
/// Cars farther from the ego than this give their place to new ones, which appear beyond what the ego can see.
const CAR_GONE_M: f64 = 190.0;
const CAR_APPEARS_M: (f64, f64) = (100.0, 170.0);
const WALKER_GONE_M: f64 = 130.0;
const WALKER_APPEARS_M: (f64, f64) = (90.0, 125.0);
/// Shares of the classes among driven vehicles.
const DRIVEN_MIX: [(ObjectClass, f64); 2] = [(ObjectClass::Car, 0.91), (ObjectClass::Van, 0.09)];
/// The same among a user's own: trucks have no shape in code.
const DRIVEN_USER_MIX: [(ObjectClass, f64); 3] =
    [(ObjectClass::Car, 0.87), (ObjectClass::Van, 0.09), (ObjectClass::Truck, 0.04)];
/// Shares of the classes among parked vehicles.
const PARKED_MIX: [(ObjectClass, f64); 2] = [(ObjectClass::Car, 0.92), (ObjectClass::Van, 0.08)];
/// Share of the cars along a kerb that stand against the traffic, and of those at an angle that were backed in.
const WRONG_WAY_SHARE: f64 = 0.05;
const BACKED_IN_SHARE: f64 = 0.2;
/// Share of the kerbs where nobody parks.
const EMPTY_ROWS_SHARE: f64 = 0.5;
/// The streets that the ego will see while it drives this far are its way; in the side streets more cars are parked
/// and more people walk than along it, as out of sight they belong to a town but not to a picture.
pub(super) const EGO_WAY_M: f64 = 260.0;
/// Room that a parked vehicle needs along its spot beyond its length.
const LEAST_GAP_M: f64 = 0.3;
/// How much a vehicle may be longer than its spot in a row, at a neighbour's cost, and wider than any spot.
const MOST_OVER_SPOT_M: f64 = 2.2;
const MOST_OVER_WIDTH_M: f64 = 0.45;
/// A car that has stood this long somewhere out of sight is stuck.
const STUCK_STEPS: u64 = 60 * 45;

/// How much traffic there is.
#[derive(Debug, Clone, PartialEq)]
pub struct TrafficConfig {
    /// Driven cars kept around the ego.
    pub num_cars: usize,
    /// People kept around the ego.
    pub num_pedestrians: usize,
    /// Mean fraction of the parking places along the ego's way that are taken, in [0, 1]; it varies from street to
    /// street, and side streets and drives are fuller: its power of 0.35.
    pub parking_occupancy: f64,
    /// Driven cars start within this distance of the ego, metres.
    pub car_radius_m: f64,
    /// People start within this distance of the ego, metres.
    pub pedestrian_radius_m: f64,
    /// Distance from the ego within which parking places are filled, metres.
    pub parking_radius_m: f64,
    /// Classes of the vehicles that drive and park, cars among them; the shares of those left out go to the others.
    pub vehicle_classes: Vec<ObjectClass>,
}

impl Default for TrafficConfig {
    fn default() -> Self {
        Self {
            num_cars: 14,
            num_pedestrians: 24,
            parking_occupancy: 0.6,
            car_radius_m: 110.0,
            pedestrian_radius_m: 80.0,
            parking_radius_m: 280.0,
            vehicle_classes: vec![ObjectClass::Car, ObjectClass::Van, ObjectClass::Truck],
        }
    }
}

/// Occupancy of drives and side streets: fuller than the streets that the ego drives along.
fn beside_ego_way(occupancy: f64) -> f64 {
    math::pow(occupancy, 0.35)
}

impl TrafficConfig {
    fn check(&self) -> Result<()> {
        let bad =
            |what, value: String, expected: &str| Err(Error::OutOfRange { what, value, expected: expected.to_owned() });
        if !(0.0..=1.0).contains(&self.parking_occupancy) {
            return bad("parking occupancy", self.parking_occupancy.to_string(), "0 to 1");
        }
        for (what, radius) in [
            ("car radius", self.car_radius_m),
            ("pedestrian radius", self.pedestrian_radius_m),
            ("parking radius", self.parking_radius_m),
        ] {
            if !(radius.is_finite() && radius > 0.0) {
                return bad(what, radius.to_string(), "a positive number of metres");
            }
        }
        for (what, count, most) in
            [("number of cars", self.num_cars, 500), ("number of pedestrians", self.num_pedestrians, 500)]
        {
            if count > most {
                return bad(what, count.to_string(), "at most 500");
            }
        }
        if !self.vehicle_classes.contains(&ObjectClass::Car) {
            return bad("vehicle classes", format!("{:?}", self.vehicle_classes), "cars among them");
        }
        Ok(())
    }

    /// The shares of a mix, 0 for classes that are left out.
    fn among_classes<const N: usize>(&self, mix: &[(ObjectClass, f64); N]) -> [(ObjectClass, f64); N] {
        mix.map(|(class, share)| (class, if self.vehicle_classes.contains(&class) { share } else { 0.0 }))
    }
}

/// The ego's own measures: an estate car of 2006, like the one that recorded KITTI. Nobody sees it, so it has no shape
/// but a box.
pub(super) fn ego_model() -> VehicleModel {
    let (size_lwh, wheel_radius_m) = (DVec3::new(4.77, 1.82, 1.52), 0.316);
    let (front, rear, side) = (1.44, -1.27, 0.78);
    let mut block = MeshBuilder::new();
    let half = (size_lwh / 2.0).as_vec3();
    block.cuboid(Vec3::new(-half.x, -half.y, 0.2), Vec3::new(half.x, half.y, size_lwh.z as f32), 0);
    let shape = Arc::new(LodSet::single(block.build("ego", 0.5)));
    let paint = Material::matt(Semantic::Car, [0.3; 3], Pattern::Plain, 0.3);
    VehicleModel {
        name: "ego".to_owned(),
        class: ObjectClass::Car,
        size_lwh,
        annotated: AnnotatedBox::exact(size_lwh),
        body: Arc::clone(&shape),
        driver: None,
        wheel: Some(shape),
        wheel_centers: [(front, side), (front, -side), (rear, side), (rear, -side)]
            .map(|(x, y)| Vec3::new(x, y, wheel_radius_m as f32)),
        wheel_radius_m,
        palette: Arc::new(Palette::new(vec![paint])),
    }
}

/// Puts the ego on a lane from which it can drive far.
pub(super) fn place_ego(
    physics: &mut Physics,
    roads: &Roads,
    town: &Town,
    model: Arc<VehicleModel>,
    key: StreamKey,
) -> Result<Car> {
    let mut stream = key.stream("ego place");
    let mut lanes: Vec<LaneId> = open_lanes(roads).filter(|l| l.length_m() > 16.0).map(|l| l.id).collect();
    let farthest = lanes.iter().map(|l| roads.reach_m(*l)).fold(0.0, f64::max);
    lanes.retain(|l| roads.reach_m(*l) >= farthest.min(350.0));
    let weights: Vec<f64> = lanes.iter().map(|l| roads.lane(*l).length_m()).collect();
    let habits = Habits::draw_of_ego(&mut key.stream("ego habits"));
    for _ in 0..50 {
        if lanes.is_empty() {
            break;
        }
        let lane = roads.lane(lanes[stream.weighted(&weights)]);
        let s_m = stream.range(4.0, (lane.length_m() - 8.0).max(5.0));
        let offset_m = stream.clipped_normal(0.0, 0.08);
        let route = Route::new(lane.id, s_m, offset_m, EGO_STRAIGHT, key.stream("ego route"), roads);
        if let Some(chassis) = on_route(physics, roads, &route, &model, 0.0) {
            return Ok(Car::new(0, chassis, Some(route), habits));
        }
    }
    let bounds = crate::geometry::Bounds::of(town.ground.vertices.iter().copied());
    let middle = bounds.center().as_dvec3();
    let settled =
        settle(physics, &model, 0.0, 0.0, 0.0).or_else(|_| settle(physics, &model, middle.x, middle.y, 0.0)).map_err(
            |_| Error::Scene { reason: "the ego finds no place: no drivable lane, no ground in the middle".into() },
        )?;
    let chassis = Chassis::new(physics, model, &settled.world_from_box, 0.0);
    Ok(Car::new(0, chassis, None, habits))
}

/// A chassis standing at the start of a route, heading along it; `None` beyond the ground's edge.
fn on_route(
    physics: &mut Physics,
    roads: &Roads,
    route: &Route,
    model: &Arc<VehicleModel>,
    speed_mps: f64,
) -> Option<Chassis> {
    let here = route.ahead(0.0, roads);
    let yaw = math::atan2(here.tangent.y, here.tangent.x);
    let settled = settle(physics, model, here.at.x, here.at.y, yaw).ok()?;
    Some(Chassis::new(physics, Arc::clone(model), &settled.world_from_box, speed_mps))
}

impl World {
    /// Fills the world: parked cars, then driven ones, then people. To be called once, before the first step.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a configuration that makes no sense.
    pub fn spawn_traffic(&mut self, config: &TrafficConfig) -> Result<()> {
        config.check()?;
        self.traffic = Some(config.clone());
        self.cars[EGO].drives = self.cars[EGO].route.is_some();
        self.park_cars(config)?;
        let mut stream = self.key.stream("driven cars");
        for _ in 0..config.num_cars {
            let slot = self.cars.len();
            if let Some(car) = self.new_car(slot, &mut stream, (9.0, config.car_radius_m), false) {
                self.cars.push(car);
            }
        }
        let mut stream = self.key.stream("people");
        for _ in 0..config.num_pedestrians {
            let slot = self.walkers.len();
            if let Some(walker) = self.new_walker(slot, &mut stream, (3.0, config.pedestrian_radius_m), false) {
                self.walkers.push(walker);
            }
        }
        Ok(())
    }

    pub(super) fn ego_place(&self) -> (DVec2, DVec2) {
        let pose = self.cars[EGO].chassis.world_from_box(&self.physics);
        (pose.translation.truncate(), (pose.rotation * DVec3::X).truncate().normalize())
    }

    fn park_cars(&mut self, config: &TrafficConfig) -> Result<()> {
        let mut stream = self.key.stream("parked cars");
        let (ego, _) = self.ego_place();
        let own = self.cars[EGO].footprint(&self.physics).grown(1.0);
        let town = Arc::clone(&self.town);
        let parked_mix = config.among_classes(&PARKED_MIX);
        let way = self.ego_way();
        let on_way: Vec<u32> = way.iter().flat_map(|r| r.lanes.iter()).map(|l| self.roads.lane(*l).road).collect();
        for spot in &town.parking {
            // Every place draws the same numbers whether it is filled or not, so that places don't depend on another.
            let mut draw = Stream::from_seed("parking place", stream.next_u64());
            let at = spot.world_from_spot.translation;
            if (at.truncate() - ego).length() > config.parking_radius_m
                || !self.is_taken(spot, config, &on_way, &mut draw)
            {
                continue;
            }
            let over_m = if spot.kind == SpotKind::Parallel { MOST_OVER_SPOT_M } else { 0.0 };
            let model = match self.user_vehicles.draw(&mut draw, &parked_mix, |m| fits(spot, over_m, m)) {
                Some(model) => model,
                None => parked_model(spot, over_m, parked_mix[1].1, &mut draw)?,
            };
            if !fits(spot, over_m, &model) {
                continue;
            }
            let outlier = draw.chance(0.05);
            let yaw_sd_deg: f64 = if outlier { 7.0 } else { 1.6 };
            let turned_share = if spot.kind == SpotKind::Angled { BACKED_IN_SHARE } else { WRONG_WAY_SHARE };
            let wrong_way = if draw.chance(turned_share) { math::PI } else { 0.0 };
            let slack_m = (spot.length_m - model.size_lwh.x).max(0.0) / 2.0;
            let mut along_m = draw.clipped_normal(0.0, 0.35).clamp(-slack_m, slack_m);
            // What is longer than its spot takes room from one neighbour.
            let over_m = (model.size_lwh.x + LEAST_GAP_M - spot.length_m).max(0.0) / 2.0;
            if draw.chance(0.5) {
                along_m = -along_m;
            }
            let shift_m = if draw.chance(0.5) { over_m } else { -over_m };
            let aside_m = draw.clipped_normal(0.0, 0.1);
            let yaw = crate::frames::yaw_of(&spot.world_from_spot)
                + wrong_way
                + draw.clipped_normal(0.0, yaw_sd_deg.to_radians());
            let free = |shift_m: f64| {
                let along_m = along_m + shift_m;
                let place = spot.world_from_spot.transform_point(DVec3::new(along_m, aside_m, 0.0));
                let rectangle = footprint(&crate::frames::upright(place, yaw), model.size_lwh, DVec2::ZERO);
                let clear = !rectangle.overlaps(&own)
                    && self.parked.iter().all(|p| !p.footprint.overlaps(&rectangle.grown(0.25)))
                    && keeps_off_lanes(&self.roads, &rectangle, 1.25);
                clear.then_some(place)
            };
            let Some(place) = free(shift_m).or_else(|| free(-shift_m)) else { continue };
            let id = self.next_id;
            if let Ok(parked) = Parked::new(&mut self.physics, &self.roads, id, model, place.x, place.y, yaw) {
                self.parked.push(parked);
                self.next_id += 1;
            }
        }
        Ok(())
    }

    /// The way that the ego will drive, as far as it matters.
    pub(super) fn ego_way(&self) -> Option<Route> {
        self.cars[EGO].route.as_ref().map(|r| r.foreseen(EGO_WAY_M, &self.roads))
    }

    fn is_taken(&self, spot: &ParkingSpot, config: &TrafficConfig, on_way: &[u32], draw: &mut Stream) -> bool {
        let at = spot.world_from_spot.translation;
        let lane = self.roads.nearest(at, None, 12.0).map(|(lane, s_m, _)| (self.roads.lane(lane), s_m));
        if lane.is_none() || spot.kind == SpotKind::Drive {
            // Who has a drive of their own keeps the car there, however full the street.
            return draw.chance(beside_ego_way(config.parking_occupancy));
        }
        // One row: one side of one road; each has its own occupancy.
        let row = lane.map_or(u64::MAX, |(lane, _)| u64::from(lane.road) * 2 + u64::from(lane.id.0 % 2 == 0));
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

    /// A car at a random free place of a lane, between two distances from the ego; `hidden` keeps it out of its view.
    fn new_car(&mut self, slot: usize, stream: &mut Stream, ring_m: (f64, f64), hidden: bool) -> Option<Car> {
        let (ego, view) = self.ego_place();
        let traffic = self.traffic.as_ref()?;
        let (own_mix, mix) = (traffic.among_classes(&DRIVEN_USER_MIX), traffic.among_classes(&DRIVEN_MIX));
        let model = match self.user_vehicles.draw(stream, &own_mix, |_| true) {
            Some(model) => model,
            None => {
                let (class, _) = mix[stream.weighted(&mix.map(|(_, weight)| weight))];
                Arc::new(VehicleModel::of_traffic(class, stream.next_u64()).expect("cars and vans have a shape"))
            }
        };
        let half_m = model.size_lwh.x / 2.0;
        let straight = if half_m > 2.7 { LONG_STRAIGHT } else { CAR_STRAIGHT };
        let mut places: Vec<(LaneId, f64, f64)> = Vec::new();
        for lane in open_lanes(&self.roads) {
            let mut s = half_m + 1.0;
            while s < lane.length_m() - half_m - 6.0 {
                let p = lane.pose_at(s);
                let to = p.translation.truncate() - ego;
                let distance = to.length();
                let in_view = to.dot(view) > 0.7 * distance && distance < 140.0;
                if (ring_m.0..ring_m.1).contains(&distance) && !(hidden && in_view) {
                    // Nearer is likelier, and newcomers head for the ego.
                    let towards = (p.rotation * DVec3::X).truncate().dot(to) < 0.0;
                    let weight = if hidden { if towards { 1.0 } else { 0.25 } } else { 40.0 / (distance + 30.0) };
                    places.push((lane.id, s, weight));
                }
                s += 4.0;
            }
        }
        let weights: Vec<f64> = places.iter().map(|p| p.2).collect();
        let footprints: Vec<Obstacle> = self.cars.iter().map(|c| c.footprint(&self.physics)).collect();
        for _ in 0..30 {
            let (lane_id, s_m, _) = *places.get(stream.weighted(&weights))?;
            let lane = self.roads.lane(lane_id);
            let s_m = s_m + stream.range(0.0, 3.5);
            let offset_m = stream.clipped_normal(0.0, 0.1);
            let seed = self.key.indexed("car route", stream.next_u64());
            let route = Route::new(lane_id, s_m, offset_m, straight, seed, &self.roads);
            let here = route.ahead(0.0, &self.roads);
            let rectangle = Obstacle {
                center: here.at,
                heading: here.tangent,
                half_length_m: half_m,
                half_width_m: model.size_lwh.y / 2.0,
                velocity: DVec2::ZERO,
            };
            // Sideways little room, along the lane a headway.
            let long =
                Obstacle { half_length_m: half_m + 8.0, half_width_m: rectangle.half_width_m + 0.2, ..rectangle };
            let taken = footprints.iter().enumerate().any(|(i, f)| {
                // Who comes from behind needs room to brake.
                let half_length_m = long.half_length_m + 1.8 * f.velocity.length();
                i != slot && (Obstacle { half_length_m, ..long }.overlaps(f) || rectangle.grown(0.5).overlaps(f))
            }) || self.parked.iter().any(|p| rectangle.grown(0.1).overlaps(&p.footprint))
                || self.walkers.iter().filter_map(|w| w.in_the_way(&self.roads)).any(|w| long.overlaps(&w));
            if taken || route.remaining_m(&self.roads) < 30.0 {
                continue;
            }
            // As fast as still allows a stop before the junction and behind whoever is ahead.
            let free_m = footprints
                .iter()
                .map(|f| (f.center - here.at).dot(here.tangent))
                .filter(|d| *d > 0.0)
                .fold(lane.length_m() - s_m, f64::min);
            let stop = (2.0 * 1.5 * (free_m - half_m - 8.0).max(0.0)).sqrt();
            let speed = (0.9 * route.speed_for_bends(8.0, 1.5, &self.roads)).min(stop);
            let habits = Habits::draw(stream);
            let Some(chassis) = on_route(&mut self.physics, &self.roads, &route, &model, speed) else { continue };
            let id = self.next_id;
            self.next_id += 1;
            return Some(Car::new(id, chassis, Some(route), habits));
        }
        None
    }

    /// Replaces who has gone too far from the ego by newcomers out of its sight.
    pub(super) fn renew_traffic(&mut self) {
        if self.traffic.is_none() {
            return;
        }
        let (ego, view) = self.ego_place();
        for slot in 1..self.cars.len() {
            let car = &self.cars[slot];
            let to = car.chassis.world_from_box(&self.physics).translation.truncate() - ego;
            let hidden = to.length() > 100.0 || (to.length() > 90.0 && to.dot(view) < 0.0);
            let stuck = hidden && car.standing_steps > STUCK_STEPS;
            if to.length() < CAR_GONE_M && !stuck {
                continue;
            }
            let mut stream = self.key.indexed("newcomers", self.respawns);
            self.respawns += 1;
            if let Some(car) = self.new_car(slot, &mut stream, CAR_APPEARS_M, true) {
                self.junctions.forget(slot);
                self.physics.remove(self.cars[slot].chassis.body);
                self.cars[slot] = car;
            }
        }
        for slot in 0..self.walkers.len() {
            let walker = &self.walkers[slot];
            if (walker.position.truncate() - ego).length() < WALKER_GONE_M || walker.is_placed {
                continue;
            }
            let mut stream = self.key.indexed("new people", self.respawns);
            self.respawns += 1;
            if let Some(walker) = self.new_walker(slot, &mut stream, WALKER_APPEARS_M, true) {
                self.replace_walker(slot, walker);
            }
        }
    }
}

/// A model for a parking place: a car where a van would not fit.
fn parked_model(spot: &ParkingSpot, over_m: f64, van_share: f64, draw: &mut Stream) -> Result<Arc<VehicleModel>> {
    let class = if draw.chance(van_share) { ObjectClass::Van } else { ObjectClass::Car };
    let model = VehicleModel::of_traffic(class, draw.next_u64())?;
    let model =
        if fits(spot, over_m, &model) { model } else { VehicleModel::of_traffic(ObjectClass::Car, draw.next_u64())? };
    Ok(Arc::new(model))
}

/// Whether a vehicle that may reach beyond its spot by `over_m` finds room.
fn fits(spot: &ParkingSpot, over_m: f64, model: &VehicleModel) -> bool {
    model.size_lwh.x + LEAST_GAP_M <= spot.length_m + over_m && model.size_lwh.y <= spot.width_m + MOST_OVER_WIDTH_M
}
