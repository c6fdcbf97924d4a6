//! The lamps of a night: a grid tells which of them reach a place, so that a point sums few of them.

use crate::camera::surfaces::Flags;
use crate::sense::{PosedLamp, PosedScene};
use cadet_base::lamp::{Lamp, LampBeam, fade, lens, low_beam, luminaire};
use cadet_base::math::{DVec3, Vec3};

/// Side of the grid's cells, and how many there are along a side of the grid, whose middle is the eye's cell.
const CELL_M: f32 = 6.0;
const CELLS: usize = 72;
/// Half of the grid's side.
const HALF_M: f32 = 0.5 * CELL_M * CELLS as f32;
/// From the middle of a cell to its corners.
const CORNER_M: f32 = 0.708 * CELL_M;
/// Low beams reach so far aside by the meter ahead.
const BEAM_ASIDE: f32 = 1.08;
/// On dry ground, which mirrors nothing, small lenses matter no farther than this.
const DRY_LENS_M: f32 = 8.0;
/// Low beams of others matter no farther than this from their cars.
const OTHERS_BEAM_M: f32 = 65.0;
/// Within these distances the light of luminaires makes the mean irradiance of the ground.
const MEANS_WITHIN_M: [f32; 2] = [60.0, 180.0];
/// Flux of a luminaire by the intensity straight down, steradians: the integral of its distribution.
const LUMINAIRE_SR: f32 = 5.6;
/// Reflectance of what throws light back to where it comes from, times the irradiance square to the light: pi times 110 cd
/// per lx and m², between number plates (45) and signs (180), at no angle between lamp and eye.
pub const RETRO_REFLECTANCE: f32 = 350.0;
/// The sine of that angle at which half of it is left: 0.4 degrees.
pub const RETRO_SINE: f32 = 0.007;
/// Squared slopes of microfacets are at least this: lamps are no points.
pub const LEAST_LAMP_ALPHA_SQUARED: f32 = 0.002;

/// A lamp, relative to the eye.
#[derive(Debug, Clone, Copy)]
pub struct NightLamp {
    pub lamp: Lamp,
    pub up: Vec3,
    pub reach_square_m2: f32,
}

/// All lamps near the eye, by cells.
#[derive(Debug, Clone)]
pub struct NightLights {
    pub lamps: Vec<NightLamp>,
    /// Mean irradiance of luminaires on the ground around the eye.
    pub mean_on_ground: Vec3,
    /// The grid's first corner, relative to the eye.
    first: [f32; 2],
    /// By cell: where its lamps begin in `of_cells`; one more than there are cells.
    starts: Vec<u32>,
    of_cells: Vec<u16>,
}

impl NightLights {
    /// Collects the lamps of a scene near an eye.
    #[must_use]
    pub fn new(scene: &PosedScene, eye: DVec3, is_wet: bool) -> Self {
        let origin = eye.as_vec3();
        // Whole cells of the world, so that nothing flickers from frame to frame.
        let first = [eye.x, eye.y].map(|c| {
            let cell = (c / f64::from(CELL_M)).floor() * f64::from(CELL_M);
            (cell - c) as f32 + 0.5 * CELL_M - HALF_M
        });
        let near = |lamp: &NightLamp| lamp.lamp.at.truncate().abs().max_element() < HALF_M + lamp.lamp.reach_m;
        let lamps: Vec<NightLamp> = scene
            .lamps
            .iter()
            .map(|PosedLamp { lamp, actor_id }| {
                let reach_m = match lamp.beam {
                    LampBeam::Lens if !is_wet => DRY_LENS_M,
                    LampBeam::LowBeam if *actor_id > 0 => OTHERS_BEAM_M,
                    _ => lamp.reach_m,
                };
                let lamp = Lamp { at: lamp.at - origin, reach_m, ..*lamp };
                NightLamp { lamp, up: lamp.ahead.cross(lamp.left), reach_square_m2: reach_m * reach_m }
            })
            .filter(near)
            .collect();
        let mut lights =
            Self { mean_on_ground: mean_on_ground(&lamps), lamps, first, starts: Vec::new(), of_cells: Vec::new() };
        lights.fill_cells();
        lights
    }

    fn fill_cells(&mut self) {
        let mut cells: Vec<Vec<u16>> = vec![Vec::new(); CELLS * CELLS];
        for (number, lamp) in (0..u16::MAX).zip(&self.lamps) {
            let at = lamp.lamp.at;
            let reach_m = lamp.lamp.reach_m + CORNER_M;
            let range = |from: f32, middle: f32| {
                let cell = |d: f32| ((d - from) / CELL_M).clamp(0.0, CELLS as f32) as usize;
                cell(middle - reach_m)..cell(middle + reach_m + CELL_M).min(CELLS)
            };
            for row in range(self.first[1], at.y) {
                for column in range(self.first[0], at.x) {
                    let middle = |k: usize, from: f32| from + (k as f32 + 0.5) * CELL_M;
                    let to = Vec3::new(middle(column, self.first[0]) - at.x, middle(row, self.first[1]) - at.y, 0.0);
                    if to.length() < reach_m && may_shine_into(lamp, to) {
                        cells[row * CELLS + column].push(number);
                    }
                }
            }
        }
        self.starts.push(0);
        for cell in cells {
            self.of_cells.extend(cell);
            self.starts.push(self.of_cells.len() as u32);
        }
    }

