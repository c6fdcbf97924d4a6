//! What trucks and trailers carry: files of the crate's folder `bodies`, drawn as props are.

use std::sync::{Arc, LazyLock};

use super::super::levels::LEVELS;
use super::super::paint::{Livery, slot, work_slot};
use super::super::surface::Surface;
use crate::props::{Read, Shape, read_file};
use cadet_base::error::Result;
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::{Mat3, Vec3};
use cadet_base::rng::Stream;

include!(concat!(env!("OUT_DIR"), "/bodies.rs"));

/// All of them.
pub(super) static BODIES: LazyLock<Vec<Body>> = LazyLock::new(|| {
    let parse = |(file, text): &(&'static str, &str)| {
        Body::parse(file, text).unwrap_or_else(|fault| panic!("{}", fault.in_file(file)))
    };
    FILES.iter().flat_map(parse).collect()
});

/// For what a body is chosen: trucks by their length, trailers by what their size allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Size {
    Short,
    Medium,
    Long,
    Semi,
    Flat,
    Heavy,
    Low,
    Small,
    Large,
}

/// Their names in files, in the order of [`Size`].
const SIZES: [&str; 9] = ["short", "medium", "long", "semi", "flat", "heavy", "low", "small", "large"];

/// The top of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Roof {
    /// A level roof, to which a deflector on the cab leads.
    Flat,
    /// Nothing: of a small truck the cab is the highest.
    None,
    /// Anything else.
    Uneven,
}

const ROOFS: [(&str, Roof); 3] = [("flat", Roof::Flat), ("none", Roof::None), ("uneven", Roof::Uneven)];
const LIVERIES: [(&str, Livery); 4] = [
    ("freight", Livery::Freight),
    ("municipal", Livery::Municipal),
    ("fire", Livery::Fire),
    ("trailer", Livery::Trailer),
];

/// What bodies are made of; lamps and signals belong to the chassis.
const MATERIALS: [(&str, u8); 16] = [
    ("load", work_slot::LOAD),
    ("frame", work_slot::FRAME),
    ("alu", work_slot::ALU),
    ("canvas", work_slot::CANVAS),
    ("board", work_slot::BOARD),
    ("amber", work_slot::AMBER),
    ("stripe", work_slot::STRIPE),
    ("cargo", work_slot::CARGO),
    ("beacon", work_slot::BEACON),
    ("lining", work_slot::LINING),
    ("paint", slot::PAINT),
    ("plastic", slot::PLASTIC),
    ("grille", slot::GRILLE),
    ("dark", slot::DARK),
    ("liner", slot::LINER),
    ("chrome", slot::CHROME),
];

/// The names that every expression of a body knows, besides those of its file's kinds.
const GIVEN: [&str; 6] = ["level", "front_x", "rear_x", "half_y", "floor_z", "top_z"];

/// The room that a body takes: behind the cab, or on a trailer's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    pub front_x: f32,
    pub rear_x: f32,
    pub half_y: f32,
    pub floor_z: f32,
    pub top_z: f32,
}

/// What a vehicle carries: a body in its room, or nothing.
pub(super) struct Load {
    pub body: Option<&'static Body>,
    pub room: Room,
    /// What the body's draws come from.
    pub seed: u64,
}

impl Load {
    /// Draws it at every level, so that a fault of its file is an error now and no panic later.
    ///
    /// # Errors
    /// As [`Body::draw`].
    pub fn check(&self) -> Result<()> {
        (0..LEVELS).try_for_each(|level| self.drawn(level).map(drop))
    }

    /// Adds it to a surface; it has been checked.
    pub fn add(&self, surface: &mut Surface, level: usize) {
        let drawn = self.drawn(level).expect("a load that was drawn before");
        surface.builder.append(&drawn, Mat3::IDENTITY, Vec3::ZERO);
    }

    fn drawn(&self, level: usize) -> Result<MeshBuilder> {
        self.body.map_or(Ok(MeshBuilder::new()), |body| body.draw(&self.room, self.seed, level))
    }
}

/// What a file says of all its kinds.
#[derive(Debug)]
pub(super) struct Family {
    file: &'static str,
    names: Vec<String>,
    shape: Shape,
    pub livery: Livery,
    pub roof: Roof,
}

/// A kind of body.
#[derive(Debug)]
pub(super) struct Body {
    pub name: String,
    /// How likely it is as compared with others, by size.
    shares: [f64; SIZES.len()],
    pub family: Arc<Family>,
}

impl Body {
    /// Draws one for a size, or none with the share of what has no body.
    pub fn pick(size: Size, bare_share: f64, s: &mut Stream) -> Option<&'static Self> {
        let shares: Vec<f64> = BODIES.iter().map(|body| body.shares[size as usize]).chain([bare_share]).collect();
        BODIES.get(s.weighted(&shares))
    }

    /// Parses a file: a body for each of its kinds.
    pub fn parse(file: &'static str, text: &str) -> Read<Vec<Self>> {
        read_file(text, |mut table| {
            let livery = table.take("livery").map_or(Ok(Livery::Freight), |v| v.one_of(&LIVERIES))?;
            let roof = table.take("roof").map_or(Ok(Roof::Uneven), |v| v.one_of(&ROOFS))?;
            let (mut names, mut shares_of_all) = (Vec::new(), Vec::new());
            for (name, value) in table.need("kinds")?.table()?.rest() {
                let (mut kind, mut shares) = (value.table()?, [0.0; SIZES.len()]);
                for (share, size) in shares.iter_mut().zip(SIZES) {
                    *share = kind.take(size).map_or(Ok(0.0), |v| v.number(0.0, 1.0))?;
                }
                kind.end()?;
                names.push(name.to_owned());
                shares_of_all.push(shares);
            }
            let shape = Shape::read(&mut table, &mut |name| name.one_of(&MATERIALS))?;
            table.end()?;
            shape.check_names(&GIVEN.into_iter().chain(names.iter().map(String::as_str)).collect::<Vec<_>>())?;
            let family = Arc::new(Family { file, names, shape, livery, roof });
            let kinds = family.names.iter().zip(shares_of_all);
            Ok(kinds.map(|(name, shares)| Self { name: name.clone(), shares, family: Arc::clone(&family) }).collect())
        })
    }

    /// Draws it at a level of detail; the same `seed` makes the same draws at all of them.
    ///
    /// # Errors
    /// [`cadet_base::error::Error::File`] for a file that draws nothing sound in this room.
    pub fn draw(&self, room: &Room, seed: u64, level: usize) -> Result<MeshBuilder> {
        let Room { front_x, rear_x, half_y, floor_z, top_z } = *room;
        let measures = [front_x, rear_x, half_y, floor_z, top_z].map(f64::from);
        let measures = GIVEN.into_iter().zip([level as f64].into_iter().chain(measures));
        let is_of = |name: &String| f64::from(u8::from(*name == self.name));
        let kinds = self.family.names.iter().map(|name| (name.as_str(), is_of(name)));
        let solids = self.family.shape.solids(Stream::from_seed(&self.name, seed), measures.chain(kinds));
        solids.map_err(|fault| fault.in_file(self.family.file))
    }
}
