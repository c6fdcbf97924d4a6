//! Numbers that a user may set: the name, default, and limits of each are stated once.

use crate::error::{Error, Result};

/// What a number is by default, and between which limits it may lie.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Its name.
    pub name: &'static str,
    /// Its default; more than one number for a field that has several.
    pub default: Vec<f64>,
    /// The least number allowed.
    pub least: f64,
    /// The greatest number allowed.
    pub most: f64,
    /// Whether it counts.
    pub is_whole: bool,
}

impl Setting {
    /// Refuses numbers that are not finite or beyond the limits.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], naming the setting.
    pub fn check(&self, numbers: &[f64]) -> Result<()> {
        for value in numbers {
            if !value.is_finite() || !(self.least..=self.most).contains(value) {
                let expected = if self.most.is_finite() {
                    format!("{} to {}", self.least, self.most)
                } else {
                    format!("a finite number of at least {}", self.least)
                };
                return Err(Error::OutOfRange { what: self.name, value: value.to_string(), expected });
            }
        }
        Ok(())
    }
}

/// A field of a configuration: one number or several.
pub trait Numbers: Sized {
    /// Whether they count.
    const IS_WHOLE: bool;

    /// All of them.
    fn numbers(&self) -> Vec<f64>;

    /// The field with these numbers; `None` for another count of them, or for what does not count.
    fn of(numbers: &[f64]) -> Option<Self>;

    /// As [`Numbers::of`].
    ///
    /// # Errors
    /// [`Error::OutOfRange`], naming the setting.
    fn named(name: &'static str, numbers: &[f64]) -> Result<Self> {
        let expected = if Self::IS_WHOLE { "whole numbers" } else { "numbers" }.to_owned() + ", as many as the default";
        let value = format!("{numbers:?}");
        Self::of(numbers).ok_or(Error::OutOfRange { what: name, value, expected })
    }
}

impl Numbers for f64 {
    const IS_WHOLE: bool = false;

    fn numbers(&self) -> Vec<f64> {
        vec![*self]
    }

    fn of(numbers: &[f64]) -> Option<Self> {
        if let [number] = numbers { Some(*number) } else { None }
    }
}

impl Numbers for usize {
    const IS_WHOLE: bool = true;

    fn numbers(&self) -> Vec<f64> {
        vec![*self as f64]
    }

    fn of(numbers: &[f64]) -> Option<Self> {
        f64::of(numbers).filter(|n| *n >= 0.0 && n.fract() == 0.0).map(|n| n as Self)
    }
}

impl<const N: usize> Numbers for [f64; N] {
    const IS_WHOLE: bool = false;

    fn numbers(&self) -> Vec<f64> {
        self.to_vec()
    }

    fn of(numbers: &[f64]) -> Option<Self> {
        numbers.try_into().ok()
    }
}

impl<T: Numbers> Numbers for (T, T) {
    const IS_WHOLE: bool = T::IS_WHOLE;

    fn numbers(&self) -> Vec<f64> {
        [self.0.numbers(), self.1.numbers()].concat()
    }

    fn of(numbers: &[f64]) -> Option<Self> {
        if let [first, second] = numbers { Some((T::of(&[*first])?, T::of(&[*second])?)) } else { None }
    }
}

