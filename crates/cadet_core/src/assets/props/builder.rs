//! Draws a parts list: one mesh for each variant, length, and level of detail.

use super::expression::{Expression, Scope, index};
use super::parser::{Loop, Point, Values};
use super::parts_list::{Part, PartsList, Solid, Words};
use super::reader::{Definition, Fault, Result, define};
use crate::assets::scenery::Detail;
use crate::assets::scenery::greens::{Cushion, Stems};
use crate::assets::scenery::leaves::Leaves;
use crate::assets::scenery::letters;
use crate::geometry::{Mesh, MeshBuilder, level_ring};
use crate::math::{self, Mat3, Vec3};
use crate::rng::Stream;

/// A level has no more triangles, and no more parts, points, and repetitions together.
const MOST_TRIANGLES: usize = 20_000;
const MOST_STEPS: usize = 200_000;
/// Nothing reaches farther from the origin.
const REACH_M: f64 = 60.0;
const MOST_SIDES: usize = 96;

/// A result whose fault is described in words; its line comes later.
type Outcome<T> = std::result::Result<T, String>;

/// Which of a prop's meshes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Choice {
    pub variant: usize,
    pub length_m: f64,
    pub detail: Detail,
}

/// The names that every expression knows, and those of the prop's sizes, drawn from the stream of a variant.
pub(super) fn scope_of<'a>(list: &'a PartsList, name: &str, choice: Choice) -> Result<Scope<'a>> {
    // The stream's name is the prop's, in words.
    let mut scope = Scope::new(Stream::from_seed(&name.replace('-', " "), choice.variant as u64));
    let level = choice.detail as usize;
    let is = |other: usize| f64::from(u8::from(level == other));
    let given = [choice.variant as f64, level as f64, is(0), is(1), is(2), choice.length_m];
    super::names::GIVEN.into_iter().zip(given).for_each(|(name, value)| scope.add(name, value));
    define(&list.sizes, &mut scope)?;
    Ok(scope)
}

/// Draws a mesh.
///
/// # Errors
/// An expression without a value, a size that makes no solid, too many triangles, or none.
pub(super) fn mesh(list: &PartsList, name: &str, choice: Choice) -> Result<Mesh> {
    let mut drawing = Drawing {
        scope: scope_of(list, name, choice)?,
        leaves: Leaves::default(),
        detail: choice.detail,
        num_steps: 0,
    };
    let mut solids = MeshBuilder::new();
    for part in &list.parts {
        drawing.repeat(part, &part.loops, &mut solids)?;
    }
    if !drawing.leaves.is_empty() {
        return Ok(drawing.leaves.build(name, &solids));
    }
    // Empty bounds: no face has an area.
    if solids.bounds().min.x > solids.bounds().max.x {
        let which = format!("variant {} has no triangle at level {}", choice.variant, choice.detail as usize);
        return Err(Fault::new(list.parts.first().map_or(1, |part| part.line), which));
    }
    Ok(solids.build(name, list.crease_rad))
}

struct Drawing<'a> {
    scope: Scope<'a>,
    leaves: Leaves,
    detail: Detail,
    num_steps: usize,
}

/// Makes positions of numbers, and refuses those beyond reach.
fn point(numbers: [f64; 3]) -> Outcome<Vec3> {
    match numbers.iter().find(|c| c.abs() > REACH_M) {
        Some(far) => Err(format!("{far} m is farther than {REACH_M} m from the origin")),
        None => Ok(Vec3::from_array(numbers.map(|c| c as f32))),
    }
}

fn positive(value: f64, what: &str) -> Outcome<f64> {
    if value > 0.0 && value <= 2.0 * REACH_M {
        Ok(value)
    } else {
        Err(format!("{what} is {value}, expected more than 0 and at most {} m", 2.0 * REACH_M))
    }
}

impl<'a> Drawing<'a> {
    fn step(&mut self) -> Outcome<()> {
        self.num_steps += 1;
        if self.num_steps > MOST_STEPS { Err(format!("more than {MOST_STEPS} points and repetitions")) } else { Ok(()) }
    }

