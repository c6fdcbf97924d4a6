//! A prop's file as types: its sizes, its parts, its materials, and where it stands.

use std::collections::BTreeMap;

use super::expression::Expression;
use super::parser::{Loop, Point};
use super::place::Place;
use super::reader::{Definition, Fault, Result, Table, Value, read_file};
use super::surface::{Library, Surface};
use crate::scenery::Head;
use cadet_base::math::Vec3;

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
    pub shape: Shape,
    /// Material by slot. The first four of plants are drawn together: whether such a plant is evergreen.
    pub surfaces: Vec<Surface>,
    pub plant: Option<(usize, Expression)>,
    pub seats: Vec<Seat>,
    pub lamps: Vec<LampHead>,
    pub places: Vec<Place>,
}

/// What something is made of: names with their values, and parts.
#[derive(Debug)]
pub(crate) struct Shape {
    pub(super) sizes: Vec<Definition>,
    pub(super) parts: Vec<Part>,
}

/// The slot of a material by the name that stands in a file.
type SlotOf<'s> = dyn FnMut(&Value) -> Result<u8> + 's;

/// A solid, or several; see `docs/props.md`.
#[derive(Debug)]
pub(super) struct Part {
    pub line: usize,
    pub loops: Vec<Loop>,
    pub sizes: Vec<Definition>,
    pub when: Option<Expression>,
    pub at: Option<Vec<Expression>>,
    /// Turns about x, y, z, in this order.
    pub turns: [Option<Expression>; 3],
    /// Whether it is drawn mirrored in x or y too.
    pub mirrors: [bool; 2],
    /// Slots, of which `which` chooses one.
    pub slots: Vec<u8>,
    pub which: Option<Expression>,
    pub solid: Solid,
}

/// A shape, and what its file says of it, as its kind asks for it.
#[derive(Debug)]
pub(super) struct Solid {
    pub kind: Kind,
    /// Its sizes, then those that have keys of their own, in the order of [`Kind::ALL`].
    pub numbers: Vec<Expression>,
    pub points: Vec<Point>,
    /// One ring or row of points for each value of these, and names that are evaluated at each point.
    pub along: Vec<Loop>,
    pub at_points: Vec<Definition>,
    pub words: Vec<String>,
    pub parts: Vec<Part>,
}

/// What a solid is: `docs/props.md` says what the numbers mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Group,
    Block,
    Box,
    Tube,
    /// Along this axis.
    Prism(usize),
    Rings,
    Hoop,
    Face,
    Loft,
    Sheet,
    Bush,
    Stems,
    Text,
    Number,
}

/// What stands at a solid's key: so many numbers, points of so many coordinates, words, or parts.
enum Form {
    Numbers(usize),
    Points(usize),
    Words,
    Parts,
}

type Extra = (&'static str, Option<f64>);

impl Kind {
    /// Each with its key, what stands there, and other keys with their defaults; those without one must be there.
    const ALL: [(&str, Self, Form, &[Extra]); 16] = [
        ("parts", Self::Group, Form::Parts, &[]),
        ("block", Self::Block, Form::Numbers(3), &[]),
        ("box", Self::Box, Form::Numbers(6), &[]),
        ("tube", Self::Tube, Form::Points(4), &[("sides", None)]),
        ("prism_x", Self::Prism(0), Form::Points(2), &[("from", None), ("to", None)]),
        ("prism_y", Self::Prism(1), Form::Points(2), &[("from", None), ("to", None)]),
        ("prism_z", Self::Prism(2), Form::Points(2), &[("from", None), ("to", None)]),
        ("rings", Self::Rings, Form::Points(3), &[("sides", None), ("power", Some(2.0)), ("hollow", Some(0.0))]),
        ("hoop", Self::Hoop, Form::Numbers(2), &[("around", None), ("sides", None)]),
        ("face", Self::Face, Form::Points(3), &[]),
        ("loft", Self::Loft, Form::Points(3), &[]),
        ("sheet", Self::Sheet, Form::Points(3), &[]),
        ("bush", Self::Bush, Form::Numbers(4), &[("power", Some(2.0))]),
        ("stems", Self::Stems, Form::Numbers(4), &[]),
        ("text", Self::Text, Form::Words, &[("choice", Some(0.0)), ("height", None), ("align", Some(0.0))]),
        ("number", Self::Number, Form::Numbers(1), &[("decimals", Some(0.0)), ("height", None), ("align", Some(0.0))]),
    ];
}

/// Where somebody may sit, looking along +x.
#[derive(Debug)]
pub(super) struct Seat {
    pub line: usize,
    pub at: Vec<Expression>,
}

/// What shines at night.
#[derive(Debug)]
pub(super) struct LampHead {
    pub line: usize,
    pub when: Option<Expression>,
    pub at: Vec<Expression>,
    /// All but its place.
    pub head: Head,
}

/// The names of materials that parts have asked for, and in which line first, by slot.
struct Slots(Vec<(String, usize)>);

impl Slots {
    fn of(&mut self, value: &Value) -> Result<u8> {
        let name = value.string()?;
        let slot = self.0.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
            self.0.push((name.to_owned(), value.line()));
            self.0.len() - 1
        });
        u8::try_from(slot).ok().filter(|slot| *slot < 60).ok_or_else(|| value.fault("more than 60 materials"))
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
            None => cadet_base::material::Semantic::Furniture,
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
        let plant = table.take("plant").map(|v| Ok((v.line(), v.expression()?))).transpose()?;
        let mut slots = Slots(Vec::new());
        if plant.is_some() {
            slots.0.extend(PLANT_MATERIALS.map(|name| (name.to_owned(), table.line)));
        }
        let lamps = table.take("lamp").map_or(Ok(Vec::new()), |v| v.array())?;
        let lamps = lamps.iter().map(|v| LampHead::read(&mut v.table()?, &mut slots)).collect::<Result<_>>()?;
        let shape = Shape::read(table, &mut |name| slots.of(name))?;
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
        Ok(Self { variants, levels_m, crease_rad, lengths_m, shape, surfaces, plant, seats, lamps, places })
    }
}

