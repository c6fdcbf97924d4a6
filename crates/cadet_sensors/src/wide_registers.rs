//! Functions that are compiled once more for each width of a processor's registers.

/// Compiles a function for AVX-512, for AVX2, and for any processor, and calls the version that fits: as
/// `#[apply(for_wide_registers)]`.
///
/// Each version computes operation by operation what the plain one does, none of them fused, so that the outcome is the
/// same to the bit.
macro_rules! for_wide_registers {
    ($($function:tt)*) => {
        #[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
        $($function)*
    };
}

/// Makes an array of what a function gives for each index, as [`std::array::from_fn`] does.
///
/// The compiler may leave the standard library's function apart from the one that calls it, and the closure within it, where they
/// have no wide registers; this one it may not.
#[inline(always)]
pub(crate) fn array_of<T: Copy + Default, const N: usize>(of: impl Fn(usize) -> T) -> [T; N] {
    let mut out = [T::default(); N];
    for (i, out) in out.iter_mut().enumerate() {
        *out = of(i);
    }
    out
}
