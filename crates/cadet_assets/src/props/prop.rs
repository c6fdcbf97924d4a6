//! A prop: its parts list, and the models that have been made of it.

use std::sync::Arc;

use super::builder::{Choice, mesh, scope_of};
use super::expression::{Expression, Scope};
use super::names::check as check_names;
use super::parts_list::PartsList;
use super::place::Place;
use super::reader::{Fault, Result as Read};
use super::surface::Library;
use crate::scenery::materials::plant_palette;
use crate::scenery::{Detail, Head, OVERHEAD_M, SceneryModel, StreetLight};
use cadet_base::error::Result;
use cadet_base::geometry::{Bounds, Memo};
use cadet_base::material::Palette;
use cadet_base::math::{DVec2, DVec3, Vec3};
use cadet_base::rng::Stream;

/// What stands about and is rigid: a bin, a bench, a lamp post. Its front faces +x.
#[derive(Debug)]
pub struct Prop {
    design: Arc<Design>,
    models: Memo<(usize, usize), SceneryModel>,
}

/// A prop's file, read.
#[derive(Debug)]
struct Design {
    name: String,
    file: String,
    text: String,
    list: PartsList,
}

/// A prop of one size in the colors of one that is placed.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Its shape.
    pub model: SceneryModel,
    /// Its colors.
    pub palette: Arc<Palette>,
    /// Where people may sit on it, looking along +x.
    pub seats: Vec<DVec3>,
}

/// Props are the same if their files are.
impl PartialEq for Prop {
    fn eq(&self, other: &Self) -> bool {
        (self.name(), &self.design.text) == (other.name(), &other.design.text)
    }
}

impl Prop {
    /// Parses a prop's file; `name` is the file's name without its folder and its ending.
    ///
    /// # Errors
    /// [`cadet_base::error::Error::File`], naming file, line, and reason.
    pub(super) fn parse(name: &str, file: &str, text: &str, library: &Library) -> Result<Self> {
        let list = PartsList::parse(text, library).and_then(|list| check_names(&list).map(|()| list));
        let list = list.map_err(|fault| fault.in_file(file))?;
        let (name, file, text) = (name.to_owned(), file.to_owned(), text.to_owned());
        Ok(Self { design: Arc::new(Design { name, file, text, list }), models: Memo::new() })
    }

    /// Draws everything once, so that nothing can fail later.
    ///
    /// # Errors
    /// [`cadet_base::error::Error::File`], naming file, line, and reason.
    pub(super) fn check(&self) -> Result<()> {
        let design = &self.design;
        (0..self.num_variants())
            .try_for_each(|variant| {
                for length_m in design.lengths_m() {
                    for detail in [Detail::Near, Detail::Mid, Detail::Far] {
                        mesh(&design.list, &design.name, Choice { variant, length_m, detail })?;
                    }
                }
                design.palette(variant, &mut Stream::from_seed(&design.name, variant as u64))?;
                design.seats(variant)?;
                design.lamp(variant).map(|_| ())
            })
            .map_err(|fault| fault.in_file(&design.file))
    }

    /// Its name, which no other prop has.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.design.name
    }

    /// The rules by which it is placed.
    #[must_use]
    pub fn places(&self) -> &[Place] {
        &self.design.list.places
    }

    /// In how many sizes it comes.
    #[must_use]
    pub fn num_variants(&self) -> usize {
        self.design.list.variants
    }

    /// How many lengths it comes in; 1 for what is no piece of something long.
    #[must_use]
    pub fn num_pieces(&self) -> usize {
        self.design.list.lengths_m.len().max(1)
    }

    /// One of its sizes; a larger number wraps.
    #[must_use]
    pub fn model(&self, variant: usize) -> SceneryModel {
        self.piece(variant, 0)
    }

    /// A piece along +x, of one of its lengths; its middle is y = 0.
    #[must_use]
    pub fn piece(&self, variant: usize, piece: usize) -> SceneryModel {
        let variant = variant % self.num_variants();
        self.models.get((variant, piece), || Arc::clone(&self.design).model(variant, piece))
    }

    /// Any of its sizes, in any of its colors.
    #[must_use]
    pub fn draw(&self, s: &mut Stream) -> Drawn {
        let variant = s.below(self.num_variants());
        self.draw_variant(variant, s)
    }

    /// One of its sizes, in any of its colors; a larger number wraps.
    #[must_use]
    pub fn draw_variant(&self, variant: usize, s: &mut Stream) -> Drawn {
        let variant = variant % self.num_variants();
        let seats = self.design.sound(self.design.seats(variant));
        Drawn { model: self.model(variant), palette: self.palette(variant, s), seats }
    }

    /// Draws the colors of one that is placed.
    #[must_use]
    pub fn palette(&self, variant: usize, s: &mut Stream) -> Arc<Palette> {
        self.design.sound(self.design.palette(variant % self.num_variants(), s))
    }

    /// Its palette with its lamp lit at night; the palette itself where there is none.
    #[must_use]
    pub fn lit(&self, light: StreetLight, variant: usize, palette: &Arc<Palette>) -> Arc<Palette> {
        let lamp = self.design.sound(self.design.lamp(variant % self.num_variants()));
        lamp.map_or_else(|| Arc::clone(palette), |head| light.lit(palette, &head))
    }
}

