//! Checks that expressions use known names alone, in all branches, whether a variant takes them or not.

use super::expression::Expression;
use super::parser::{Loop, Point, Values};
use super::parts_list::{Part, PartsList, Shape};
use super::reader::{Definition, Fault, Result};

/// The names that every expression of a shape knows.
pub(super) const GIVEN: [&str; 6] = ["variant", "level", "near", "mid", "far", "length"];
/// The name that materials know: they are the same at every level.
const OF_MATERIALS: &str = "variant";

impl Shape {
    /// Refuses names besides those `given` and its own, and new ones that hide others.
    pub(crate) fn check_names(&self, given: &[&str]) -> Result<()> {
        Names::of(self, given).map(|_| ())
    }
}

/// Refuses unknown names, and new ones that hide others.
pub(super) fn check(list: &PartsList) -> Result<()> {
    let names = Names::of(&list.shape, &GIVEN)?;
    for (line, at, when) in list
        .seats
        .iter()
        .map(|s| (s.line, &s.at, None))
        .chain(list.lamps.iter().map(|lamp| (lamp.line, &lamp.at, lamp.when.as_ref())))
    {
        at.iter().chain(when).try_for_each(|e| names.known(e, line))?;
    }
    let mut of_materials = |expression: &Expression, line: usize, own: &[String]| {
        let known = own.iter().map(String::as_str).chain([OF_MATERIALS]).map(str::to_owned);
        Names(known.collect()).known(expression, line)
    };
    list.plant.iter().try_for_each(|(line, expression)| of_materials(expression, *line, &[]))?;
    list.surfaces.iter().try_for_each(|surface| surface.visit(&mut of_materials))
}

struct Names(Vec<String>);

impl Names {
    /// The names that all of a shape knows.
    fn of(shape: &Shape, given: &[&str]) -> Result<Self> {
        let mut names = Self(given.iter().copied().map(str::to_owned).collect());
        names.define(&shape.sizes)?;
        shape.parts.iter().try_for_each(|part| names.part(part))?;
        Ok(names)
    }

    fn add(&mut self, name: &str, line: usize) -> Result<()> {
        if self.0.iter().any(|known| known == name) || ["pi", "tau", "inf", "in", "for"].contains(&name) {
            return Err(Fault::new(line, format!("the name {name:?} is taken")));
        }
        self.0.push(name.to_owned());
        Ok(())
    }

    fn known(&self, expression: &Expression, line: usize) -> Result<()> {
        let mut unknown = None;
        expression.visit_names(&mut |name| {
            if unknown.is_none() && !self.0.iter().any(|known| known == name) {
                unknown = Some(name.to_owned());
            }
        });
        let reason = |name| format!("unknown name {name:?}; known here: {}", self.0.join(", "));
        unknown.map_or(Ok(()), |name| Err(Fault::new(line, reason(name))))
    }

    fn define(&mut self, definitions: &[Definition]) -> Result<()> {
        definitions.iter().try_for_each(|definition| {
            self.known(&definition.expression, definition.line)?;
            self.add(&definition.name, definition.line)
        })
    }

    fn each(&mut self, each: &Loop, line: usize) -> Result<()> {
        match &each.values {
            Values::Range(first, end) => [first, end].into_iter().try_for_each(|e| self.known(e, line))?,
            Values::List(list) => list.iter().try_for_each(|e| self.known(e, line))?,
        }
        self.add(&each.name, line)
    }

    fn points(&mut self, points: &[Point], sizes: &[Definition], line: usize) -> Result<()> {
        points.iter().try_for_each(|point| {
            let mark = self.0.len();
            point.each.iter().try_for_each(|each| self.each(each, line))?;
            self.define(sizes)?;
            point.coordinates.iter().try_for_each(|e| self.known(e, line))?;
            self.0.truncate(mark);
            Ok(())
        })
    }

    fn part(&mut self, part: &Part) -> Result<()> {
        let (mark, line) = (self.0.len(), part.line);
        part.loops.iter().try_for_each(|each| self.each(each, line))?;
        let own = part.when.iter().chain(&part.which);
        // `when` comes before the names that it guards.
        part.when.iter().try_for_each(|e| self.known(e, line))?;
        self.define(&part.sizes)?;
        let placed = own.chain(part.at.iter().flatten()).chain(part.turns.iter().flatten());
        placed.into_iter().try_for_each(|e| self.known(e, line))?;
        let solid = &part.solid;
        solid.numbers.iter().try_for_each(|e| self.known(e, line))?;
        solid.along.iter().try_for_each(|each| self.each(each, line))?;
        self.points(&solid.points, &solid.at_points, line)?;
        solid.parts.iter().try_for_each(|part| self.part(part))?;
        self.0.truncate(mark);
        Ok(())
    }
}
