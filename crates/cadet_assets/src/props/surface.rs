//! Materials as files of props state them: colors to draw from, and what they return to the laser.

use std::collections::BTreeMap;

use super::expression::{Expression, Scope, index};
use super::reader::{Definition, Fault, Result, Table, Value, define, read_file};
use crate::scenery::materials::jitter;
use cadet_base::material::{LidarMaterial, Material, Pattern, Semantic};

/// The classes that props may have in the semantic image.
pub(super) const SEMANTICS: [(&str, Semantic); 10] = [
    ("furniture", Semantic::Furniture),
    ("pole", Semantic::Pole),
    ("traffic_sign", Semantic::TrafficSign),
    ("fence", Semantic::Fence),
    ("building", Semantic::Building),
    ("vegetation", Semantic::Vegetation),
    ("terrain", Semantic::Terrain),
    ("sidewalk", Semantic::Sidewalk),
    ("road", Semantic::Road),
    ("other_vehicle", Semantic::OtherVehicle),
];
const PATTERNS: [(&str, Pattern); 10] = [
    ("plain", Pattern::Plain),
    ("asphalt", Pattern::Asphalt),
    ("slabs", Pattern::Slabs),
    ("blocks", Pattern::Blocks),
    ("bricks", Pattern::Bricks),
    ("render", Pattern::Render),
    ("tiles", Pattern::Tiles),
    ("grass", Pattern::Grass),
    ("wood", Pattern::Wood),
    ("cloth", Pattern::Cloth),
];

/// A check of an expression, given its line and the names that it may use besides the given ones.
pub(super) type CheckNames<'a> = dyn FnMut(&Expression, usize, &[String]) -> Result<()> + 'a;

/// A color: linear R, G, B.
#[derive(Debug, Clone)]
enum Color {
    Fixed([f32; 3]),
    Drawn {
        line: usize,
        sizes: Vec<Definition>,
        rgb: Vec<Expression>,
    },
    /// One of them, all equally likely if the material says no more.
    OneOf(Vec<Self>),
}

/// A material to be drawn.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    line: usize,
    color: Color,
    /// Which of the colors.
    pub which: Option<Expression>,
    /// How much the brightness, and each of the three colors, differ between instances.
    vary: Option<[f64; 2]>,
    /// The share of instances that throw light back to where it comes from.
    retro: f64,
    /// The class, if it has one of its own.
    semantic: Option<Semantic>,
    material: Material,
}

/// The colors and materials that all files know.
#[derive(Debug, Default)]
pub(super) struct Library {
    colors: BTreeMap<String, Color>,
    materials: BTreeMap<String, Surface>,
}

impl Library {
    /// Parses a file with `[colors]` and `[materials]`.
    ///
    /// # Errors
    /// A fault with its line.
    pub(super) fn parse(text: &str) -> Result<Self> {
        read_file(text, |mut table| {
            let mut library = Self::default();
            for (name, value) in table.need("colors")?.table()?.rest() {
                library.colors.insert(name.to_owned(), Color::read(&value, &library)?);
            }
            for (name, value) in table.need("materials")?.table()?.rest() {
                let surface = Surface::read(&mut value.table()?, &library, Semantic::Furniture)?;
                library.materials.insert(name.to_owned(), surface);
            }
            table.end()?;
            Ok(library)
        })
    }

    pub(super) fn material(&self, name: &str) -> Option<&Surface> {
        self.materials.get(name)
    }

    /// The names of the materials.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.materials.keys().map(String::as_str)
    }
}

impl Color {
    fn read(value: &Value, library: &Library) -> Result<Self> {
        if value.is_string() {
            let name = value.string()?;
            let known = || library.colors.keys().cloned().collect::<Vec<_>>().join(", ");
            let color = library.colors.get(name);
            return color.cloned().ok_or_else(|| value.fault(format!("unknown color {name:?}; known: {}", known())));
        }
        if !value.is_array() {
            let mut table = value.table()?;
            let sizes = table.take("let").map_or(Ok(Vec::new()), |v| v.definitions())?;
            let color = Self::Drawn { line: value.line(), sizes, rgb: table.need("rgb")?.tuple(3)? };
            table.end()?;
            return Ok(color);
        }
        let values = value.array()?;
        match values.first() {
            None => Err(value.fault("expected a color")),
            Some(first) if first.is_string() || first.is_array() => {
                Ok(Self::OneOf(values.iter().map(|v| Self::read(v, library)).collect::<Result<_>>()?))
            }
            Some(_) => value.numbers(0.0, 1.0).map(|rgb: [f64; 3]| Self::Fixed(rgb.map(|c| c as f32))),
        }
    }

