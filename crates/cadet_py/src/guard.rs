//! The one way from Python into the core: without the interpreter's lock, and with panics caught.

use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::Mutex;

use pyo3::prelude::*;

use crate::error::BorderError;

/// Where the last panic was, for its message.
static LAST_PLACE: Mutex<String> = Mutex::new(String::new());

/// Keeps panics from printing, and notes where they were. `RUST_BACKTRACE` brings the usual print back.
pub(crate) fn note_panics() {
    let usual = std::panic::take_hook();
    let is_printed = std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0");
    set_hook(Box::new(move |info| {
        if let (Some(place), Ok(mut last)) = (info.location(), LAST_PLACE.try_lock()) {
            *last = format!("{}:{}", place.file(), place.line());
        }
        if is_printed {
            usual(info);
        }
    }));
}

/// Lets Python's signal handlers run in the midst of detached work, so that Ctrl-C ends it.
pub(crate) fn handle_signals() -> Result<(), BorderError> {
    Python::attach(|py| py.check_signals()).map_err(BorderError::Raised)
}

/// Runs the core's work without the interpreter's lock. A panic in it is a bug of ours: it comes back as an error.
///
/// What `work` changes and others can see must refuse to be used after a panic, as a poisoned lock does.
pub(crate) fn detached<T: Send, E: Into<BorderError>>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> Result<T, BorderError> {
    match py.detach(|| catch_unwind(AssertUnwindSafe(|| work().map_err(Into::into)))) {
        Ok(result) => result,
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
            let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
            let place = LAST_PLACE.try_lock().map(|place| place.clone()).unwrap_or_default();
            Err(BorderError::Panic(format!("{} ({place})", text.split_whitespace().collect::<Vec<_>>().join(" "))))
        }
    }
}
