//! Reads the values of a TOML file; every fault knows its line.

use std::borrow::Cow;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::expression::Expression;
use super::parser::{Parser, Point};
use cadet_base::error::Error;

/// A fault in a line of a file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    /// From 1.
    pub line: usize,
    pub reason: String,
}

pub(crate) type Result<T> = std::result::Result<T, Fault>;

impl Fault {
    pub(super) fn new(line: usize, reason: impl Into<String>) -> Self {
        Self { line, reason: reason.into() }
    }

    /// Makes a fault in a line of what is wrong.
    pub(super) fn at(line: usize) -> impl FnOnce(String) -> Self {
        move |reason| Self { line, reason }
    }

    pub(crate) fn in_file(self, file: &str) -> Error {
        Error::File { file: file.to_owned(), line: self.line, reason: self.reason }
    }
}

/// A table of a file; whoever reads it takes all keys that it knows.
pub(crate) struct Table<'a> {
    text: &'a str,
    pub line: usize,
    entries: Vec<(&'a Spanned<Cow<'a, str>>, &'a Spanned<DeValue<'a>>)>,
    known: Vec<&'static str>,
}

/// A value, and the key that it stands at.
#[derive(Clone, Copy)]
pub(crate) struct Value<'a> {
    text: &'a str,
    key: &'a str,
    value: &'a Spanned<DeValue<'a>>,
}

fn line_at(text: &str, offset: usize) -> usize {
    1 + text.as_bytes().iter().take(offset).filter(|byte| **byte == b'\n').count()
}

/// Parses a whole file and hands its table to `read`.
pub(crate) fn read_file<T>(text: &str, read: impl FnOnce(Table) -> Result<T>) -> Result<T> {
    let root = DeTable::parse(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        Fault::new(line_at(text, offset), error.message().replace('\n', " "))
    })?;
    read(Table::new(text, 1, root.get_ref()))
}

impl<'a> Table<'a> {
    fn new(text: &'a str, line: usize, table: &'a DeTable<'a>) -> Self {
        Self { text, line, entries: table.iter().collect(), known: Vec::new() }
    }

    /// The value at a key, if it is there.
    pub(crate) fn take(&mut self, key: &'static str) -> Option<Value<'a>> {
        self.known.push(key);
        let index = self.entries.iter().position(|(name, _)| name.get_ref() == key)?;
        let (_, value) = self.entries.remove(index);
        Some(Value { text: self.text, key, value })
    }

    /// The value at a key that must be there.
    pub(crate) fn need(&mut self, key: &'static str) -> Result<Value<'a>> {
        self.take(key).ok_or_else(|| Fault::new(self.line, format!("missing key {key:?}")))
    }

    /// All entries that are left, by name.
    pub(crate) fn rest(&mut self) -> Vec<(&'a str, Value<'a>)> {
        let entries = std::mem::take(&mut self.entries).into_iter();
        entries.map(|(key, value)| (&**key.get_ref(), Value { text: self.text, key: key.get_ref(), value })).collect()
    }

    /// Refuses keys that nobody took.
    pub(crate) fn end(&self) -> Result<()> {
        let Some((key, _)) = self.entries.first() else { return Ok(()) };
        let line = line_at(self.text, key.span().start);
        Err(Fault::new(line, format!("unknown key {:?}; known: {}", key.get_ref(), self.known.join(", "))))
    }
}

impl<'a> Value<'a> {
    pub(super) fn line(&self) -> usize {
        line_at(self.text, self.value.span().start)
    }

    pub(super) fn fault(&self, reason: impl Into<String>) -> Fault {
        Fault::new(self.line(), format!("{}: {}", self.key, reason.into()))
    }

    fn expected(&self, what: &str) -> Fault {
        self.fault(format!("expected {what}"))
    }

    pub(super) fn string(&self) -> Result<&'a str> {
        match self.value.get_ref() {
            DeValue::String(text) => Ok(text),
            _ => Err(self.expected("a text in quotes")),
        }
    }

    /// One of a list of names.
    pub(crate) fn one_of<T: Copy>(&self, known: &[(&str, T)]) -> Result<T> {
        let name = self.string()?;
        let found = known.iter().find(|(other, _)| *other == name);
        found.map(|(_, value)| *value).ok_or_else(|| {
            let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
            self.fault(format!("unknown name {name:?}; known: {}", names.join(", ")))
        })
    }

    pub(super) fn is_string(&self) -> bool {
        matches!(self.value.get_ref(), DeValue::String(_))
    }

    pub(super) fn is_array(&self) -> bool {
        matches!(self.value.get_ref(), DeValue::Array(_))
    }

    pub(super) fn boolean(&self) -> Result<bool> {
        match self.value.get_ref() {
            DeValue::Boolean(value) => Ok(*value),
            _ => Err(self.expected("true or false")),
        }
    }

    /// A number between limits.
    pub(crate) fn number(&self, least: f64, most: f64) -> Result<f64> {
        let number = match self.value.get_ref() {
            DeValue::Integer(value) if value.radix() == 10 => value.as_str().parse().ok(),
            DeValue::Float(value) => value.as_str().parse().ok(),
            _ => None,
        };
        let is_within = |number: &f64| (least..=most).contains(number);
        number.filter(is_within).ok_or_else(|| self.expected(&format!("a number from {least} to {most}")))
    }

    pub(super) fn whole(&self, least: usize, most: usize) -> Result<usize> {
        let number = self.number(least as f64, most as f64)?;
        if number.fract() == 0.0 { Ok(number as usize) } else { Err(self.expected("a whole number")) }
    }

    /// As many numbers between limits as the array that is asked for has.
    pub(super) fn numbers<const N: usize>(&self, least: f64, most: f64) -> Result<[f64; N]> {
        let values = self.array()?;
        let numbers = values.iter().map(|v| v.number(least, most)).collect::<Result<Vec<f64>>>()?;
        numbers.try_into().map_err(|_| self.expected(&format!("{N} numbers")))
    }

    pub(super) fn array(&self) -> Result<Vec<Self>> {
        let DeValue::Array(values) = self.value.get_ref() else { return Err(self.expected("an array")) };
        Ok(values.iter().map(|value| Self { value, ..*self }).collect())
    }

    pub(crate) fn table(&self) -> Result<Table<'a>> {
        let DeValue::Table(table) = self.value.get_ref() else { return Err(self.expected("a table")) };
        Ok(Table::new(self.text, self.line(), table))
    }

