//! A prop's file as types: its sizes, its parts, its materials, and where it stands.

use std::collections::BTreeMap;

use super::expression::Expression;
use super::parser::{Loop, Point};
use super::place::Place;
use super::reader::{Definition, Fault, Result, Table, Value, read_file};
use super::surface::{Library, Surface};
use crate::assets::scenery::Head;
use crate::math::Vec3;

/// Detail levels end no farther from the ego than this, meters.
const FARTHEST_M: f64 = 2000.0;
pub(super) const MOST_VARIANTS: usize = 24;
/// Groups in each other.
const MOST_NESTED: usize = 8;
/// Slots that plants have in any case, in the order of `plant_palette`.
pub(super) const PLANT_MATERIALS: [&str; 4] = ["leaf", "light_leaf", "dark_leaf", "bark"];

/// A prop as its file says.
#[derive(Debug)]
pub(super) struct PartsList {
    /// In how many sizes it comes.
    pub variants: usize,
    /// Where its levels of detail end, meters from the ego.
    pub levels_m: [f32; 3],
    /// Edges sharper than this are seen as edges.
    pub crease_rad: f32,
    /// Lengths that it comes in, if it is a piece of something long.
    pub lengths_m: Vec<f64>,
    pub sizes: Vec<Definition>,
    pub parts: Vec<Part>,
    /// Material by slot. The first four of plants are drawn together: whether such a plant is evergreen.
    pub surfaces: Vec<Surface>,
    pub plant: Option<(usize, Expression)>,
    pub seats: Vec<Seat>,
    pub lamps: Vec<LampHead>,
    pub places: Vec<Place>,
}

/// A solid, or several; see `docs/props.md`.
#[derive(Debug)]
pub(super) struct Part {
    pub line: usize,
    pub loops: Vec<Loop>,
    pub sizes: Vec<Definition>,
    pub when: Option<Expression>,
    pub at: Option<[Expression; 3]>,
    /// Turns about x, y, z, in this order.
    pub turns: [Option<Expression>; 3],
    /// Whether it is drawn mirrored in x or y too.
    pub mirrors: [bool; 2],
    /// Slots, of which `which` chooses one.
    pub slots: Vec<u8>,
    pub which: Option<Expression>,
    pub solid: Solid,
}

#[derive(Debug)]
pub(super) enum Solid {
    Group(Vec<Part>),
    /// Extents about the origin.
    Block([Expression; 3]),
    /// x0, x1, y0, y1, z0, z1.
    Box([Expression; 6]),
    /// Stations: x, y, z, radius.
    Tube {
        stations: Vec<Point>,
        sides: Expression,
    },
    /// An outline in the plane across an axis, and from where to where it is extruded.
    Prism {
        axis: usize,
        outline: Vec<Point>,
        span: [Expression; 2],
    },
    /// Level rings: half extents and z.
    Rings {
        rings: Vec<Point>,
        sides: Expression,
        power: Expression,
        is_hollow: bool,
    },
    /// A torus in the plane of x and z: radius and half thickness.
    Hoop {
        radii: [Expression; 2],
        around: Expression,
        sides: Expression,
    },
    /// A flat face, seen from where its corners run counter-clockwise.
    Face(Vec<Point>),
    /// Rings of points, one for each value of a loop.
    Loft {
        rings: Vec<Loop>,
        sizes: Vec<Definition>,
        points: Vec<Point>,
    },
    /// A cushion of leaves: half extents, foot, and top.
    Bush {
        sizes: [Expression; 4],
        power: Expression,
    },
    /// Stems in leaves: radius of the pot, height of their feet, radius and height of the plant.
    Stems([Expression; 4]),
    /// Letters on a plane that faces +x, from the left end of their middle line.
    Text {
        words: Words,
        height: Expression,
        alignment: Alignment,
    },
}

/// The text on a plane.
#[derive(Debug)]
pub(super) enum Words {
    /// One of several.
    OneOf(Vec<String>, Expression),
    /// A number with so many decimals.
    Number(Expression, usize),
}

/// Which point of a text its place is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Alignment {
    Left,
    Middle,
    Right,
}

/// Where somebody may sit, looking along +x.
#[derive(Debug)]
pub(super) struct Seat {
    pub line: usize,
    pub at: [Expression; 3],
}

/// What shines at night.
#[derive(Debug)]
pub(super) struct LampHead {
    pub line: usize,
    pub when: Option<Expression>,
    pub at: [Expression; 3],
    /// All but its place.
    pub head: Head,
}

/// The names of materials that parts have asked for, and in which line first, by slot.
struct Slots(Vec<(String, usize)>);

impl Slots {
    fn of(&mut self, value: Value) -> Result<u8> {
        let name = value.string()?;
        let slot = self.0.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
            self.0.push((name.to_owned(), value.line()));
            self.0.len() - 1
        });
        u8::try_from(slot).ok().filter(|slot| *slot < 60).ok_or_else(|| value.fault("more than 60 materials"))
    }

    fn list(&mut self, value: Value) -> Result<Vec<u8>> {
        let values = if value.is_array() { value.array()? } else { vec![value] };
        values.into_iter().map(|value| self.of(value)).collect()
    }
}