    fn draw<'a>(&'a self, which: Option<f64>, scope: &mut Scope<'a>) -> std::result::Result<[f32; 3], Fault> {
        match self {
            Self::Fixed(rgb) => Ok(*rgb),
            Self::OneOf(colors) => {
                let chosen = match which {
                    Some(value) => index(value, colors.len()).map_err(Fault::at(0))?,
                    None => scope.stream.below(colors.len()),
                };
                colors[chosen].draw(None, scope)
            }
            Self::Drawn { line, sizes, rgb } => {
                let mark = scope.mark();
                define(sizes, scope)?;
                let mut drawn = [0.0; 3];
                for (value, expression) in drawn.iter_mut().zip(rgb.iter()) {
                    *value = expression.value(scope).map_err(Fault::at(*line))?.clamp(0.0, 1.0) as f32;
                }
                scope.forget(mark);
                Ok(drawn)
            }
        }
    }

    fn visit(&self, names: &mut Vec<String>, check: &mut CheckNames) -> Result<()> {
        match self {
            Self::Fixed(_) => Ok(()),
            Self::OneOf(colors) => colors.iter().try_for_each(|color| color.visit(names, check)),
            Self::Drawn { line, sizes, rgb } => {
                let mark = names.len();
                for definition in sizes {
                    check(&definition.expression, definition.line, names)?;
                    names.push(definition.name.clone());
                }
                rgb.iter().try_for_each(|e| check(e, *line, names))?;
                names.truncate(mark);
                Ok(())
            }
        }
    }
}

impl Surface {
    /// Reads a material; `like` another of the library it differs from that in what it states.
    pub(super) fn read(table: &mut Table, library: &Library, semantic: Semantic) -> Result<Self> {
        let base = match table.take("like") {
            Some(value) => {
                let name = value.string()?;
                let known = || library.names().collect::<Vec<_>>().join(", ");
                let base = library.material(name).cloned().map(|surface| surface.of_class(semantic));
                Some(base.ok_or_else(|| value.fault(format!("unknown material {name:?}; known: {}", known())))?)
            }
            None => None,
        };
        let matt = Material::matt(semantic, [0.5; 3], Pattern::Plain, 0.3);
        let stated = (table.take("color"), table.take("reflectance"));
        let mut surface = match (base, &stated) {
            (Some(base), _) => Self { line: table.line, ..base },
            (None, (Some(_), Some(_))) => Self {
                line: table.line,
                color: Color::Fixed([0.5; 3]),
                which: None,
                vary: None,
                retro: 0.0,
                semantic: None,
                material: matt,
            },
            _ => {
                let reason = "expected color and reflectance, or like = another material";
                return Err(Fault::new(table.line, reason));
            }
        };
        if let Some(value) = stated.0 {
            (surface.color, surface.which) = (Color::read(&value, library)?, None);
        }
        if let Some(value) = table.take("which") {
            surface.which = Some(value.expression()?);
        }
        if let Some(value) = table.take("vary") {
            surface.vary = Some(value.numbers(0.0, 0.9)?);
        }
        if let Some(value) = table.take("retro") {
            surface.retro = value.number(0.0, 1.0)?;
        }
        if let Some(value) = table.take("semantic") {
            surface.semantic = Some(value.one_of(&SEMANTICS)?);
        }
        if let Some(value) = table.take("pattern") {
            surface.material.pattern = value.one_of(&PATTERNS)?;
        }
        let share = |value: Option<Value>, field: &mut f32| -> Result<()> {
            if let Some(value) = value {
                *field = value.number(0.0, 1.0)? as f32;
            }
            Ok(())
        };
        let Material { roughness, specular, transmission, lidar, .. } = &mut surface.material;
        share(stated.1, &mut lidar.reflectance)?;
        share(table.take("roughness"), roughness)?;
        share(table.take("specular"), specular)?;
        share(table.take("transmission"), transmission)?;
        share(table.take("lidar_transmission"), &mut lidar.transmission)?;
        if let Some(value) = table.take("lacquered") {
            lidar.coat_index = if value.boolean()? { LidarMaterial::LACQUER_INDEX } else { 1.0 };
        }
        table.end()?;
        surface.material.semantic = surface.semantic.unwrap_or(semantic);
        Ok(surface)
    }

    /// A material of the library in a prop of a class.
    pub(super) fn of_class(mut self, semantic: Semantic) -> Self {
        self.material.semantic = self.semantic.unwrap_or(semantic);
        self
    }

    /// Draws one.
    pub(super) fn draw<'a>(&'a self, scope: &mut Scope<'a>) -> Result<Material> {
        let which = self.which.as_ref().map(|e| e.value(scope)).transpose().map_err(Fault::at(self.line))?;
        let color = self.color.draw(which, scope).map_err(|fault| Fault { line: self.line, ..fault })?;
        let mut material = self.material;
        material.albedo = match self.vary {
            Some([value, hue]) => jitter(&mut scope.stream, color, value, hue),
            None => color,
        };
        material.lidar.retro = self.retro > 0.0 && scope.stream.chance(self.retro);
        Ok(material)
    }

    /// Hands each expression to `check` with its line and the names that it may use besides.
    pub(super) fn visit(&self, check: &mut CheckNames) -> Result<()> {
        if let Some(which) = &self.which {
            check(which, self.line, &[])?;
        }
        self.color.visit(&mut Vec::new(), check)
    }
}