impl Shape {
    /// Reads the keys `let` and `parts`.
    pub(crate) fn read(table: &mut Table, slot_of: &mut SlotOf) -> Result<Self> {
        let sizes = table.take("let").map_or(Ok(Vec::new()), |v| v.definitions())?;
        Ok(Self { sizes, parts: parts(&table.need("parts")?, slot_of, (&[], None), 0)? })
    }
}

fn parts(value: &Value, slot_of: &mut SlotOf, above: (&[u8], Option<&Expression>), depth: usize) -> Result<Vec<Part>> {
    if depth > MOST_NESTED {
        return Err(value.fault(format!("groups are nested more than {MOST_NESTED} times")));
    }
    value.array()?.iter().map(|part| Part::read(&mut part.table()?, slot_of, above, depth)).collect()
}

impl Part {
    /// Reads a part; what it is made of, if it does not say so, is what the group `above` is made of.
    fn read(
        table: &mut Table,
        slot_of: &mut SlotOf,
        above: (&[u8], Option<&Expression>),
        depth: usize,
    ) -> Result<Self> {
        let line = table.line;
        let expression = |value: Option<Value>| value.map(|v| v.expression()).transpose();
        let (slots, which) = match table.take("of") {
            Some(value) => {
                let names = if value.is_array() { value.array()? } else { vec![value] };
                (names.iter().map(&mut *slot_of).collect::<Result<_>>()?, expression(table.take("which"))?)
            }
            None => (above.0.to_vec(), above.1.cloned()),
        };
        let loops = table.take("for").map_or(Ok(Vec::new()), |v| v.loops())?;
        let sizes = table.take("let").map_or(Ok(Vec::new()), |v| v.definitions())?;
        let when = expression(table.take("when"))?;
        let at = table.take("at").map(|v| v.tuple(3)).transpose()?;
        let turns = [
            expression(table.take("turn_x_rad"))?,
            expression(table.take("turn_y_rad"))?,
            expression(table.take("turn_z_rad"))?,
        ];
        let mirror = [("x", [true, false]), ("y", [false, true]), ("xy", [true, true])];
        let mirrors = table.take("mirror").map_or(Ok([false; 2]), |v| v.one_of(&mirror))?;
        let solid = Solid::read(table, slot_of, (&slots, which.as_ref()), depth)?;
        table.end()?;
        if slots.is_empty() && !matches!(solid.kind, Kind::Group | Kind::Bush | Kind::Stems) {
            return Err(Fault::new(line, "missing key \"of\": what is it made of?"));
        }
        Ok(Self { line, loops, sizes, when, at, turns, mirrors, slots, which, solid })
    }
}

impl Solid {
    fn read(table: &mut Table, slot_of: &mut SlotOf, of: (&[u8], Option<&Expression>), depth: usize) -> Result<Self> {
        let found = Kind::ALL.iter().find_map(|solid| Some((solid, table.take(solid.0)?)));
        let Some(((_, kind, form, extras), value)) = found else {
            let known = Kind::ALL.map(|solid| solid.0).join(", ");
            return Err(Fault::new(table.line, format!("expected one of the solids: {known}")));
        };
        let mut solid = Self {
            kind: *kind,
            numbers: Vec::new(),
            points: Vec::new(),
            along: Vec::new(),
            at_points: Vec::new(),
            words: Vec::new(),
            parts: Vec::new(),
        };
        match form {
            Form::Numbers(count) => solid.numbers = value.tuple(*count)?,
            Form::Points(coordinates) => solid.points = value.points(*coordinates)?,
            Form::Words => {
                let values = if value.is_array() { value.array()? } else { vec![value] };
                solid.words = values.iter().map(|v| Ok(v.string()?.to_owned())).collect::<Result<_>>()?;
            }
            Form::Parts => solid.parts = parts(&value, slot_of, of, depth + 1)?,
        }
        if matches!(kind, Kind::Loft | Kind::Sheet) {
            solid.along = table.need("along")?.loops()?;
            solid.at_points = table.take("loft_let").map_or(Ok(Vec::new()), |v| v.definitions())?;
        }
        for (key, default) in *extras {
            let number = match (table.take(key), default) {
                (Some(value), _) => value.expression()?,
                (None, Some(default)) => Expression::Number(*default),
                (None, None) => return Err(Fault::new(table.line, format!("missing key {key:?}"))),
            };
            solid.numbers.push(number);
        }
        Ok(solid)
    }
}

impl Seat {
    fn read(table: &mut Table) -> Result<Self> {
        let seat = Self { line: table.line, at: table.need("at")?.tuple(3)? };
        table.end()?;
        Ok(seat)
    }
}

impl LampHead {
    fn read(table: &mut Table, slots: &mut Slots) -> Result<Self> {
        let lamp = Self {
            line: table.line,
            when: table.take("when").map(|v| v.expression()).transpose()?,
            at: table.need("at")?.tuple(3)?,
            head: Head {
                at: Vec3::ZERO,
                is_globe: table.need("beam")?.one_of(&[("cut_off", false), ("globe", true)])?,
                downward_cd: table.need("candela")?.number(1.0, 1e5)? as f32,
                reach_m: table.need("reach_m")?.number(1.0, 100.0)? as f32,
                lens: slots.of(&table.need("lens")?)?,
                radiance: table.need("radiance")?.number(0.0, 10.0)? as f32,
            },
        };
        table.end()?;
        Ok(lamp)
    }
}
