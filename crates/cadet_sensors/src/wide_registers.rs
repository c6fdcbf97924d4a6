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