    /// The cell of a place relative to the eye; [`NightLights::OUTSIDE`] beyond the grid.
    #[inline(always)]
    pub fn cell(&self, x: f32, y: f32) -> u32 {
        let (column, row) = ((x - self.first[0]) * (1.0 / CELL_M), (y - self.first[1]) * (1.0 / CELL_M));
        let inside = column >= 0.0 && row >= 0.0 && column < CELLS as f32 && row < CELLS as f32;
        if inside { row as u32 * CELLS as u32 + column as u32 } else { Self::OUTSIDE }
    }

    /// Beyond the grid no lamp shines.
    pub const OUTSIDE: u32 = u32::MAX;

    /// Numbers of the lamps that reach a cell.
    #[inline]
    pub fn of_cell(&self, cell: u32) -> &[u16] {
        let cell = cell as usize;
        match (self.starts.get(cell), self.starts.get(cell.wrapping_add(1))) {
            (Some(from), Some(to)) => &self.of_cells[*from as usize..*to as usize],
            _ => &[],
        }
    }
}

/// Mean irradiance on the ground around the eye, half of it that of a wide circle: the light of luminaires over the area.
fn mean_on_ground(lamps: &[NightLamp]) -> Vec3 {
    let within = |radius_m: f32| {
        let near = |l: &&NightLamp| {
            matches!(l.lamp.beam, LampBeam::Luminaire { .. }) && l.lamp.at.truncate().length() < radius_m
        };
        let sum: Vec3 = lamps.iter().filter(near).map(|l| Vec3::from(l.lamp.intensity)).sum();
        sum * (LUMINAIRE_SR / (std::f32::consts::PI * radius_m * radius_m))
    };
    MEANS_WITHIN_M.map(within).iter().sum::<Vec3>() * 0.5
}

/// Whether a lamp's light may reach a cell, by the vector to its middle in the plane.
fn may_shine_into(lamp: &NightLamp, to: Vec3) -> bool {
    if lamp.lamp.beam != LampBeam::LowBeam {
        return true;
    }
    let (ahead, left) = (lamp.lamp.ahead.dot(to), lamp.lamp.left.dot(to).abs());
    ahead > -2.0 * CORNER_M && left < BEAM_ASIDE * ahead.max(0.0) + 3.0 * CORNER_M
}

/// Pairs that are lit together.
pub const WIDE: usize = 8;
pub type Wide = [f32; WIDE];

/// Surfaces of some pairs, relative to the eye.
pub struct WideSurfaces {
    pub point: [Wide; 3],
    pub normal: [Wide; 3],
    /// From the eye.
    pub view: [Wide; 3],
    /// Share of light from above that vehicles leave.
    pub contact: Wide,
    pub f0: Wide,
    pub roughness: Wide,
    /// Share of the surface that mirrors lamps.
    pub mirror: Wide,
    pub flags: [u32; WIDE],
    pub is_leaf: bool,
    pub is_glossy: bool,
}

/// Light that falls on surfaces, and what they mirror of it.
#[derive(Default)]
pub struct WideLight {
    pub irradiance: [Wide; 3],
    pub mirrored: [Wide; 3],
}

/// Of light on leaves, what goes by the cosine and what is scattered to all sides: less of both than of
/// the sun's, since a crown hides half of itself from a lamp.
pub const LEAF_DIRECT_SHARE: f32 = 0.4;
pub const LEAF_SCATTERED_SHARE: f32 = 0.20;
const LEAF_THROUGH: f32 = 0.75;

