//! Structures of arrays that begin with zeros.

/// Numbers and arrays of them that are zero all over; the standard library's `Default` knows no arrays of more than 32.
pub(crate) trait Zeros {
    /// 0, or false.
    const ZEROS: Self;
}

macro_rules! zeros_of {
    ($($number:ty: $zero:literal),*) => {$(
        impl Zeros for $number {
            const ZEROS: Self = $zero;
        }
    )*};
}
zeros_of!(f32: 0.0, f64: 0.0, u32: 0, bool: false);

impl<T: Zeros, const N: usize> Zeros for [T; N] {
    const ZEROS: Self = [T::ZEROS; N];
}

/// Implements `Default` with zeros: as `#[derive(DefaultZeros!)]`.
macro_rules! DefaultZeros {
    (
        $(#[$_meta:meta])* $_visible:vis struct $Name:ident {
            $($(#[$_field_meta:meta])* $_field_visible:vis $field:ident: $_Type:ty),* $(,)?
        }
    ) => {
        impl Default for $Name {
            fn default() -> Self {
                Self { $($field: crate::zeros::Zeros::ZEROS),* }
            }
        }
    };
}
pub(crate) use DefaultZeros;
