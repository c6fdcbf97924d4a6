//! Reads a dictionary field by field and refuses what is left over.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::CadetError;

/// The fields of a dictionary that are still to be read.
pub(crate) struct Fields<'py> {
    owner: &'static str,
    dict: Bound<'py, PyDict>,
}

impl<'py> Fields<'py> {
    /// Starts reading; `owner` names the dictionary in messages.
    pub(crate) fn new(owner: &'static str, dict: &Bound<'py, PyDict>) -> PyResult<Self> {
        Ok(Self { owner, dict: dict.copy()? })
    }

    /// Takes a field of a type.
    pub(crate) fn take<T: FromPyObjectOwned<'py>>(&mut self, key: &str) -> PyResult<T> {
        let Some(value) = self.dict.get_item(key)? else {
            return Err(CadetError::new_err(format!("{}: missing {key:?}", self.owner)));
        };
        self.dict.del_item(key)?;
        value.extract().map_err(|error: T::Error| {
            let error: PyErr = error.into();
            CadetError::new_err(format!("{}.{key}: {error}", self.owner))
        })
    }

    /// Ends reading.
    pub(crate) fn finish(self) -> PyResult<()> {
        match self.dict.keys().iter().next() {
            Some(key) => Err(CadetError::new_err(format!("{}: unknown key {key}", self.owner))),
            None => Ok(()),
        }
    }
}
