//! Makes a suburb: its streets as OpenDRIVE, read back by the same door as any other map.

use crate::network::RoadNetwork;
use crate::opendrive;
use crate::plan::xodr::{motorway_writer, writer};
use crate::plan::{Motorway, Relief, SuburbConfig, street_plan};
use cadet_base::error::Result;
use cadet_base::rng::{Stream, StreamKey};

/// Smallest radius of crests and dips on motorways: they are driven fast.
const MOTORWAY_VERTICAL_RADIUS_M: f64 = 5000.0;

/// A generated suburb.
#[derive(Debug, Clone)]
pub struct Suburb {
    /// Its OpenDRIVE 1.7 document.
    pub xodr: String,
    /// Its network, read from the document by [`crate::load_map`].
    pub network: RoadNetwork,
}

/// Streets fall to one side by 2 to 2.5 %, so that rain runs off.
fn draw_crossfall(stream: &mut Stream) -> f64 {
    let slope = stream.range(0.02, 0.025);
    if stream.chance(0.5) { slope } else { -slope }
}

/// Makes the suburb of a key: the same key gives the same text.
///
/// # Errors
/// [`cadet_base::Error::OutOfRange`] for a configuration outside its documented limits.
pub fn generate(key: &StreamKey, config: &SuburbConfig) -> Result<Suburb> {
    config.check()?;
    let relief = Relief::new(&mut key.stream("suburb/relief"), config.hilly_share, config.max_slope);
    if key.stream("suburb/motorway share").chance(config.motorway_share) {
        let motorway = Motorway::draw(&mut key.stream("suburb/motorway"));
        let xodr = motorway_writer::write("motorway", &motorway, &relief.flattened(MOTORWAY_VERTICAL_RADIUS_M));
        let network = opendrive::load("motorway", &xodr)?;
        return Ok(Suburb { xodr, network });
    }
    let plan = street_plan::draw(key, config);
    let mut stream = key.stream("suburb/crossfall");
    let crossfall: Vec<f64> = plan.streets.iter().map(|_| draw_crossfall(&mut stream)).collect();
    let xodr = writer::write("suburb", &plan, &relief, &crossfall);
    let network = opendrive::load("suburb", &xodr)?;
    Ok(Suburb { xodr, network })
}
