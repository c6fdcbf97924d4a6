//! Where props stand, and how often.

use super::reader::{Fault, Result, Table};

/// Which streets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Streets {
    /// Every street.
    All,
    /// Those of terraces, villages, and blocks of flats.
    Urban,
    /// All others.
    Suburban,
}

/// Whose gardens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Homes {
    /// Of houses.
    Houses,
    /// Of blocks of flats.
    Flats,
}

/// What a prop in a garden looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Facing {
    /// The street.
    Street,
    /// The street or the house.
    Either,
    /// Along the street.
    Along,
}

/// At the outer edge of sidewalks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtSidewalk {
    /// One every so many meters on average, in a common suburb.
    pub every_m: f64,
    /// In which streets.
    pub streets: Streets,
    /// Whether it looks at the traffic that comes along on its side, as signs do, not at the street.
    pub faces_traffic: bool,
}

/// In parking places along streets, instead of a car.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InBay {
    /// The share of the places.
    pub share: f64,
    /// Whether it stands as a car would, not across it.
    pub is_ahead: bool,
    /// Whether there is a barrier at both ends.
    pub has_barriers: bool,
}

/// In front gardens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InGarden {
    /// How likely it is as compared with others.
    pub weight: f64,
    /// Whose gardens.
    pub homes: Homes,
    /// The least and the greatest number that stand beside each other.
    pub count: (usize, usize),
    /// What it looks at.
    pub facing: Facing,
    /// Whether it stands beside or behind the house, not before it.
    pub is_behind: bool,
}

/// A rule by which a prop is placed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// At sidewalks.
    Sidewalk(AtSidewalk),
    /// In parking places.
    Bay(InBay),
    /// In gardens.
    Garden(InGarden),
    /// On vacant plots where people keep what they use now and then: how likely as compared with others.
    Yard(f64),
}

impl Place {
    pub(super) fn read(table: &mut Table) -> Result<Self> {
        let spot = table.need("where")?;
        let weight = |table: &mut Table| table.need("weight")?.number(1e-6, 1e3);
        let place = match spot.string()? {
            "sidewalk" => {
                let known = [("all", Streets::All), ("urban", Streets::Urban), ("suburban", Streets::Suburban)];
                let streets = table.take("streets").map_or(Ok(Streets::All), |v| v.one_of(&known))?;
                let faces = [("street", false), ("traffic", true)];
                Self::Sidewalk(AtSidewalk {
                    every_m: table.need("every_m")?.number(1.0, 1e5)?,
                    streets,
                    faces_traffic: table.take("faces").map_or(Ok(false), |v| v.one_of(&faces))?,
                })
            }
            "bay" => {
                let stands = [("ahead", true), ("across", false)];
                Self::Bay(InBay {
                    share: table.need("share")?.number(1e-6, 0.3)?,
                    is_ahead: table.take("stands").map_or(Ok(false), |v| v.one_of(&stands))?,
                    has_barriers: table.take("barriers").map_or(Ok(false), |v| v.boolean())?,
                })
            }
            "garden" => {
                let homes = [("houses", Homes::Houses), ("flats", Homes::Flats)];
                let faces = [("street", Facing::Street), ("either", Facing::Either), ("along", Facing::Along)];
                let sides = [("front", false), ("behind", true)];
                let count = table.take("count");
                let [least, most] = count.as_ref().map_or(Ok([1.0; 2]), |v| v.numbers::<2>(1.0, 12.0))?;
                if least.fract() != 0.0 || most.fract() != 0.0 || least > most {
                    return Err(Fault::new(table.line, "count: expected two whole numbers, the least first"));
                }
                Self::Garden(InGarden {
                    weight: weight(table)?,
                    homes: table.take("homes").map_or(Ok(Homes::Houses), |v| v.one_of(&homes))?,
                    count: (least as usize, most as usize),
                    facing: table.take("faces").map_or(Ok(Facing::Street), |v| v.one_of(&faces))?,
                    is_behind: table.take("side").map_or(Ok(false), |v| v.one_of(&sides))?,
                })
            }
            "yard" => Self::Yard(weight(table)?),
            name => return Err(spot.fault(format!("unknown place {name:?}; known: sidewalk, bay, garden, yard"))),
        };
        table.end()?;
        Ok(place)
    }
}
