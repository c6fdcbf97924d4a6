//! Pieces of OpenDRIVE text: cubics, and the heads of documents and roads.

use crate::plan::WhichEnd;

/// Writes formatted text to a `String`, which can't fail.
macro_rules! put {
    ($out:expr, $($text:tt)*) => {{
        let _ = std::fmt::Write::write_fmt(&mut *$out, format_args!($($text)*));
    }};
}

pub(crate) use put;

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

    /// A value between two places, and beyond them from and to others at the beginning and the end.
    pub fn plateau((from_m, to_m, length_m): (f64, f64, f64), value: f64, [first, last]: [f64; 2]) -> Vec<Self> {
        vec![
            Self::hermite(0.0, from_m, (first, 0.0), (value, 0.0)),
            Self { s_m: from_m, ..Self::constant(value) },
            Self::hermite(to_m, length_m - to_m, (value, 0.0), (last, 0.0)),
        ]
    }

    pub fn write(&self, out: &mut String, element: &str, s_name: &str) {
        let Self { s_m, a, b, c, d } = self;
        put!(out, "<{element} {s_name}=\"{s_m:.5}\" a=\"{a:.6}\" b=\"{b:.8}\" c=\"{c:.9}\" d=\"{d:.10}\"/>\n");
    }
}

/// What a road leads on to at one of its ends.
#[derive(Clone, Copy)]
pub(crate) enum Link {
    None,
    /// A junction, by its index.
    Junction(usize),
    /// An end of a road, by the road's id.
    Road(usize, WhichEnd),
}

/// A document up to its first road.
pub(crate) fn begin_document(name: &str) -> String {
    let mut out = String::with_capacity(1 << 20);
    out.push_str("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenDRIVE>\n");
    put!(&mut out, "<header revMajor=\"1\" revMinor=\"7\" name=\"{name}\" version=\"1.00\" vendor=\"cadet\"/>\n");
    out
}

/// The head of a road: its id and length, the index of the junction that it lies in, and what it leads on to.
pub(crate) fn begin_road(out: &mut String, id: usize, length_m: f64, junction: Option<usize>, links: [Link; 2]) {
    let junction = junction.map_or("-1".to_owned(), |junction| (junction + 1).to_string());
    put!(out, "<road name=\"\" length=\"{length_m:.6}\" id=\"{id}\" junction=\"{junction}\" rule=\"RHT\">\n");
    if matches!(links, [Link::None, Link::None]) {
        return out.push_str("<link/>\n");
    }
    out.push_str("<link>");
    for (element, link) in ["predecessor", "successor"].into_iter().zip(links) {
        match link {
            Link::None => {}
            Link::Junction(index) => put!(out, "<{element} elementType=\"junction\" elementId=\"{}\"/>", index + 1),
            Link::Road(id, end) => {
                let contact = if end == WhichEnd::Start { "start" } else { "end" };
                put!(out, "<{element} elementType=\"road\" elementId=\"{id}\" contactPoint=\"{contact}\"/>");
            }
        }
    }
    out.push_str("</link>\n");
}

/// The type of a whole road, and its speed limit.
pub(crate) fn write_type(out: &mut String, kind: &str, speed_kmh: u32) {
    put!(out, "<type s=\"0.0\" type=\"{kind}\"><speed max=\"{speed_kmh}\" unit=\"km/h\"/></type>\n");
}