impl Design {
    /// The lengths that it comes in, the longest first; 0 for what has no length of its own.
    fn lengths_m(&self) -> Vec<f64> {
        if self.list.lengths_m.is_empty() { vec![0.0] } else { self.list.lengths_m.clone() }
    }

    /// What was made without a fault: files are checked when they are read.
    ///
    /// # Panics
    /// Where there is a fault, which is a bug.
    fn sound<T>(&self, made: Read<T>) -> T {
        made.unwrap_or_else(|fault| panic!("{}", fault.in_file(&self.file)))
    }

    fn model(self: Arc<Self>, variant: usize, piece: usize) -> SceneryModel {
        let length_m = self.lengths_m()[piece];
        let name = match self.list.lengths_m.len() {
            0 | 1 => format!("{}/{variant}", self.name),
            _ => format!("{}/{variant}/{length_m}", self.name),
        };
        let palette = self.sound(self.palette(variant, &mut Stream::from_seed(&name, 0)));
        let design = Arc::clone(&self);
        let shape = Detail::levels(self.list.levels_m, move |detail| {
            design.sound(mesh(&design.list, &design.name, Choice { variant, length_m, detail }))
        });
        let is_piece = length_m > 0.0;
        let low = |p: &Vec3| is_piece || f64::from(p.z) < OVERHEAD_M;
        let below = Bounds::of(shape.finest().places().filter(low));
        let (low, high) = (below.min.truncate().as_dvec2(), below.max.truncate().as_dvec2());
        let (footprint_min, footprint_max) = if is_piece {
            let half_m = high.y.max(-low.y);
            (DVec2::new(0.0, -half_m), DVec2::new(length_m, half_m))
        } else {
            (low, high)
        };
        let height_m = f64::from(shape.bounds.max.z);
        SceneryModel { name, shape, palette, footprint_min, footprint_max, height_m }
    }

    fn palette(&self, variant: usize, s: &mut Stream) -> Read<Arc<Palette>> {
        let mut scope = Scope::new(s.clone());
        scope.add("variant", variant as f64);
        let mut materials = Vec::new();
        if let Some((line, is_evergreen)) = &self.list.plant {
            let is_evergreen = is_evergreen.value(&mut scope).map_err(Fault::at(*line))? != 0.0;
            materials.extend_from_slice(plant_palette(&mut scope.stream, is_evergreen).materials());
        }
        for surface in &self.list.surfaces {
            materials.push(surface.draw(&mut scope)?);
        }
        *s = scope.stream;
        Ok(Arc::new(Palette::new(materials)))
    }

    /// The names of a variant's sizes.
    fn scope(&self, variant: usize) -> Read<Scope<'_>> {
        let choice = Choice { variant, length_m: self.lengths_m()[0], detail: Detail::Near };
        scope_of(&self.list, &self.name, choice)
    }

    fn seats(&self, variant: usize) -> Read<Vec<DVec3>> {
        let seats = self.list.seats.iter();
        seats.map(|seat| place(&seat.at, &mut self.scope(variant)?).map_err(Fault::at(seat.line))).collect()
    }

    fn lamp(&self, variant: usize) -> Read<Option<Head>> {
        for lamp in &self.list.lamps {
            let mut scope = self.scope(variant)?;
            let is_on = lamp.when.as_ref().map_or(Ok(1.0), |e| e.value(&mut scope)).map_err(Fault::at(lamp.line))?;
            if is_on != 0.0 {
                let at = place(&lamp.at, &mut scope).map_err(Fault::at(lamp.line))?.as_vec3();
                return Ok(Some(Head { at, ..lamp.head }));
            }
        }
        Ok(None)
    }
}

fn place(at: &[Expression], scope: &mut Scope) -> std::result::Result<DVec3, String> {
    let numbers = at.iter().map(|e| e.value(scope)).collect::<std::result::Result<Vec<f64>, String>>()?;
    Ok(DVec3::from_slice(&numbers))
}
