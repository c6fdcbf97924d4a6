//! Traffic lights in parts: what stands, and the heads whose lenses are lit or not.

use std::sync::{Arc, LazyLock};

use super::draw::{CREASE_RAD, v};
use super::{Detail, SceneryModel};
use cadet_base::geometry::{LodSet, Memo, Mesh, MeshBuilder};
use cadet_base::lamp::{Lamp, LampBeam};
use cadet_base::material::{LidarMaterial, Material, Palette, Pattern, Semantic};
use cadet_base::math::{DVec2, PI, Vec3, cosf, sinf};

/// How far mast arms reach over the lanes.
pub const MAST_ARMS_M: [f64; 5] = [3.0, 4.0, 5.0, 6.0, 7.0];
/// Height of the bottom of a head on a post.
pub const POST_HEAD_M: f64 = 2.25;
/// Height of the bottom of a head at the end of a mast arm.
pub const MAST_HEAD_M: f64 = 4.75;
/// Of a head for people.
pub const WALK_HEAD_M: f64 = 2.2;
/// How far in front of the post's middle a head's back is.
pub const HEAD_OFF_POST_M: f64 = 0.1;
/// Seen to these distances.
const LIMITS_M: [f32; 3] = [25.0, 60.0, 220.0];

/// What carries the heads; heads face +x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignalPost {
    /// A straight post.
    Post,
    /// A mast whose arm reaches toward -y, of a length among [`MAST_ARMS_M`].
    Mast(usize),
}

/// Kinds of heads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum HeadKind {
    /// Three lenses for vehicles.
    Vehicle,
    /// Three lenses for vehicles in front of a black board with a white rim.
    Backed,
    /// Two lenses with a figure for people.
    Walk,
}

mod slot {
    pub const HOUSING: u8 = 0;
    pub const VISOR: u8 = 1;
    /// Red, yellow, green from here on.
    pub const LENS: u8 = 2;
    pub const BOARD: u8 = 5;
    pub const RIM: u8 = 6;
    pub const MASK: u8 = 7;
}

const LENS_RADIUS: f32 = 0.1;
const CHAMBER: f32 = 0.3;
const FRONT: f32 = 0.14;
/// Colors of lit lenses, and of the same in the dark.
const LIT: [[f32; 3]; 3] = [[1.0, 0.03, 0.015], [1.0, 0.42, 0.02], [0.03, 0.95, 0.34]];
const DARK: [[f32; 3]; 3] = [[0.10, 0.012, 0.010], [0.12, 0.06, 0.010], [0.008, 0.07, 0.04]];

/// What a lit lens sends along its axis, and how far that matters.
const LENS_CD: f32 = 200.0;
const REACH_M: f32 = 45.0;

/// The posts' paint, galvanized steel.
fn post_palette() -> Arc<Palette> {
    static PALETTE: LazyLock<Arc<Palette>> = LazyLock::new(|| {
        let steel = Material::matt(Semantic::Pole, [0.30, 0.31, 0.32], Pattern::Plain, 0.4).polished(0.5, 0.04);
        let button = Material::matt(Semantic::Pole, [0.52, 0.36, 0.02], Pattern::Plain, 0.5);
        Arc::new(Palette::new(vec![steel, button]))
    });
    Arc::clone(&PALETTE)
}

/// A post or a mast.
#[must_use]
pub fn signal_post(kind: SignalPost) -> SceneryModel {
    static MODELS: Memo<usize, SceneryModel> = Memo::new();
    let kind = match kind {
        SignalPost::Mast(arm) => SignalPost::Mast(arm.min(MAST_ARMS_M.len() - 1)),
        SignalPost::Post => kind,
    };
    let number = if let SignalPost::Mast(arm) = kind { arm + 1 } else { 0 };
    MODELS.get(number, || {
        let shape = Detail::levels(LIMITS_M, move |d| post_mesh(kind, d));
        let height_m = f64::from(shape.bounds.max.z);
        SceneryModel::about_origin(format!("signal-post/{number}"), shape, post_palette(), DVec2::splat(0.12), height_m)
    })
}

fn post_mesh(kind: SignalPost, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let sides = detail.pick(12, 8, 6);
    let least = detail.pick(0.0, 0.0, 0.05_f32);
    match kind {
        SignalPost::Post => {
            b.tube(&[(v(0.0, 0.0, -0.4), 0.065_f32.max(least)), (v(0.0, 0.0, 3.35), 0.06_f32.max(least))], sides, 0);
        }
        SignalPost::Mast(arm) => {
            let reach = MAST_ARMS_M[arm] as f32;
            let stations = [(-0.4, 0.14), (1.1, 0.135), (1.15, 0.11), (5.3, 0.085)].map(|(z, r)| (v(0.0, 0.0, z), r));
            b.tube(&stations, sides, 0);
            // The arm leaves the mast in a bend and rises a little.
            let along: Vec<(Vec3, f32)> = (0..=detail.pick(8, 4, 2))
                .map(|k| k as f32 / detail.pick(8, 4, 2) as f32)
                .map(|t| (v(0.0, -reach * t, 5.25 + 0.55 * (1.0 - (1.0 - t) * (1.0 - t))), 0.075 - 0.035 * t))
                .collect();
            b.tube(&along, sides, 0);
        }
    }
    if detail != Detail::Far {
        // The button for people.
        b.block(v(0.0, 0.09, 1.05), v(0.09, 0.06, 0.16), 1);
    }
    b.build("signal-post", CREASE_RAD)
}

