//! What kind of suburb is generated.

use cadet_base::error::{Error, Result};
use cadet_base::settings;

settings! {
    /// What kind of suburb to generate.
    SuburbConfig;
    others {}
    numbers {
        /// Number of blocks from side to side, in two directions.
        blocks: (usize, usize) = (4, 4), 2 to 12;
        /// Shortest and longest block, meters.
        block_m: (f64, f64) = (72.0, 112.0), 60 to 350;
        /// Share of curbs with parking bays on streets wide enough for them.
        parking_share: f64 = 0.55, 0 to 1;
        /// Share of the streets with bays where cars stand at an angle or across in some of them.
        angled_share: f64 = 0.3, 0 to 1;
        /// Share of the streets faster than 30 km/h that are main roads: two lanes a direction, a green median, or both.
        main_share: f64 = 0.0, 0 to 1;
        /// Share of the streets faster than 30 km/h with a lane for bicycles on both sides of the carriageway.
        cycle_lane_share: f64 = 0.0, 0 to 1;
        /// Narrowest and widest sidewalk of streets other than main roads, meters.
        sidewalk_m: (f64, f64) = (1.5, 2.5), 1.2 to 4.5;
        /// Share of the junctions of streets faster than 30 km/h that have traffic lights.
        signal_share: f64 = 0.0, 0 to 1;
        /// Share of the junctions of streets with one lane a direction that are roundabouts, in town.
        roundabout_share: f64 = 0.0, 0 to 1;
        /// Share of the main roads across a suburb with the two tracks of a tram in the middle, instead of any median.
        tram_share: f64 = 0.0, 0 to 1;
        /// Share of suburbs that are open country: winding roads between fields and woods, without curbs or sidewalks.
        country_share: f64 = 0.0, 0 to 1;
        /// Share of the streets of 30 km/h that are aisles of car parks: bays across on both sides, 20 km/h.
        aisle_share: f64 = 0.0, 0 to 1;
        /// Share of the streets that are those of commercial areas: carriageways of 6.5 to 7.5 m, 50 km/h.
        industrial_share: f64 = 0.0, 0 to 1;
        /// Share of suburbs that are campuses: lanes of 4.5 to 5 m, paved with setts, without curbs, 10 or 20 km/h.
        campus_share: f64 = 0.0, 0 to 1;
        /// Share of suburbs that are a motorway or a bypass instead: two carriageways that close on themselves, in open
        /// country.
        motorway_share: f64 = 0.0, 0 to 1;
        /// Share of suburbs with hill streets.
        hilly_share: f64 = 0.2, 0 to 1;
        /// Steepest slope of a hilly suburb.
        max_slope: f64 = 0.065, 0 to 0.1;
    }
}

impl SuburbConfig {
    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], naming the value and its limits.
    pub fn check(&self) -> Result<()> {
        self.check_settings()?;
        for (what, range, expected) in
            [("block_m", self.block_m, "shortest <= longest"), ("sidewalk_m", self.sidewalk_m, "narrowest <= widest")]
        {
            if range.0 > range.1 {
                let value = format!("{range:?}");
                return Err(Error::OutOfRange { what, value, expected: expected.to_owned() });
            }
        }
        Ok(())
    }
}