/// Declares a configuration: its struct, its defaults, and `settings()` with the limits that `check_settings` enforces.
/// Fields under `others` have a default only.
#[macro_export]
macro_rules! settings {
    (
        $(#[$meta:meta])* $Config:ident;
        others { $($(#[$other_doc:meta])* $other:ident: $Other:ty = $other_default:expr;)* }
        numbers { $($(#[$doc:meta])* $name:ident: $Kind:ty = $default:expr, $least:literal to $most:expr;)* }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $Config {
            $($(#[$other_doc])* pub $other: $Other,)*
            $($(#[$doc])* pub $name: $Kind,)*
        }

        impl $Config {
            /// Name, default, and limits of every number.
            #[must_use]
            pub fn settings() -> Vec<$crate::settings::Setting> {
                use $crate::settings::Numbers;
                vec![$($crate::settings::Setting {
                    name: stringify!($name),
                    default: <$Kind as Numbers>::numbers(&$default),
                    least: $least as f64,
                    most: $most as f64,
                    is_whole: <$Kind as Numbers>::IS_WHOLE,
                }),*]
            }

            /// The configuration with the numbers that `read` gives by name, unchecked; what else it has is as by default.
            ///
            /// # Errors
            /// What `read` returns; [`Error::OutOfRange`]($crate::error::Error::OutOfRange) for another count of numbers.
            pub fn from_numbers<E: From<$crate::error::Error>>(
                mut read: impl FnMut(&'static str) -> std::result::Result<Vec<f64>, E>,
            ) -> std::result::Result<Self, E> {
                use $crate::settings::Numbers;
                Ok(Self {
                    $($other: $other_default,)*
                    $($name: <$Kind as Numbers>::named(stringify!($name), &read(stringify!($name))?)?,)*
                })
            }

            fn check_settings(&self) -> $crate::error::Result<()> {
                let numbers = [$($crate::settings::Numbers::numbers(&self.$name)),*];
                Self::settings().iter().zip(&numbers).try_for_each(|(setting, values)| setting.check(values))
            }
        }

        impl Default for $Config {
            fn default() -> Self {
                Self { $($other: $other_default,)* $($name: $default,)* }
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    settings! {
        /// Some numbers.
        Some;
        others {
            /// Not a number.
            name: &'static str = "x";
        }
        numbers {
            /// A share.
            share: f64 = 0.5, 0 to 1;
            /// Counts.
            counts: (usize, usize) = (3, 4), 2 to 12;
            /// Unbounded.
            height_px: f64 = 15.0, 0 to f64::INFINITY;
        }
    }

    #[test]
    fn numbers_are_stated_once() {
        let [share, counts, height] = Some::settings().try_into().expect("three");
        assert_eq!((share.name, share.default, share.is_whole), ("share", vec![0.5], false));
        assert_eq!((counts.default, counts.least, counts.most, counts.is_whole), (vec![3.0, 4.0], 2.0, 12.0, true));
        assert_eq!(height.most, f64::INFINITY);
        assert_eq!((Some::default().name, Some::default().counts), ("x", (3, 4)));
        Some::default().check_settings().expect("the defaults are in their limits");
    }

    #[test]
    fn numbers_are_read_by_their_names() {
        let numbers = |name| Ok::<_, Error>(if name == "counts" { vec![5.0, 6.0] } else { vec![0.25] });
        let some = Some::from_numbers(numbers).expect("numbers");
        assert_eq!((some.name, some.share, some.counts, some.height_px), ("x", 0.25, (5, 6), 0.25));
        let refused = |counts: Vec<f64>| {
            Some::from_numbers(|name| Ok::<_, Error>(if name == "counts" { counts.clone() } else { vec![0.0] }))
                .expect_err("bad")
                .to_string()
        };
        for counts in [vec![5.0], vec![5.0, 6.5], vec![5.0, -6.0], vec![5.0, f64::NAN]] {
            assert!(refused(counts).contains("counts"));
        }
    }

    #[test]
    fn numbers_beyond_their_limits_are_refused_by_name() {
        let text = |some: Some| some.check_settings().expect_err("bad").to_string();
        let fine = Some::default;
        assert!(text(Some { share: 1.5, ..fine() }).contains("share is 1.5, expected 0 to 1"));
        assert!(text(Some { share: f64::NAN, ..fine() }).contains("share is NaN"));
        assert!(text(Some { counts: (2, 13), ..fine() }).contains("counts is 13, expected 2 to 12"));
        assert!(text(Some { height_px: f64::INFINITY, ..fine() }).contains("a finite number of at least 0"));
    }
}
