//! Pieces of OpenDRIVE text: numbers and cubics.

/// A cubic a + b s + c s^2 + d s^3 from `s_m` on.
pub(crate) struct Cubic {
    pub s_m: f64,
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub d: f64,
}

impl Cubic {
    pub fn constant(a: f64) -> Self {
        Self { s_m: 0.0, a, b: 0.0, c: 0.0, d: 0.0 }
    }

    /// From value `z0` with slope `m0` to `z1` with slope `m1` over `length_m`.
    pub fn hermite(s_m: f64, length_m: f64, (z0, m0): (f64, f64), (z1, m1): (f64, f64)) -> Self {
        let rise = (z1 - z0) / length_m;
        let c = (3.0 * rise - 2.0 * m0 - m1) / length_m;
        let d = (m0 + m1 - 2.0 * rise) / (length_m * length_m);
        Self { s_m, a: z0, b: m0, c, d }
    }

    pub fn write(&self, out: &mut String, element: &str, s_name: &str) {
        let Self { s_m, a, b, c, d } = self;
        put!(out, "<{element} {s_name}=\"{s_m:.5}\" a=\"{a:.6}\" b=\"{b:.8}\" c=\"{c:.9}\" d=\"{d:.10}\"/>\n");
    }
}

/// Writes formatted text to a `String`, which can't fail.
macro_rules! put {
    ($out:expr, $($text:tt)*) => {{
        let _ = std::fmt::Write::write_fmt(&mut *$out, format_args!($($text)*));
    }};
}

pub(crate) use put;