    fn values<const N: usize>(&mut self, of: &'a [Expression; N]) -> Outcome<[f64; N]> {
        let mut found = [0.0; N];
        for (value, expression) in found.iter_mut().zip(of) {
            *value = expression.value(&mut self.scope)?;
        }
        Ok(found)
    }

    fn sizes<const N: usize>(&mut self, of: &'a [Expression; N]) -> Outcome<[f64; N]> {
        let found = self.values(of)?;
        found.iter().try_for_each(|size| positive(*size, "a size").map(|_| ()))?;
        Ok(found)
    }

    fn count(&mut self, of: &'a Expression) -> Outcome<usize> {
        let value = of.value(&mut self.scope)?;
        if value.fract() == 0.0 && value >= 3.0 && value <= MOST_SIDES as f64 {
            Ok(value as usize)
        } else {
            Err(format!("{value} sides, expected a whole number from 3 to {MOST_SIDES}"))
        }
    }

    /// The values of a loop.
    fn each(&mut self, each: &'a Loop) -> Outcome<Vec<f64>> {
        match &each.values {
            Values::List(list) => list.iter().map(|e| e.value(&mut self.scope)).collect(),
            Values::Range(first, end) => {
                let (first, end) = (first.value(&mut self.scope)?, end.value(&mut self.scope)?);
                let count = (end - first).ceil().max(0.0);
                if count > MOST_STEPS as f64 {
                    return Err(format!("{count} repetitions, expected at most {MOST_STEPS}"));
                }
                Ok((0..count as usize).map(|k| first + k as f64).collect())
            }
        }
    }

    /// Draws a part once for each value of its loops.
    fn repeat(&mut self, part: &'a Part, loops: &'a [Loop], b: &mut MeshBuilder) -> Result<()> {
        let Some((first, rest)) = loops.split_first() else { return self.part(part, b) };
        let mark = self.scope.mark();
        for value in self.each(first).map_err(Fault::at(part.line))? {
            self.scope.add(&first.name, value);
            self.repeat(part, rest, b)?;
            self.scope.forget(mark);
        }
        Ok(())
    }