impl PartsList {
    /// Parses a file; `library` has the materials and colors that all files know.
    ///
    /// # Errors
    /// A fault with its line.
    pub(super) fn parse(text: &str, library: &Library) -> Result<Self> {
        read_file(text, |mut table| Self::read(&mut table, library))
    }

    fn read(table: &mut Table, library: &Library) -> Result<Self> {
        let semantic = match table.take("semantic") {
            Some(value) => value.one_of(&super::surface::SEMANTICS)?,
            None => crate::material::Semantic::Furniture,
        };
        let variants = table.take("variants").map_or(Ok(6), |v| v.whole(1, MOST_VARIANTS))?;
        let levels = table.need("levels_m")?;
        let levels_m = levels.numbers::<3>(1.0, FARTHEST_M)?;
        if levels_m[0] > levels_m[1] || levels_m[1] > levels_m[2] {
            return Err(levels.fault("expected rising distances"));
        }
        let crease_rad = table.take("crease_rad").map_or(Ok(0.7), |v| v.number(0.0, 3.2))? as f32;
        let lengths = table.take("lengths_m").map_or(Ok(Vec::new()), |v| v.array())?;
        let lengths_m = lengths.iter().map(|v| v.number(0.1, 50.0)).collect::<Result<_>>()?;
        let sizes = table.take("let").map_or(Ok(Vec::new()), |v| v.definitions())?;
        let plant = table.take("plant").map(|v| Ok((v.line(), v.expression()?))).transpose()?;
        let mut slots = Slots(Vec::new());
        if plant.is_some() {
            slots.0.extend(PLANT_MATERIALS.map(|name| (name.to_owned(), table.line)));
        }
        let lamps = table.take("lamp").map_or(Ok(Vec::new()), |v| v.array())?;
        let lamps = lamps.iter().map(|v| LampHead::read(&mut v.table()?, &mut slots)).collect::<Result<_>>()?;
        let parts = parts(&table.need("parts")?, &mut slots, (&[], None), 0)?;
        let seats = table.take("seat").map_or(Ok(Vec::new()), |v| v.array())?;
        let seats = seats.iter().map(|v| Seat::read(&mut v.table()?)).collect::<Result<_>>()?;
        let places = table.take("place").map_or(Ok(Vec::new()), |v| v.array())?;
        let places = places.iter().map(|v| Place::read(&mut v.table()?)).collect::<Result<_>>()?;
        let mut own: BTreeMap<&str, Surface> = BTreeMap::new();
        if let Some(value) = table.take("materials") {
            for (name, value) in value.table()?.rest() {
                own.insert(name, Surface::read(&mut value.table()?, library, semantic)?);
                if !slots.0.iter().any(|(used, _)| used == name) {
                    return Err(value.fault("no part is made of it"));
                }
            }
        }
        let first = if plant.is_some() { PLANT_MATERIALS.len() } else { 0 };
        let surface = |(name, line): &(String, usize)| {
            let shared = || library.material(name).map(|surface| surface.clone().of_class(semantic));
            own.remove(name.as_str()).or_else(shared).ok_or_else(|| {
                let known = library.names().collect::<Vec<_>>().join(", ");
                Fault::new(*line, format!("of: unknown material {name:?}; known besides [materials]: {known}"))
            })
        };
        let surfaces = slots.0[first..].iter().map(surface).collect::<Result<_>>()?;
        table.end()?;
        let levels_m = levels_m.map(|m| m as f32);
        Ok(Self { variants, levels_m, crease_rad, lengths_m, sizes, parts, surfaces, plant, seats, lamps, places })
    }
}

fn parts(value: &Value, slots: &mut Slots, above: (&[u8], Option<&Expression>), depth: usize) -> Result<Vec<Part>> {
    if depth > MOST_NESTED {
        return Err(value.fault(format!("groups are nested more than {MOST_NESTED} times")));
    }
    value.array()?.iter().map(|part| Part::read(&mut part.table()?, slots, above, depth)).collect()
}

