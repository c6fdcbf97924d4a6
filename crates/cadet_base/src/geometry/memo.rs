//! A memo of values that are made once a process, when they are first asked for.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Values by key; a value must depend on its key only.
pub struct Memo<K, V>(Mutex<BTreeMap<K, Arc<OnceLock<V>>>>);

impl<K: Ord, V: Clone> Memo<K, V> {
    /// Returns a memo without a value.
    #[must_use]
    pub const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    /// The value at a key, made if it is not there; those at other keys can be made at the same time.
    pub fn get(&self, key: K, make: impl FnOnce() -> V) -> V {
        let cell = {
            let mut cells = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(cells.entry(key).or_default())
        };
        cell.get_or_init(make).clone()
    }
}

impl<K: Ord, V: Clone> Default for Memo<K, V> {
    fn default() -> Self {
        Self::new()
    }
}

impl<K, V> fmt::Debug for Memo<K, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Memo")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_made_once_and_may_ask_for_another() {
        static MEMO: Memo<u32, u64> = Memo::new();
        static MADE: Mutex<Vec<u32>> = Mutex::new(Vec::new());
        fn factorial(n: u32) -> u64 {
            MEMO.get(n, || {
                MADE.lock().unwrap().push(n);
                if n == 0 { 1 } else { u64::from(n) * factorial(n - 1) }
            })
        }
        assert_eq!((factorial(5), factorial(7), factorial(5)), (120, 5040, 120));
        assert_eq!(*MADE.lock().unwrap(), [5, 4, 3, 2, 1, 0, 7, 6]);
    }
}