/// Adds the light of a lamp where `share` is 1.
#[inline(always)]
pub fn add_lamp(lamp: &NightLamp, s: &WideSurfaces, share: &Wide, out: &mut WideLight) {
    let NightLamp { lamp, up, reach_square_m2 } = lamp;
    let (mut to, mut square, mut distance) = ([[0.0; WIDE]; 3], [0.0; WIDE], [0.0; WIDE]);
    for i in 0..WIDE {
        let d = Vec3::new(s.point[0][i], s.point[1][i], s.point[2][i]) - lamp.at;
        (to[0][i], to[1][i], to[2][i]) = (d.x, d.y, d.z);
        square[i] = d.dot(d).max(LEAST_SQUARE_M2);
        distance[i] = square[i].sqrt();
    }
    let mut strength = [0.0; WIDE];
    match lamp.beam {
        LampBeam::Luminaire { cos_ends: ends, cos_full: full } => {
            for i in 0..WIDE {
                let d = Vec3::new(to[0][i], to[1][i], to[2][i]);
                strength[i] = luminaire(d.dot(lamp.ahead) / distance[i], ends, full) * s.contact[i];
            }
        }
        LampBeam::LowBeam => {
            for i in 0..WIDE {
                let d = Vec3::new(to[0][i], to[1][i], to[2][i]);
                strength[i] = low_beam(d.dot(lamp.ahead), d.dot(lamp.left), d.dot(*up));
            }
        }
        LampBeam::Lens => {
            for i in 0..WIDE {
                let d = Vec3::new(to[0][i], to[1][i], to[2][i]);
                strength[i] = lens(d.dot(lamp.ahead) / distance[i]);
            }
        }
    }
    let color = Vec3::from(lamp.intensity);
    for i in 0..WIDE {
        // Irradiance square to the light.
        strength[i] *= share[i] * fade(square[i], *reach_square_m2) / square[i];
    }
    let mut facing = [0.0; WIDE];
    for i in 0..WIDE {
        let d = Vec3::new(to[0][i], to[1][i], to[2][i]);
        let cos = -d.dot(Vec3::new(s.normal[0][i], s.normal[1][i], s.normal[2][i])) / distance[i];
        facing[i] = cos.max(0.0);
        let lit = if s.is_leaf {
            (facing[i] + LEAF_THROUGH * (-cos).max(0.0)) * LEAF_DIRECT_SHARE + LEAF_SCATTERED_SHARE
        } else {
            facing[i]
        };
        let direct = strength[i] * lit;
        out.irradiance[0][i] += color.x * direct;
        out.irradiance[1][i] += color.y * direct;
        out.irradiance[2][i] += color.z * direct;
    }
    if s.flags.iter().any(|flags| flags & Flags::RETRO > 0) {
        for i in 0..WIDE {
            let d = Vec3::new(to[0][i], to[1][i], to[2][i]) / distance[i];
            let view = Vec3::new(s.view[0][i], s.view[1][i], s.view[2][i]);
            let sine = d.cross(view);
            let back = RETRO_REFLECTANCE / (1.0 + sine.dot(sine) / (RETRO_SINE * RETRO_SINE));
            let back = if s.flags[i] & Flags::RETRO > 0 && d.dot(view) > 0.0 { back } else { 0.0 };
            let thrown = strength[i] * facing[i] * back;
            out.irradiance[0][i] += color.x * thrown;
            out.irradiance[1][i] += color.y * thrown;
            out.irradiance[2][i] += color.z * thrown;
        }
    }
    if s.is_glossy {
        for i in 0..WIDE {
            let to_lamp = -Vec3::new(to[0][i], to[1][i], to[2][i]) / distance[i];
            let view = Vec3::new(s.view[0][i], s.view[1][i], s.view[2][i]);
            let normal = Vec3::new(s.normal[0][i], s.normal[1][i], s.normal[2][i]);
            let shine = strength[i] * s.mirror[i] * glint(to_lamp, view, normal, s.f0[i], s.roughness[i]);
            out.mirrored[0][i] += color.x * shine;
            out.mirrored[1][i] += color.y * shine;
            out.mirrored[2][i] += color.z * shine;
        }
    }
}

/// Lamps are no points: no place is nearer than 1.4 m to their light.
pub const LEAST_SQUARE_M2: f32 = 2.0;

/// Radiance that a coat mirrors, per irradiance square to the light: the microfacet model of Walter et al. (EGSR 2007) with
/// GGX's distribution, Smith's shadowing (Hammon 2017), and Schlick's Fresnel term.
#[inline(always)]
pub fn glint(to_lamp: Vec3, view: Vec3, normal: Vec3, f0: f32, roughness: f32) -> f32 {
    let alpha2 = (roughness * roughness * roughness * roughness).max(LEAST_LAMP_ALPHA_SQUARED);
    let alpha = alpha2.sqrt();
    let half = to_lamp - view;
    let half = half * (1.0 / half.dot(half).max(LEAST_HALF).sqrt());
    let (nl, nv) = (normal.dot(to_lamp).max(0.0), (-normal.dot(view)).max(LEAST_COS_VIEW));
    let (nh, lh) = (normal.dot(half), to_lamp.dot(half).max(0.0));
    let width = nh * nh * (alpha2 - 1.0) + 1.0;
    let away = 1.0 - lh;
    let away2 = away * away;
    let fresnel = f0 + (1.0 - f0) * (away2 * away2 * away);
    let shadowing = 0.5 / (nl * (nv * (1.0 - alpha) + alpha) + nv * (nl * (1.0 - alpha) + alpha)).max(LEAST_SHADOWING);
    let is_coated = if f0 > 0.0 { 1.0 } else { 0.0 };
    is_coated * fresnel * nl * shadowing * alpha2 / (width * width)
}

const LEAST_HALF: f32 = 1e-12;
const LEAST_COS_VIEW: f32 = 1e-3;
const LEAST_SHADOWING: f32 = 1e-6;