    fn part(&mut self, part: &'a Part, b: &mut MeshBuilder) -> Result<()> {
        let fault = |reason| Fault::at(part.line)(reason);
        self.step().map_err(fault)?;
        let mark = self.scope.mark();
        if let Some(when) = &part.when
            && when.value(&mut self.scope).map_err(fault)? == 0.0
        {
            return Ok(());
        }
        define(&part.sizes, &mut self.scope)?;
        let chosen = part.which.as_ref().map_or(Ok(0.0), |e| e.value(&mut self.scope));
        let chosen = chosen.and_then(|value| index(value, part.slots.len().max(1))).map_err(fault)?;
        let slot = part.slots.get(chosen).copied().unwrap_or_default();
        let offset = part.at.as_ref().map_or(Ok([0.0; 3]), |at| self.values(at));
        let offset = offset.and_then(point).map_err(fault)?;
        let mut linear = Mat3::IDENTITY;
        for (turn, of_angle) in part.turns.iter().zip([about_x, about_y, about_z]) {
            if let Some(turn) = turn {
                linear = of_angle(turn.value(&mut self.scope).map_err(fault)?) * linear;
            }
        }
        let mut own = MeshBuilder::new();
        match &part.solid {
            Solid::Group(parts) => parts.iter().try_for_each(|inner| self.repeat(inner, &inner.loops, &mut own))?,
            solid => self.solid(solid, slot, &mut own).map_err(fault)?,
        }
        let mut placed = MeshBuilder::new();
        placed.append(&own, linear, offset);
        let across = [Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, -1.0, 1.0)];
        for (_, across) in part.mirrors.iter().zip(across).filter(|(is_mirrored, _)| **is_mirrored) {
            let once = placed.clone();
            placed.append(&once, Mat3::from_diagonal(across), Vec3::ZERO);
        }
        b.append(&placed, Mat3::IDENTITY, Vec3::ZERO);
        self.scope.forget(mark);
        let num_triangles = b.num_faces();
        if num_triangles > MOST_TRIANGLES {
            return Err(fault(format!("{num_triangles} triangles, expected at most {MOST_TRIANGLES}")));
        }
        Ok(())
    }

    /// The points of a list, in the order in which its loops make them.
    fn points<const N: usize>(&mut self, points: &'a [Point], sizes: &'a [Definition]) -> Outcome<Vec<[f64; N]>> {
        let mut found = Vec::new();
        for point in points {
            let mark = self.scope.mark();
            let each = point.each.as_ref();
            let values = each.map_or(Ok(vec![0.0]), |each| self.each(each))?;
            for value in values {
                self.step()?;
                if let Some(each) = each {
                    self.scope.add(&each.name, value);
                }
                define(sizes, &mut self.scope).map_err(|fault| fault.reason)?;
                let mut numbers = [0.0; N];
                for (number, expression) in numbers.iter_mut().zip(&point.coordinates) {
                    *number = expression.value(&mut self.scope)?;
                }
                found.push(numbers);
                self.scope.forget(mark);
            }
        }
        Ok(found)
    }

    /// As [`points`](Self::points): corners of a face or of an outline, of which there must be three or more.
    fn corners<const N: usize>(&mut self, of: &'a [Point]) -> Outcome<Vec<[f64; N]>> {
        let found = self.points(of, &[])?;
        if found.len() < 3 { Err(format!("{} corners, expected 3 or more", found.len())) } else { Ok(found) }
    }

    fn solid(&mut self, solid: &'a Solid, slot: u8, b: &mut MeshBuilder) -> Outcome<()> {
        match solid {
            Solid::Group(_) => {}
            Solid::Block(size) => b.block(Vec3::ZERO, point(self.sizes(size)?)?, slot),
            Solid::Box(sides) => {
                let [x0, x1, y0, y1, z0, z1] = self.values(sides)?;
                [x1 - x0, y1 - y0, z1 - z0].into_iter().try_for_each(|size| positive(size, "a size").map(|_| ()))?;
                b.cuboid(point([x0, y0, z0])?, point([x1, y1, z1])?, slot);
            }
            Solid::Tube { stations, sides } => {
                let sides = self.count(sides)?;
                let stations = self
                    .points::<4>(stations, &[])?
                    .into_iter()
                    .map(|[x, y, z, radius]| Ok((point([x, y, z])?, positive(radius, "a radius")? as f32)));
                let stations = stations.collect::<Outcome<Vec<_>>>()?;
                if stations.len() < 2 || stations[0].0 == stations[stations.len() - 1].0 {
                    return Err("a tube leads from one place to another".to_owned());
                }
                b.tube(&stations, sides, slot);
            }
            Solid::Prism { axis, outline, span } => {
                let corners = self.corners::<2>(outline)?;
                let [from, to] = self.values(span)?;
                positive(to - from, "the span's length")?;
                for [p, q] in &corners {
                    point([*p, *q, 0.0])?;
                }
                point([from, to, 0.0])?;
                let outline: Vec<(f32, f32)> = corners.into_iter().map(|[p, q]| (p as f32, q as f32)).collect();
                b.prism(*axis, &outline, (from as f32, to as f32), slot);
            }
            Solid::Rings { rings, sides, power, is_hollow } => {
                let sides = self.count(sides)?;
                let power = power.raw(&mut self.scope)?;
                if !(power >= 0.5) {
                    return Err(format!("power is {power}, expected 0.5 to inf"));
                }
                let ring = |[x, y, z]: [f64; 3]| {
                    let half = [positive(x, "half an extent")? as f32, positive(y, "half an extent")? as f32];
                    point([0.0, 0.0, z])?;
                    Ok(level_ring(half, z as f32, sides, power as f32))
                };
                let rings = self.points(rings, &[])?.into_iter().map(ring);
                b.loft(&rings.collect::<Outcome<Vec<_>>>()?, slot, !is_hollow);
            }
            Solid::Hoop { radii, around, sides } => {
                let [radius, half_thickness] = self.sizes(radii)?.map(|size| size as f32);
                let counts = (self.count(around)?, self.count(sides)?);
                b.hoop(radius, half_thickness, counts, slot);
            }
            Solid::Face(corners) => {
                let corners = self.corners(corners)?.into_iter().map(point);
                b.polygon(&corners.collect::<Outcome<Vec<_>>>()?, slot);
            }
            Solid::Loft { rings, sizes, points } => {
                let mut made = Vec::new();
                self.loft_rings(rings, (sizes, points), &mut made)?;
                if made.iter().any(|ring: &Vec<Vec3>| ring.len() < 3 || ring.len() != made[0].len()) {
                    return Err("the rings of a loft have the same number of points, 3 or more".to_owned());
                }
                b.loft(&made, slot, true);
            }
            Solid::Bush { sizes, power } => {
                let [half_x, half_y, low, top] = self.values(sizes)?.map(|size| size as f32);
                let power = power.value(&mut self.scope)?;
                if !(half_x > 0.1
                    && half_y > 0.1
                    && top - low > 0.1
                    && half_x.max(half_y).max(top) < 6.0
                    && power >= 1.0)
                {
                    return Err("a bush has half extents and a height of 0.1 to 6 m, and power 1 or more".to_owned());
                }
                let bush = Cushion { half: (half_x, half_y), low, top, power: power as f32 };
                bush.grow(&mut self.scope.stream, b, &mut self.leaves, self.detail);
            }
            Solid::Stems(sizes) => {
                let [pot_m, foot_m, spread_m, top_m] = self.sizes(sizes)?.map(|size| size as f32);
                if spread_m < 0.25 || spread_m > 3.0 || top_m < foot_m + 0.5 || top_m > 6.0 {
                    return Err("stems spread 0.25 to 3 m and rise by 0.5 m or more, to at most 6 m".to_owned());
                }
                let stems = Stems { pot_m, foot_m, spread_m, top_m };
                stems.grow(&mut self.scope.stream, b, &mut self.leaves, self.detail);
            }
            Solid::Text { words, height, alignment } => {
                let height = positive(height.value(&mut self.scope)?, "the letters' height")? as f32;
                let text = match words {
                    Words::OneOf(list, choice) => list[index(choice.value(&mut self.scope)?, list.len())?].clone(),
                    Words::Number(number, decimals) => {
                        format!("{:.*}", *decimals, number.value(&mut self.scope)?).replace('.', ",")
                    }
                };
                let width = letters::width(&text) * height;
                let y = -width * [0.0, 0.5, 1.0][*alignment as usize];
                letters::write(b, &text, Vec3::new(0.0, y, 0.0), height, slot);
            }
        }
        Ok(())
    }

    fn loft_rings(
        &mut self,
        loops: &'a [Loop],
        (sizes, points): (&'a [Definition], &'a [Point]),
        made: &mut Vec<Vec<Vec3>>,
    ) -> Outcome<()> {
        let Some((first, rest)) = loops.split_first() else {
            let ring = self.points(points, sizes)?.into_iter().map(point);
            made.push(ring.collect::<Outcome<_>>()?);
            return Ok(());
        };
        let mark = self.scope.mark();
        for value in self.each(first)? {
            self.scope.add(&first.name, value);
            self.loft_rings(rest, (sizes, points), made)?;
            self.scope.forget(mark);
        }
        Ok(())
    }
}

fn about_x(angle_rad: f64) -> Mat3 {
    let (s, c) = (math::sin(angle_rad) as f32, math::cos(angle_rad) as f32);
    Mat3::from_cols(Vec3::X, Vec3::new(0.0, c, s), Vec3::new(0.0, -s, c))
}

fn about_y(angle_rad: f64) -> Mat3 {
    let (s, c) = (math::sin(angle_rad) as f32, math::cos(angle_rad) as f32);
    Mat3::from_cols(Vec3::new(c, 0.0, -s), Vec3::Y, Vec3::new(s, 0.0, c))
}

fn about_z(angle_rad: f64) -> Mat3 {
    let (s, c) = (math::sin(angle_rad) as f32, math::cos(angle_rad) as f32);
    Mat3::from_cols(Vec3::new(c, s, 0.0), Vec3::new(-s, c, 0.0), Vec3::Z)
}