    fn parsed<T>(&self, parse: impl FnOnce(&mut Parser) -> std::result::Result<T, String>) -> Result<T> {
        let all = |text: &str| {
            let mut parser = Parser::new(text)?;
            let found = parse(&mut parser)?;
            parser.end()?;
            Ok(found)
        };
        all(self.string()?).map_err(|reason: String| self.fault(reason))
    }

    /// An expression: a number or a text.
    pub(super) fn expression(&self) -> Result<Expression> {
        match self.value.get_ref() {
            DeValue::String(_) => self.parsed(Parser::expression),
            DeValue::Boolean(value) => Ok(Expression::Number(f64::from(u8::from(*value)))),
            _ => self.number(-1e9, 1e9).map(Expression::Number),
        }
    }

    /// Parses so many expressions with commas between.
    pub(super) fn tuple(&self, count: usize) -> Result<Vec<Expression>> {
        let found = if self.is_string() { self.parsed(Parser::tuple)? } else { vec![self.expression()?] };
        if found.len() == count {
            return Ok(found);
        }
        Err(self.fault(format!("expected {count} expressions with commas between, got {}", found.len())))
    }

    /// Points of so many coordinates.
    pub(super) fn points(&self, coordinates: usize) -> Result<Vec<Point>> {
        let found = self.parsed(Parser::points)?;
        match found.iter().find(|p| p.coordinates.len() != coordinates) {
            Some(point) => {
                let count = point.coordinates.len();
                Err(self.fault(format!("expected points of {coordinates} coordinates, got one of {count}")))
            }
            None => Ok(found),
        }
    }

    /// Loops with semicolons between.
    pub(super) fn loops(&self) -> Result<Vec<super::parser::Loop>> {
        self.parsed(Parser::loops)
    }

    /// Definitions, a text each, with their lines.
    pub(super) fn definitions(&self) -> Result<Vec<Definition>> {
        let values = if self.is_string() { vec![*self] } else { self.array()? };
        let read = |value: &Self| {
            let (name, expression) = value.parsed(Parser::definition)?;
            Ok(Definition { line: value.line(), name, expression })
        };
        values.iter().map(read).collect()
    }
}

/// A name and what it stands for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Definition {
    pub line: usize,
    pub name: String,
    pub expression: Expression,
}

/// Evaluates definitions and adds them to a scope.
pub(super) fn define<'a>(definitions: &'a [Definition], scope: &mut super::expression::Scope<'a>) -> Result<()> {
    for definition in definitions {
        let value = definition.expression.value(scope);
        let value = value.map_err(|reason| Fault::new(definition.line, format!("{}: {reason}", definition.name)))?;
        scope.add(&definition.name, value);
    }
    Ok(())
}
