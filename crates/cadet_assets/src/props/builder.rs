//! Draws a parts list: one mesh for each variant, length, and level of detail.

use super::expression::{Scope, index};
use super::parser::{Loop, Values};
use super::parts_list::{Kind, Part, PartsList, Shape, Solid};
use super::reader::{Fault, Result, define};
use crate::scenery::Detail;
use crate::scenery::greens::{Cushion, Stems};
use crate::scenery::leaves::Leaves;
use crate::scenery::letters;
use cadet_base::geometry::{Mesh, MeshBuilder, level_ring};
use cadet_base::math::{self, Mat3, Vec3};
use cadet_base::rng::Stream;

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
    let level = choice.detail as usize;
    let is = |other: usize| f64::from(u8::from(level == other));
    let given = [choice.variant as f64, level as f64, is(0), is(1), is(2), choice.length_m];
    // The stream's name is the prop's, in words.
    let stream = Stream::from_seed(&name.replace('-', " "), choice.variant as u64);
    list.shape.scope(stream, super::names::GIVEN.into_iter().zip(given))
}

impl Shape {
    /// The names given and its own, of one whose draws come from `stream`.
    fn scope<'a>(&'a self, stream: Stream, given: impl Iterator<Item = (&'a str, f64)>) -> Result<Scope<'a>> {
        let mut scope = Scope::new(stream);
        given.for_each(|(name, value)| scope.add(name, value));
        define(&self.sizes, &mut scope)?;
        Ok(scope)
    }

    /// Its solids alone, without leaves.
    ///
    /// # Errors
    /// An expression without a value, a size that makes no solid, too many triangles, or a plant.
    pub(crate) fn solids<'a>(
        &'a self,
        stream: Stream,
        given: impl Iterator<Item = (&'a str, f64)>,
    ) -> Result<MeshBuilder> {
        let mut drawing = Drawing::new(self.scope(stream, given)?, Detail::Far);
        let solids = drawing.parts(&self.parts)?;
        if !drawing.leaves.is_empty() {
            return Err(Fault::new(self.parts[0].line, "only props have leaves".to_owned()));
        }
        Ok(solids)
    }
}

/// Draws a mesh.
///
/// # Errors
/// An expression without a value, a size that makes no solid, too many triangles, or none.
pub(super) fn mesh(list: &PartsList, name: &str, choice: Choice) -> Result<Mesh> {
    let mut drawing = Drawing::new(scope_of(list, name, choice)?, choice.detail);
    let solids = drawing.parts(&list.shape.parts)?;
    if !drawing.leaves.is_empty() {
        return Ok(drawing.leaves.build(name, &solids));
    }
    // Empty bounds: no face has an area.
    if solids.bounds().min.x > solids.bounds().max.x {
        let which = format!("variant {} has no triangle at level {}", choice.variant, choice.detail as usize);
        return Err(Fault::new(list.shape.parts.first().map_or(1, |part| part.line), which));
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
fn point([x, y, z, _]: [f64; 4]) -> Outcome<Vec3> {
    match [x, y, z].into_iter().find(|c| c.abs() > REACH_M) {
        Some(far) => Err(format!("{far} m is farther than {REACH_M} m from the origin")),
        None => Ok(Vec3::new(x as f32, y as f32, z as f32)),
    }
}

/// A length above 0.
fn size(value: f64) -> Outcome<f32> {
    if value > 0.0 && value <= 2.0 * REACH_M {
        Ok(value as f32)
    } else {
        Err(format!("a size is {value}, expected more than 0 and at most {} m", 2.0 * REACH_M))
    }
}

fn count(sides: f64) -> Outcome<usize> {
    if sides.fract() == 0.0 && sides >= 3.0 && sides <= MOST_SIDES as f64 {
        Ok(sides as usize)
    } else {
        Err(format!("{sides} sides, expected a whole number from 3 to {MOST_SIDES}"))
    }
}

impl<'a> Drawing<'a> {
    fn new(scope: Scope<'a>, detail: Detail) -> Self {
        Self { scope, leaves: Leaves::default(), detail, num_steps: 0 }
    }

    fn step(&mut self) -> Outcome<()> {
        self.num_steps += 1;
        if self.num_steps > MOST_STEPS { Err(format!("more than {MOST_STEPS} points and repetitions")) } else { Ok(()) }
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

    fn parts(&mut self, parts: &'a [Part]) -> Result<MeshBuilder> {
        let mut made = MeshBuilder::new();
        parts.iter().try_for_each(|part| self.repeat(part, &part.loops, &mut made))?;
        Ok(made)
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
        let mut offset = [0.0; 4];
        for (number, expression) in offset.iter_mut().zip(part.at.iter().flatten()) {
            *number = expression.value(&mut self.scope).map_err(fault)?;
        }
        let offset = point(offset).map_err(fault)?;
        let mut linear = Mat3::IDENTITY;
        for (angle, axis) in part.turns.iter().zip([Vec3::X, Vec3::Y, Vec3::Z]) {
            if let Some(angle) = angle {
                linear = turn(axis, angle.value(&mut self.scope).map_err(fault)?) * linear;
            }
        }
        let mut own = self.parts(&part.solid.parts)?;
        self.solid(&part.solid, slot, &mut own).map_err(fault)?;
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

    /// The points of a solid in the order in which their loops make them; coordinates that they lack are 0.
    fn points(&mut self, solid: &'a Solid) -> Outcome<Vec<[f64; 4]>> {
        let mut found = Vec::new();
        for point in &solid.points {
            let mark = self.scope.mark();
            let each = point.each.as_ref();
            for value in each.map_or(Ok(vec![0.0]), |each| self.each(each))? {
                self.step()?;
                if let Some(each) = each {
                    self.scope.add(&each.name, value);
                }
                define(&solid.at_points, &mut self.scope).map_err(|fault| fault.reason)?;
                let mut numbers = [0.0; 4];
                for (number, expression) in numbers.iter_mut().zip(&point.coordinates) {
                    *number = expression.value(&mut self.scope)?;
                }
                found.push(numbers);
                self.scope.forget(mark);
            }
        }
        Ok(found)
    }

    /// The points of a solid as corners, of which there are so many or more.
    fn corners(&mut self, solid: &'a Solid, least: usize) -> Outcome<Vec<Vec3>> {
        let found = self.points(solid)?.into_iter().map(point).collect::<Outcome<Vec<Vec3>>>()?;
        if found.len() < least { Err(format!("{} points, expected {least} or more", found.len())) } else { Ok(found) }
    }

    /// Rows of corners, one for each value of the loops that it goes along.
    fn rows(&mut self, solid: &'a Solid, least: usize) -> Outcome<Vec<Vec<Vec3>>> {
        let mut rows = Vec::new();
        self.add_rows(solid, least, &solid.along, &mut rows)?;
        match rows.iter().find(|row| row.len() != rows[0].len()) {
            Some(_) => Err("expected the same number of points for each value of along".to_owned()),
            None => Ok(rows),
        }
    }

    fn add_rows(
        &mut self,
        solid: &'a Solid,
        least: usize,
        loops: &'a [Loop],
        rows: &mut Vec<Vec<Vec3>>,
    ) -> Outcome<()> {
        let Some((first, rest)) = loops.split_first() else {
            rows.push(self.corners(solid, least)?);
            return Ok(());
        };
        let mark = self.scope.mark();
        for value in self.each(first)? {
            self.scope.add(&first.name, value);
            self.add_rows(solid, least, rest, rows)?;
            self.scope.forget(mark);
        }
        Ok(())
    }

    fn solid(&mut self, solid: &'a Solid, slot: u8, b: &mut MeshBuilder) -> Outcome<()> {
        let n = solid.numbers.iter().map(|e| e.raw(&mut self.scope)).collect::<Outcome<Vec<f64>>>()?;
        // Only the power of rings may be infinite, which no size of theirs can be.
        let is_usable = |number: &f64| number.is_finite() || solid.kind == Kind::Rings && !number.is_nan();
        if let Some(number) = n.iter().find(|number| !is_usable(number)) {
            return Err(format!("a value is {number}, which is not finite"));
        }
        match solid.kind {
            Kind::Group => {}
            Kind::Block => b.block(Vec3::ZERO, Vec3::new(size(n[0])?, size(n[1])?, size(n[2])?), slot),
            Kind::Box => {
                let (min, max) = (point([n[0], n[2], n[4], 0.0])?, point([n[1], n[3], n[5], 0.0])?);
                (max - min).to_array().into_iter().try_for_each(|side| size(side.into()).map(|_| ()))?;
                b.cuboid(min, max, slot);
            }
            Kind::Tube => {
                let stations = self.points(solid)?.into_iter().map(|p| Ok((point(p)?, size(p[3])?)));
                let stations = stations.collect::<Outcome<Vec<_>>>()?;
                if stations.len() < 2 || stations[0].0 == stations[stations.len() - 1].0 {
                    return Err("a tube leads from one place to another".to_owned());
                }
                b.tube(&stations, count(n[0])?, slot);
            }
            Kind::Prism(axis) => {
                let outline: Vec<(f32, f32)> = self.corners(solid, 3)?.into_iter().map(|p| (p.x, p.y)).collect();
                let span = point([n[0], n[1], 0.0, 0.0])?;
                size(n[1] - n[0])?;
                b.prism(axis, &outline, (span.x, span.y), slot);
            }
            Kind::Rings => {
                let (sides, power) = (count(n[0])?, n[1]);
                if power < 0.5 {
                    return Err(format!("power is {power}, expected 0.5 to inf"));
                }
                let ring = |p: [f64; 4]| Ok(level_ring([size(p[0])?, size(p[1])?], point(p)?.z, sides, power as f32));
                let rings = self.points(solid)?.into_iter().map(ring).collect::<Outcome<Vec<_>>>()?;
                b.loft(&rings, slot, n[2] == 0.0);
            }
            Kind::Hoop => b.hoop(size(n[0])?, size(n[1])?, (count(n[2])?, count(n[3])?), slot),
            Kind::Face => b.polygon(&self.corners(solid, 3)?, slot),
            Kind::Loft => b.loft(&self.rows(solid, 3)?, slot, true),
            Kind::Sheet => b.sheet(&self.rows(solid, 2)?, false, |_, _| Some(slot)),
            Kind::Bush => {
                let [half_x, half_y, low_m, top_m] = [0, 1, 2, 3].map(|k| n[k] as f32);
                let is_usual = half_x.min(half_y).min(top_m - low_m) > 0.1 && half_x.max(half_y).max(top_m) < 6.0;
                if !is_usual || low_m.abs() > 6.0 || n[4] < 1.0 {
                    return Err("a bush has half extents and a height of 0.1 to 6 m, and power 1 or more".to_owned());
                }
                let bush = Cushion { half: (half_x, half_y), low_m, top_m, power: n[4] as f32 };
                bush.grow(&mut self.scope.stream, b, &mut self.leaves, self.detail);
            }
            Kind::Stems => {
                let (pot_m, foot_m, spread_m, top_m) = (size(n[0])?, size(n[1])?, size(n[2])?, size(n[3])?);
                if !(0.25..3.0).contains(&spread_m) || top_m < foot_m + 0.5 || top_m > 6.0 {
                    return Err("stems spread 0.25 to 3 m and rise by 0.5 m or more, to at most 6 m".to_owned());
                }
                let stems = Stems { pot_m, foot_m, spread_m, top_m };
                stems.grow(&mut self.scope.stream, b, &mut self.leaves, self.detail);
            }
            Kind::Text => text(b, &solid.words[index(n[0], solid.words.len())?], &n[1..], slot)?,
            Kind::Number => {
                text(b, &format!("{:.*}", index(n[1], 4)?, n[0]).replace('.', ","), &n[2..], slot)?;
            }
        }
        Ok(())
    }
}

/// Writes words of a height that begin at the origin, end there (`align` 1), or anything between.
fn text(b: &mut MeshBuilder, words: &str, numbers: &[f64], slot: u8) -> Outcome<()> {
    let (height, align) = (size(numbers[0])?, numbers[1].clamp(0.0, 1.0) as f32);
    letters::write(b, words, Vec3::Y * (-align * letters::width(words) * height), height, slot);
    Ok(())
}

/// A turn about an axis, counter-clockwise seen against it.
fn turn(axis: Vec3, angle_rad: f64) -> Mat3 {
    let (s, c) = (math::sin(angle_rad) as f32, math::cos(angle_rad) as f32);
    // Rodrigues' formula for an axis of length 1.
    let of = |p: Vec3| p * c + axis.cross(p) * s + axis * (axis.dot(p) * (1.0 - c));
    Mat3::from_cols(of(Vec3::X), of(Vec3::Y), of(Vec3::Z))
}
