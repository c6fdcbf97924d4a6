//! All props: those of the crate's folder `props`, and a user's own.

use std::ops::Deref;
use std::sync::{Arc, LazyLock};

use super::place::Place;
use super::prop::Prop;
use super::surface::Library;
use cadet_base::error::{Error, Result};

/// A prop of the crate's folder `props`, by its name in capitals: `BUS_SHELTER` is `bus-shelter.toml`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shipped(usize);

include!(concat!(env!("OUT_DIR"), "/shipped_props.rs"));

static LIBRARY: LazyLock<Library> = LazyLock::new(|| {
    Library::parse(MATERIALS).unwrap_or_else(|fault| panic!("materials.toml:{}: {}", fault.line, fault.reason))
});

static SHIPPED: LazyLock<Vec<Arc<Prop>>> = LazyLock::new(|| {
    let parse = |(name, file, text): &(&str, &str, &str)| match Prop::parse(name, file, text, &LIBRARY) {
        Ok(prop) => Arc::new(prop),
        Err(error) => panic!("{error}"),
    };
    FILES.iter().map(parse).collect()
});

impl Deref for Shipped {
    type Target = Arc<Prop>;

    fn deref(&self) -> &Arc<Prop> {
        &SHIPPED[self.0]
    }
}

/// All props of the crate.
#[must_use]
pub fn shipped() -> &'static [Arc<Prop>] {
    &SHIPPED
}

/// A user's own props.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OwnProps(Arc<[Arc<Prop>]>);

impl OwnProps {
    /// Reads files, each a name and a text: `bottle-bank.toml` is the prop `bottle-bank`. All are drawn once, so that bad
    /// ones are refused here.
    ///
    /// # Errors
    /// [`Error::File`] for the first that can't be used, naming file, line, and reason.
    pub fn parse(files: &[(String, String)]) -> Result<Self> {
        let mut props: Vec<Arc<Prop>> = Vec::new();
        for (file, text) in files {
            let refused = |reason: &str| Error::File { file: file.clone(), line: 1, reason: reason.to_owned() };
            let name = file.strip_suffix(".toml").unwrap_or(file);
            let is_usual = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            if name.is_empty() || name.len() > 40 || !name.chars().all(is_usual) {
                return Err(refused("expected a file name of 1 to 40 small letters, digits, or '-', and '.toml'"));
            }
            if SHIPPED.iter().chain(&props).any(|other| other.name() == name) {
                return Err(refused("there is a prop of this name already; rename the file"));
            }
            let prop = Prop::parse(name, file, text, &LIBRARY)?;
            if prop.places().is_empty() {
                return Err(refused("it is placed nowhere: add a [[place]]"));
            }
            prop.check()?;
            props.push(Arc::new(prop));
        }
        Ok(Self(props.into()))
    }

    /// The props.
    #[must_use]
    pub fn props(&self) -> &[Arc<Prop>] {
        &self.0
    }

    /// The crate's props and these, with each of their rules that `choose` takes.
    pub fn placed<T>(&self, choose: impl Fn(&Place) -> Option<T>) -> Vec<(&Arc<Prop>, T)> {
        let rules = SHIPPED.iter().chain(self.0.iter()).flat_map(|prop| prop.places().iter().map(move |p| (prop, p)));
        rules.filter_map(|(prop, place)| Some((prop, choose(place)?))).collect()
    }
}