/// Which of its lenses are lit: red, yellow, green; red and green for people.
#[must_use]
pub fn signal_head(kind: HeadKind, lit: [bool; 3]) -> (Arc<LodSet>, Arc<Palette>) {
    static SHAPES: Memo<HeadKind, Arc<LodSet>> = Memo::new();
    static PALETTES: Memo<[bool; 3], Arc<Palette>> = Memo::new();
    let shape = SHAPES.get(kind, || Detail::levels(LIMITS_M, move |d| head_mesh(kind, d)));
    (shape, PALETTES.get(lit, || Arc::new(head_palette(lit))))
}

fn head_palette(lit: [bool; 3]) -> Palette {
    let sign = |albedo, reflectance| Material::matt(Semantic::TrafficSign, albedo, Pattern::Plain, reflectance);
    let housing = sign([0.020, 0.030, 0.024], 0.10).polished(0.45, 0.04);
    let lens = |k: usize| {
        // A smooth lens before a reflector: little comes back unless it is met square.
        let coat_index = LidarMaterial::LACQUER_INDEX;
        let lidar = LidarMaterial { coat_index, gloss: 0.04, roughness: 0.1, ..LidarMaterial::diffuse(0.30) };
        if lit[k] {
            Material { pattern: Pattern::Lamp, lidar, ..sign(LIT[k], 0.30) }
        } else {
            Material { lidar, ..sign(DARK[k], 0.30).polished(0.25, 0.04) }
        }
    };
    let rim = sign([0.62, 0.62, 0.60], 0.75);
    let visor = sign([0.016, 0.017, 0.017], 0.08);
    let board = sign([0.018, 0.018, 0.019], 0.09);
    let lamps = (0..3).filter(|k| lit[*k]).map(|k| {
        let at = v(FRONT + 0.02, 0.0, CHAMBER * (2.5 - k as f32));
        Lamp::of_candela(LampBeam::Lens, at, [Vec3::X, Vec3::Y], LIT[k], LENS_CD, REACH_M)
    });
    Palette::new(vec![housing, visor, lens(0), lens(1), lens(2), board, rim, sign([0.012; 3], 0.12)])
        .with_lamps(lamps.collect())
}

/// The back of a head is at x = 0, its bottom at z = 0; it faces +x.
fn head_mesh(kind: HeadKind, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    // From below: green, yellow for vehicles alone, red.
    let colors: &[u8] = if kind == HeadKind::Walk { &[2, 0] } else { &[2, 1, 0] };
    let height = CHAMBER * colors.len() as f32;
    if kind == HeadKind::Backed {
        b.block(v(0.035, 0.0, height / 2.0), v(0.012, 0.62, height + 0.34), slot::RIM);
        b.block(v(0.043, 0.0, height / 2.0), v(0.012, 0.54, height + 0.26), slot::BOARD);
    }
    for (k, color) in colors.iter().enumerate() {
        let z = CHAMBER * (k as f32 + 0.5);
        let lens = slot::LENS + color;
        b.block(v(FRONT / 2.0, 0.0, z), v(FRONT, 0.29, CHAMBER - 0.012), slot::HOUSING);
        if kind == HeadKind::Walk {
            b.disc(v(FRONT + 0.004, 0.0, z), LENS_RADIUS, detail.pick(20, 12, 8), 0.0, slot::MASK);
            figure(&mut b, z, k == 0, lens, detail);
        } else {
            b.disc(v(FRONT + 0.006, 0.0, z), LENS_RADIUS, detail.pick(20, 12, 8), 0.0, lens);
        }
        if detail != Detail::Far {
            visor(&mut b, z, detail.pick(10, 5, 3));
        }
    }
    b.build("signal-head", CREASE_RAD)
}

