//! The one place where the core's errors become Python's.

use pyo3::import_exception;
use pyo3::prelude::*;

import_exception!(cadet.errors, CadetError);
import_exception!(cadet.errors, FileFormatError);
import_exception!(cadet.errors, InternalError);
import_exception!(cadet.errors, KittiFormatError);
import_exception!(cadet.errors, MissingFileError);
import_exception!(cadet.errors, NonFiniteError);
import_exception!(cadet.errors, ShapeError);

/// An error on its way to Python.
pub(crate) enum BorderError {
    /// The core refuses what it was given.
    Core(cadet_core::Error),
    /// A panic: what it said and where.
    Panic(String),
    /// An object that can't be used now: why.
    Unusable(&'static str),
    /// What Python raised: a signal's handler, or an object of another kind.
    Raised(PyErr),
}

impl From<cadet_core::Error> for BorderError {
    fn from(error: cadet_core::Error) -> Self {
        Self::Core(error)
    }
}

impl From<PyErr> for BorderError {
    fn from(error: PyErr) -> Self {
        Self::Raised(error)
    }
}

impl From<BorderError> for PyErr {
    fn from(error: BorderError) -> Self {
        let error = match error {
            BorderError::Core(error) => error,
            BorderError::Panic(text) => return InternalError::new_err(text),
            BorderError::Unusable(reason) => return CadetError::new_err(reason),
            BorderError::Raised(error) => return error,
        };
        let text = error.to_string();
        match error {
            cadet_core::Error::NotFinite { .. } => NonFiniteError::new_err(text),
            cadet_core::Error::Shape { .. } => ShapeError::new_err(text),
            cadet_core::Error::Format { file, line, column, reason } => {
                KittiFormatError::new_err((reason, file, line, column))
            }
            cadet_core::Error::ImageFile { .. } => FileFormatError::new_err(text),
            cadet_core::Error::Missing { .. } => MissingFileError::new_err(text),
            _ => CadetError::new_err(text),
        }
    }
}