impl Part {
    /// Reads a part; what it is made of, if it does not say so, is what the group `above` is made of.
    fn read(table: &mut Table, slots: &mut Slots, above: (&[u8], Option<&Expression>), depth: usize) -> Result<Self> {
        let line = table.line;
        let expression = |value: Option<Value>| value.map(|v| v.expression()).transpose();
        let (slots_here, which) = match table.take("of") {
            Some(value) => (slots.list(value)?, expression(table.take("which"))?),
            None => (above.0.to_vec(), above.1.cloned()),
        };
        let loops = table.take("for").map_or(Ok(Vec::new()), |v| v.loops())?;
        let sizes = table.take("let").map_or(Ok(Vec::new()), |v| v.definitions())?;
        let when = expression(table.take("when"))?;
        let at = table.take("at").map(|v| v.tuple()).transpose()?;
        let turns = [
            expression(table.take("turn_x_rad"))?,
            expression(table.take("turn_y_rad"))?,
            expression(table.take("turn_z_rad"))?,
        ];
        let mirror = [("x", [true, false]), ("y", [false, true]), ("xy", [true, true])];
        let mirrors = table.take("mirror").map_or(Ok([false; 2]), |v| v.one_of(&mirror))?;
        let solid = match table.take("parts") {
            Some(value) => Solid::Group(parts(&value, slots, (&slots_here, which.as_ref()), depth + 1)?),
            None => Solid::read(table)?,
        };
        table.end()?;
        if slots_here.is_empty() && !matches!(solid, Solid::Group(_) | Solid::Bush { .. } | Solid::Stems(_)) {
            return Err(Fault::new(line, "missing key \"of\": what is it made of?"));
        }
        Ok(Self { line, loops, sizes, when, at, turns, mirrors, slots: slots_here, which, solid })
    }
}

impl Solid {
    fn read(table: &mut Table) -> Result<Self> {
        let number = |table: &mut Table, key, default: f64| {
            table.take(key).map_or(Ok(Expression::Number(default)), |v| v.expression())
        };
        let sides = |table: &mut Table| table.need("sides")?.expression();
        let found = if let Some(value) = table.take("block") {
            Self::Block(value.tuple()?)
        } else if let Some(value) = table.take("box") {
            Self::Box(value.tuple()?)
        } else if let Some(value) = table.take("tube") {
            Self::Tube { stations: value.points(4)?, sides: sides(table)? }
        } else if let Some((axis, value)) =
            ["prism_x", "prism_y", "prism_z"].iter().enumerate().find_map(|(k, key)| Some((k, table.take(key)?)))
        {
            Self::Prism { axis, outline: value.points(2)?, span: table.need("span")?.tuple()? }
        } else if let Some(value) = table.take("rings") {
            let is_hollow = table.take("hollow").map_or(Ok(false), |v| v.boolean())?;
            let power = number(table, "power", 2.0)?;
            Self::Rings { rings: value.points(3)?, sides: sides(table)?, power, is_hollow }
        } else if let Some(value) = table.take("hoop") {
            Self::Hoop { radii: value.tuple()?, around: table.need("around")?.expression()?, sides: sides(table)? }
        } else if let Some(value) = table.take("face") {
            Self::Face(value.points(3)?)
        } else if let Some(value) = table.take("loft") {
            let sizes = table.take("loft_let").map_or(Ok(Vec::new()), |v| v.definitions())?;
            Self::Loft { rings: table.need("along")?.loops()?, sizes, points: value.points(3)? }
        } else if let Some(value) = table.take("bush") {
            Self::Bush { sizes: value.tuple()?, power: number(table, "power", 2.0)? }
        } else if let Some(value) = table.take("stems") {
            Self::Stems(value.tuple()?)
        } else if let Some(value) = table.take("text") {
            let values = if value.is_array() { value.array()? } else { vec![value] };
            let words = values.iter().map(|v| Ok(v.string()?.to_owned())).collect::<Result<_>>()?;
            Self::text(Words::OneOf(words, number(table, "choice", 0.0)?), table)?
        } else if let Some(value) = table.take("number") {
            let decimals = table.take("decimals").map_or(Ok(0), |v| v.whole(0, 3))?;
            Self::text(Words::Number(value.expression()?, decimals), table)?
        } else {
            let known = "parts, block, box, tube, prism_x, prism_y, prism_z, rings, hoop, face, loft, bush, stems, text, number";
            return Err(Fault::new(table.line, format!("expected one of the solids: {known}")));
        };
        Ok(found)
    }
}

impl Solid {
    fn text(words: Words, table: &mut Table) -> Result<Self> {
        let alignments = [("left", Alignment::Left), ("middle", Alignment::Middle), ("right", Alignment::Right)];
        let alignment = table.take("align").map_or(Ok(Alignment::Left), |v| v.one_of(&alignments))?;
        Ok(Self::Text { words, height: table.need("height")?.expression()?, alignment })
    }
}

impl Seat {
    fn read(table: &mut Table) -> Result<Self> {
        let seat = Self { line: table.line, at: table.need("at")?.tuple()? };
        table.end()?;
        Ok(seat)
    }
}

impl LampHead {
    fn read(table: &mut Table, slots: &mut Slots) -> Result<Self> {
        let lamp = Self {
            line: table.line,
            when: table.take("when").map(|v| v.expression()).transpose()?,
            at: table.need("at")?.tuple()?,
            head: Head {
                at: Vec3::ZERO,
                is_globe: table.need("beam")?.one_of(&[("cut_off", false), ("globe", true)])?,
                candela: table.need("candela")?.number(1.0, 1e5)? as f32,
                reach_m: table.need("reach_m")?.number(1.0, 100.0)? as f32,
                lens: slots.of(table.need("lens")?)?,
                radiance: table.need("radiance")?.number(0.0, 10.0)? as f32,
            },
        };
        table.end()?;
        Ok(lamp)
    }
}
