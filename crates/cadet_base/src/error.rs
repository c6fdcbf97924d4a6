//! One error type for the core: every variant names the offending value and its limit.

use std::ops::RangeInclusive;

use strum::VariantArray;

/// The core's result.
pub type Result<T> = std::result::Result<T, Error>;

/// What can be wrong with what a caller gave us. A miss is an `Option`, a bad request is an `Err`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number that is not finite where only finite ones make sense.
    #[error("{what} is not finite: {value}")]
    NotFinite {
        /// What the number is, for example `"ego x"`.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A value outside its range.
    #[error("{what} is {value}, expected {expected}")]
    OutOfRange {
        /// What the value is.
        what: &'static str,
        /// The value given, as text.
        value: String,
        /// The range, in words.
        expected: String,
    },
    /// An array of the wrong shape.
    #[error("{what} has shape {got}, expected {expected}")]
    Shape {
        /// What the array is.
        what: &'static str,
        /// The shape given.
        got: String,
        /// The shape wanted.
        expected: String,
    },
    /// A name that is not in a closed list.
    #[error("unknown {what} {name:?}; known: {known}")]
    Unknown {
        /// What was named, for example `"weather"`.
        what: &'static str,
        /// The name given.
        name: String,
        /// The names that exist, comma separated.
        known: String,
    },
    /// A map that can't be read or can't be driven.
    #[error("{map}: {reason}")]
    Map {
        /// The map's file name, or `"suburb"` for a generated one.
        map: String,
        /// Problem with the map.
        reason: String,
    },
    /// A mesh that can't be used.
    #[error("{name}: {reason}")]
    Mesh {
        /// The mesh's name or file.
        name: String,
        /// Problem with the mesh.
        reason: String,
    },
    /// A scene that can't be built as asked.
    #[error("scene: {reason}")]
    Scene {
        /// Problem with the scene.
        reason: String,
    },
    /// A scan without a ground plane to be found.
    #[error("ground plane: {reason}")]
    Ground {
        /// Problem with the scan.
        reason: String,
    },
    /// An image that can't be encoded.
    #[error("image: {reason}")]
    Image {
        /// Problem with the image.
        reason: String,
    },
    /// An image file that can't be decoded.
    #[error("{reason}")]
    ImageFile {
        /// Problem with the file, and what helps.
        reason: String,
    },
    /// A line of a user's file that can't be used.
    #[error("{file}:{line}: {reason}")]
    File {
        /// The file's name.
        file: String,
        /// The line, from 1.
        line: usize,
        /// Problem with the line.
        reason: String,
    },
    /// A line of a KITTI file that breaks its format.
    #[error("{file}:{line}: column {column}: {reason}")]
    Format {
        /// The file's folder and name.
        file: String,
        /// The line, from 1.
        line: usize,
        /// The column, from 1 as KITTI counts them: the type is column 1.
        column: usize,
        /// Problem with the line.
        reason: String,
    },
    /// A file or folder that is not there.
    #[error("{path}: {reason}")]
    Missing {
        /// Its path.
        path: String,
        /// What was expected.
        reason: String,
    },
    /// A file or folder that is there but can't be read.
    #[error("{path}: {reason}")]
    Unreadable {
        /// Its path.
        path: String,
        /// What the system says.
        reason: String,
    },
}

/// Refuses numbers that are not finite or not in a range.
///
/// # Errors
/// [`Error::NotFinite`] or [`Error::OutOfRange`], naming `what`.
pub fn within(what: &'static str, value: f64, range: RangeInclusive<f64>) -> Result<f64> {
    if range.contains(&finite(what, value)?) {
        return Ok(value);
    }
    let expected = format!("{:?} to {:?}", range.start(), range.end());
    Err(Error::OutOfRange { what, value: value.to_string(), expected })
}

/// Refuses NaN and infinity.
///
/// # Errors
/// [`Error::NotFinite`], naming `what`.
pub fn finite(what: &'static str, value: f64) -> Result<f64> {
    if value.is_finite() { Ok(value) } else { Err(Error::NotFinite { what, value }) }
}

/// Finds the variant of an enum whose name is the one that is given.
///
/// # Errors
/// [`Error::Unknown`], listing the names that exist.
pub fn variant<T>(what: &'static str, name: &str, is_named: impl Fn(&str) -> bool) -> Result<T>
where
    T: VariantArray + Copy + AsRef<str>,
{
    let known = T::VARIANTS.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", ");
    let found = T::VARIANTS.iter().copied().find(|v| is_named(v.as_ref()));
    found.ok_or_else(|| Error::Unknown { what, name: name.to_owned(), known })
}
