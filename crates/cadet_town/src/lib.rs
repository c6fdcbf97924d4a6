//! A town: a road network from OpenDRIVE, the ground under it, and the props along its streets.

mod countryside;
mod ground;
mod lots;
mod network;
mod opendrive;
mod paint;
mod placement;
mod plan;
mod plots;
mod props;
mod roadside;
mod signals;
mod street_things;
#[cfg(test)]
mod testing;

pub use ground::{Ground, GroundKind, Roughness};
pub use network::{
    GeoReference, Lane, LaneId, LaneKind, LaneSurface, MapLight, PaintColor, PaintedQuad, ParkingSpot, RightOfWay,
    RoadNetwork, SpotKind, Walkway,
};
pub use opendrive::{load as load_map, load_with_warnings as load_map_with_warnings};
pub use placement::PropConfig;
pub use plan::{Suburb, SuburbConfig, generate as generate_suburb};
pub use roadside::{parking_spots, walkways};
pub use signals::{
    ArmId, Aspect, CrossingRule, JunctionArm, STOP_LINE_M, SignalHead, SignalPlan, SignalledJunction, Signals,
};
pub use street_things::Seat;

use self::ground::land::{Land, Yards};
use self::lots::Lots;
use self::paint::Wear;
use self::placement::PropFootprint;
use cadet_base::error::Result;
use cadet_base::instance::Instance;
use cadet_base::plane::OrientedRect;
use cadet_base::rng::StreamKey;

/// Motorways are smoother than streets.
const MOTORWAY_ROUGHNESS: f64 = 0.3;

/// Everything of a place that does not move.
#[derive(Debug, Clone)]
pub struct Town {
    /// The map's file name, or `suburb`.
    pub name: String,
    /// Lanes and how they follow each other.
    pub network: RoadNetwork,
    /// The surface that is driven and walked on.
    pub ground: Ground,
    /// Ground, houses, plants, furniture: all that stands still.
    pub scenery: Vec<Instance>,
    /// Where cars may be parked.
    pub parking: Vec<ParkingSpot>,
    /// Where people walk.
    pub walkways: Vec<Walkway>,
    /// Things on sidewalks and in parking places that people and cars keep off.
    pub obstacles: Vec<OrientedRect>,
    /// Where people may sit.
    pub seats: Vec<Seat>,
    /// Traffic lights; what stands of them is part of the scenery, their heads are not.
    pub signals: Signals,
    /// What the map's reader passed over, a line each that names map and road.
    pub map_warnings: Vec<String>,
}

impl Town {
    /// A made-up suburb with all that stands in it.
    ///
    /// # Errors
    /// [`cadet_base::Error::OutOfRange`] for a configuration outside its documented limits.
    pub fn suburb(key: &StreamKey, suburb: &SuburbConfig, props: &PropConfig) -> Result<Self> {
        let Suburb { network, .. } = generate_suburb(key, suburb)?;
        Self::with_props(key, "suburb", network, props)
    }

    /// An OpenDRIVE map with props drawn from a key.
    ///
    /// # Errors
    /// [`cadet_base::Error::Map`] where the text is no map or has no street; [`cadet_base::Error::OutOfRange`] for props
    /// outside their documented limits.
    pub fn from_opendrive(key: &StreamKey, map_name: &str, xodr_text: &str, props: &PropConfig) -> Result<Self> {
        let (network, map_warnings) = load_map_with_warnings(map_name, xodr_text)?;
        Ok(Self { map_warnings, ..Self::with_props(key, map_name, network, props)? })
    }

    /// A flat square of 400 m, with no lanes and nothing on it: for tests and scripted scenes. Wheels may go anywhere;
    /// for the sensors it is a road along x between lawns.
    #[must_use]
    pub fn flat() -> Self {
        let mut ground = Ground::flat(200.0);
        ground.tiles = ground::flat_road::tiles(200.0);
        Self {
            name: "flat".to_owned(),
            network: RoadNetwork::default(),
            scenery: ground.tiles.clone(),
            ground,
            parking: Vec::new(),
            walkways: Vec::new(),
            obstacles: Vec::new(),
            seats: Vec::new(),
            signals: Signals::default(),
            map_warnings: Vec::new(),
        }
    }

    fn with_props(key: &StreamKey, name: &str, network: RoadNetwork, config: &PropConfig) -> Result<Self> {
        Self::laid_out(key, name, network, config).map(|(town, _)| town)
    }

    fn laid_out(key: &StreamKey, name: &str, network: RoadNetwork, config: &PropConfig) -> Result<(Self, Layout)> {
        config.check()?;
        let roughness = Roughness::new(&mut key.stream("ground/roughness"));
        let roughness = if network.is_motorway() { roughness.scaled(MOTORWAY_ROUGHNESS) } else { roughness };
        let mut signals = Signals::of(&network, key);
        let wear = Wear::new(&mut key.stream("ground/paint"));
        let land = Land::of(&network, key, ground::extent(&network));
        let mut lots = Lots::default();
        let has_lots = [config.car_park_share, config.industrial_share, config.campus_share].iter().any(|s| *s > 0.0);
        let mut yards = Yards { lines: roadside::bay_lines(&network, key), ..Default::default() };
        let lay = |yards: &Yards| Ground::of_town(&network, Some(&roughness), &wear, &signals, (land.as_ref(), yards));
        let mut ground = lay(&yards)?;
        if has_lots && land.is_none() {
            lots = Lots::plan(key, &network, &ground, config);
            let mut of_lots = lots.yards();
            of_lots.lines.append(&mut yards.lines);
            ground = lay(&of_lots)?;
        }
        let mut parking = parking_spots(&network, &ground, key);
        parking.append(&mut lots.parking(&ground));
        let mut walkways = walkways(&ground);
        walkways.append(&mut lots.walkways(&ground));
        let mut scenery = ground.tiles.clone();
        let mut props = match &land {
            Some(land) => {
                scenery.push(countryside::hills(key, &ground));
                props::place_in_country(key, (&network, &signals), land, &ground, config)
            }
            None => props::place_props(key, (&network, &mut signals), &ground, (&parking, &walkways, &lots), config),
        };
        scenery.append(&mut props.instances);
        parking.append(&mut props.drives);
        let town = Self {
            name: name.to_owned(),
            network,
            ground,
            scenery,
            parking,
            walkways,
            obstacles: props.things.obstacles,
            seats: props.things.seats,
            signals,
            map_warnings: Vec::new(),
        };
        Ok((town, Layout { roughness, land, lots, standing: props.standing }))
    }
}

/// What a town was made from, and what stands where: for its tests.
#[cfg_attr(not(test), allow(dead_code))]
struct Layout {
    roughness: Roughness,
    land: Option<Land>,
    lots: Lots,
    standing: Vec<PropFootprint>,
}