/// A tube about a lens that is open below.
fn visor(b: &mut MeshBuilder, z: f32, steps: usize) {
    let (inner, outer) = (LENS_RADIUS + 0.006, LENS_RADIUS + 0.018);
    let from = -0.22 * PI as f32;
    let angle = |i: usize| from + (PI as f32 - 2.0 * from) * i as f32 / steps as f32;
    let at = |radius: f32, i: usize, x: f32| v(x, radius * cosf(angle(i)), z + radius * sinf(angle(i)));
    // Longer above than at its sides.
    let tip = |i: usize| FRONT + 0.09 + 0.13 * sinf(angle(i)).max(0.0);
    for i in 0..steps {
        let (x, y) = (tip(i), tip(i + 1));
        b.quad(at(outer, i, FRONT), at(outer, i, x), at(outer, i + 1, y), at(outer, i + 1, FRONT), slot::VISOR);
        b.quad(at(inner, i + 1, FRONT), at(inner, i + 1, y), at(inner, i, x), at(inner, i, FRONT), slot::VISOR);
        b.quad(at(inner, i, x), at(inner, i + 1, y), at(outer, i + 1, y), at(outer, i, x), slot::VISOR);
    }
    for (i, flips) in [(0, false), (steps, true)] {
        let ring = [at(inner, i, FRONT), at(inner, i, tip(i)), at(outer, i, tip(i)), at(outer, i, FRONT)];
        let [p, q, r, s] = if flips { [ring[3], ring[2], ring[1], ring[0]] } else { ring };
        b.quad(p, q, r, s, slot::VISOR);
    }
}

/// Somebody who stands, or walks, of the color of a lens.
fn figure(b: &mut MeshBuilder, z: f32, walks: bool, lens: u8, detail: Detail) {
    let x = FRONT + 0.010;
    b.disc(v(x, 0.0, z + 0.066), 0.021, detail.pick(10, 8, 5), 0.0, lens);
    let mut bar = |from: (f32, f32), to: (f32, f32), half: f32| {
        let (a, d) = (v(x, from.0, z + from.1), v(x, to.0, z + to.1));
        let aside = Vec3::X.cross(d - a).normalize_or_zero() * half;
        b.quad(a - aside, d - aside, d + aside, a + aside, lens);
    };
    bar((0.0, 0.042), (0.0, -0.02), 0.024);
    if walks {
        bar((0.0, -0.015), (0.045, -0.085), 0.012);
        bar((0.0, -0.015), (-0.04, -0.08), 0.012);
        bar((0.0, 0.03), (0.05, -0.005), 0.009);
        bar((0.0, 0.03), (-0.05, 0.0), 0.009);
    } else {
        bar((0.011, -0.015), (0.011, -0.09), 0.0095);
        bar((-0.011, -0.015), (-0.011, -0.09), 0.0095);
        bar((0.02, 0.035), (0.048, -0.02), 0.009);
        bar((-0.02, 0.035), (-0.048, -0.02), 0.009);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_as_large_as_german_ones_and_posts_carry_them() {
        for kind in [HeadKind::Vehicle, HeadKind::Backed, HeadKind::Walk] {
            let (shape, _) = signal_head(kind, [true, false, false]);
            let (min, max) = (shape.bounds.min, shape.bounds.max);
            let housing_m = if kind == HeadKind::Walk { 0.6 } else { 0.9 };
            let (width_m, height_m) = if kind == HeadKind::Backed { (0.62, 1.24) } else { (0.29, housing_m) };
            assert!((max.y - min.y - width_m).abs() < 0.02, "{kind:?}: {} m wide", max.y - min.y);
            assert!((max.z - min.z - height_m).abs() < 0.03, "{kind:?}: {} m high", max.z - min.z);
            assert!(min.x >= 0.0 && max.x < 0.4, "{kind:?}: {} to {}", min.x, max.x);
        }
        assert!(signal_post(SignalPost::Post).height_m > POST_HEAD_M + 0.9);
        for (i, reach_m) in MAST_ARMS_M.iter().enumerate() {
            let bounds = signal_post(SignalPost::Mast(i)).shape.bounds;
            assert!((f64::from(-bounds.min.y) - reach_m).abs() < 0.15);
            // The head hangs below the arm, above trucks.
            let over_m = f64::from(bounds.max.z) - (MAST_HEAD_M + 0.9);
            assert!((0.0..0.4).contains(&over_m) && MAST_HEAD_M > 4.5, "{over_m}");
        }
    }

    #[test]
    fn lenses_face_the_traffic_and_only_lit_ones_shine() {
        for kind in [HeadKind::Vehicle, HeadKind::Walk] {
            let (shape, palette) = signal_head(kind, [true, false, true]);
            for (_, mesh) in &shape.levels[..1] {
                for number in mesh.face_numbers() {
                    if !(slot::LENS..slot::LENS + 3).contains(&mesh.face(number).slot) {
                        continue;
                    }
                    let [a, b, c] = mesh.corners(number);
                    assert!((b - a).cross(c - a).x > 0.0, "{kind:?}: a lens that looks away");
                }
            }
            let shines = palette.materials().iter().map(|m| m.pattern == Pattern::Lamp);
            assert_eq!(shines.collect::<Vec<_>>(), [false, false, true, false, true, false, false, false]);
        }
    }
}
