//! A plain renderer, the oracle of the fast one: rays find what every sample sees, and each formula stands for one point.
//!
//! What it shares with the fast one are functions of a point or a direction that have tests of their own: patterns, the sky's
//! radiance and visibility, what a mirror shows. Visibility, shadow maps, light, transparency, and fog are its own.
//!
//! It finds light as coarsely as the fast one promises:
//! * Light is found in the middle of those samples of two pixels side by side that see one surface, and is linear from such
//!   a pair to the next, within eight columns ("coarse pixel shading": Vaidyanathan et al., HPG 2014).
//! * The visibility of the sky is found at the corners of blocks of eight by four pixels, on the surface's plane, and is
//!   bilinear between them; of what few samples of a block see, it is that of one of them.

mod shading;
mod shadow;

use std::ops::Range;
use std::sync::Arc;

use self::shading::Surface;
use self::shadow::ShadowMap;
use crate::camera::View;
use crate::camera::contact_occlusion::Occluder;
use crate::camera::light::Light;
use crate::camera::sky::Sky;
use crate::camera::sky_visibility::{SkyProbes, SkyVisibility};
use crate::math::{DVec3, Vec3};
use crate::sense::{FaceHit, FaceTrees, Motion, MovingCaster, PosedScene};
use crate::weather::Weather;

pub const COLUMNS: usize = 8;
pub const ROWS: usize = 4;
/// Pixels of a block that are few.
const FEW: f32 = 6.0;
/// The middle of a pixel's two samples.
const MIDDLE: f64 = 0.25;

pub struct Reference {
    view: View,
    scene: Arc<PosedScene>,
    caster: MovingCaster,
    light: Light,
    /// Fine and near, then coarse and far; none without a sun.
    shadows: Vec<ShadowMap>,
    /// What hides the sky from the ground near by.
    occluders: Vec<Occluder>,
    /// By instance and face: the first of the face's piece.
    firsts: Vec<Vec<u32>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rate {
    /// Light is found as coarsely as stated above.
    Coarse,
    /// Light is found in every pixel.
    Pixel,
}

/// An instance and its face.
type Key = (u32, u32);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layer {
    Open,
    /// Behind what is transparent.
    Behind,
    Transparent,
}

/// What some samples of a block's pixels see in a layer; no key for the sky.
struct Part {
    layer: Layer,
    key: Option<Key>,
    /// The block's first pixel.
    top: usize,
    left: usize,
    samples: [[[bool; 2]; COLUMNS]; ROWS],
}

impl Part {
    fn share(&self, row: usize, column: usize) -> f32 {
        0.5 * self.samples[row][column].iter().filter(|is_seen| **is_seen).count() as f32
    }

    /// The middle of the samples of some pixels in a row.
    fn middle(&self, row: usize, columns: Range<usize>) -> [f64; 2] {
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for (column, aside) in columns.flat_map(|column| [(column, 0.0), (column, 0.5)]) {
            if self.samples[row][column][usize::from(aside > 0.0)] {
                sum = [sum[0] + (self.left + column) as f64 + aside, sum[1] + (self.top + row) as f64 + aside];
                count += 1.0;
            }
        }
        sum.map(|s| s / count)
    }
}

/// The rows and columns of a block.
fn pixels() -> impl Iterator<Item = (usize, usize)> {
    (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column)))
}

impl Reference {
    pub fn new(scene: &Arc<PosedScene>, view: &View, weather: &Weather) -> Self {
        let (eye, forward) = (view.world_from_cam.translation, view.world_from_cam.rotation * DVec3::Z);
        let sky = Sky::new(weather);
        let shadows = if sky.has_shadows() { ShadowMap::both(scene, eye, forward, sky.sun_world) } else { Vec::new() };
        // The fast renderer places probes about what it sees: here they stand everywhere.
        let everywhere = (-150..150).flat_map(|x| (-150..150).map(move |y| DVec3::new(x.into(), y.into(), 0.0)));
        let everywhere: Vec<Vec3> = everywhere.map(|p| (eye + p).as_vec3()).collect();
        let rest = |_| Motion::default();
        Self {
            view: view.clone(),
            caster: MovingCaster::new(Arc::clone(scene), &mut FaceTrees::default(), rest, 0.0, |_| true),
            scene: Arc::clone(scene),
            light: Light::new(weather, sky, None, SkyProbes::new(scene, eye, forward, &everywhere)),
            shadows,
            occluders: scene.instances.iter().filter_map(Occluder::of).collect(),
            firsts: scene.instances.iter().map(|i| shading::firsts_of(&i.mesh)).collect(),
        }
    }

    /// Linear radiance of a block of pixels.
    pub fn block(&self, top: usize, left: usize, rate: Rate) -> [[Vec3; COLUMNS]; ROWS] {
        let black = [[Vec3::ZERO; COLUMNS]; ROWS];
        let (mut image, mut behind, mut share_behind) = (black, black, [[0.0; COLUMNS]; ROWS]);
        let parts = self.parts(top, left);
        let (transparent, opaque): (Vec<_>, Vec<_>) = parts.iter().partition(|p| p.layer == Layer::Transparent);
        for part in opaque.into_iter().chain(transparent) {
            for (row, column) in pixels().filter(|(row, column)| part.share(*row, *column) > 0.0) {
                let share = part.share(row, column);
                let color = match part.key {
                    None => self.sky_at([(left + column) as f64 + MIDDLE, (top + row) as f64 + MIDDLE]),
                    Some(key) => {
                        let (albedo, [diffuse, specular]) = self.shaded(part, &self.surface(key), row, column, rate);
                        let is_opaque = part.layer != Layer::Transparent;
                        let base = if is_opaque { albedo } else { behind[row][column] / share_behind[row][column] };
                        base * diffuse + specular
                    }
                };
                if part.layer == Layer::Behind {
                    behind[row][column] += color * share;
                    share_behind[row][column] += share;
                } else {
                    image[row][column] += color * share;
                }
            }
        }
        image
    }

    /// What the samples of a block see: of every pixel one on its center, the other half a pixel to the right and below.
    fn parts(&self, top: usize, left: usize) -> Vec<Part> {
        let mut parts: Vec<Part> = Vec::new();
        let mut add = |row: usize, column: usize, sample: usize, layer, key| {
            let known = parts.iter().position(|p| (p.layer, p.key) == (layer, key)).unwrap_or(parts.len());
            if known == parts.len() {
                parts.push(Part { layer, key, top, left, samples: [[[false; 2]; COLUMNS]; ROWS] });
            }
            parts[known].samples[row][column][sample] = true;
        };
        let is_within =
            |(row, column): &(usize, usize)| top + row < self.view.height && left + column < self.view.width;
        for (row, column) in pixels().filter(is_within) {
            let seen = [0.0, 0.5].map(|aside| {
                let direction = self.direction([(left + column) as f64 + aside, (top + row) as f64 + aside]);
                self.caster.at(0.0).cast(self.view.world_from_cam.translation, direction.normalize())
            });
            let key = |hit: FaceHit| (hit.instance, self.firsts[hit.instance as usize][hit.face as usize]);
            let [mut opaque, transparent] = [seen.map(|s| s.opaque.map(key)), seen.map(|s| s.transparent.map(key))];
            let behind = transparent.map(|p| p.is_some());
            if let ([Some(a), Some(b)], true) = (opaque, behind[0] == behind[1]) {
                // Leaves differ without order: the first one stands for both. What is one surface to the eye is shaded once.
                if self.are_of_one_plant(a, b) || !behind[0] && self.look_alike(a, b) {
                    opaque[1] = Some(a);
                }
            }
            for sample in 0..2 {
                add(row, column, sample, if behind[sample] { Layer::Behind } else { Layer::Open }, opaque[sample]);
                if behind[sample] {
                    add(row, column, sample, Layer::Transparent, transparent[sample]);
                }
            }
        }
        parts
    }

    /// A surface's albedo in a pixel of a block, and its light: what counts with the albedo (or with what is behind), and what
    /// does not.
    fn shaded(&self, part: &Part, s: &Surface<'_>, row: usize, column: usize, rate: Rate) -> (Vec3, [Vec3; 2]) {
        if rate == Rate::Pixel {
            let at = self.point(s, part.middle(row, column..column + 1));
            return (self.albedo(s, &at), self.light(s, &at, &self.open(s, &at)));
        }
        let light_of = |pair: usize| {
            let middle = part.middle(row, pair..pair + 2);
            let at = self.point(s, middle);
            self.light(s, &at, &if s.is_leaf { self.open(s, &at) } else { self.open_in_block(part, s, middle) })
        };
        let (pair, line) = (column / 2 * 2, &part.samples[row]);
        let is_whole = |pair: usize| line[pair..pair + 2] == [[true; 2]; 2];
        let goes_on = |to: &usize| *to < COLUMNS && is_whole(pair) && is_whole(*to);
        let here = light_of(pair);
        let before = pair.checked_sub(2).filter(goes_on).map(light_of);
        let after = Some(pair + 2).filter(goes_on).map(light_of);
        let side = if column == pair { -1.0 } else { 1.0 };
        let light = std::array::from_fn(|k| {
            let (fall, rise) = (before.map(|b| here[k] - b[k]), after.map(|a| a[k] - here[k]));
            let slope = if side < 0.0 { fall.or(rise) } else { rise.or(fall) }.unwrap_or(Vec3::ZERO);
            (here[k] + slope * 0.25 * side).max(Vec3::ZERO)
        });
        let is_in_both = part.share(row, pair) > 0.0 && part.share(row, pair + 1) > 0.0;
        let [u, v] = part.middle(row, pair..pair + 2);
        let aside = if is_in_both { 0.5 * f64::from(side) } else { 0.0 };
        (self.albedo(s, &self.point(s, [u + aside, v])), light)
    }

    /// The visibility of the sky at an image point of a block.
    fn open_in_block(&self, part: &Part, s: &Surface<'_>, [u, v]: [f64; 2]) -> SkyVisibility {
        let first = [part.left as f64 + MIDDLE, part.top as f64 + MIDDLE];
        // One of the pixels, in the middle of the columns.
        let columns = || (0..COLUMNS).filter(|column| (0..ROWS).any(|row| part.share(row, *column) > 0.0));
        let middle = (columns().min().unwrap_or(0) + columns().max().unwrap_or(0)) / 2;
        let column = columns().find(|column| *column >= middle).unwrap_or(middle);
        let row = (0..ROWS).find(|row| part.share(*row, column) > 0.0).unwrap_or(0);
        let one = self.point(s, [first[0] + column as f64, first[1] + row as f64]);
        if pixels().map(|(row, column)| part.share(row, column)).sum::<f32>() <= FEW {
            return self.open(s, &one);
        }
        let (across, down) = (((u - first[0]) / COLUMNS as f64) as f32, ((v - first[1]) / ROWS as f64) as f32);
        let mut sum = [0.0; 6];
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let corner = [first[0] + (i * COLUMNS) as f64, first[1] + (j * ROWS) as f64];
            // The plane may end, or rise to the eye, before the corner.
            let corner = self.point_within(s, corner, [0.5, 2.0].map(|k| k * f64::from(one.depth_m)));
            let weight = (if i == 1 { across } else { 1.0 - across }) * if j == 1 { down } else { 1.0 - down };
            for (sum, open) in sum.iter_mut().zip(self.open(s, &corner)) {
                *sum += weight * open;
            }
        }
        sum
    }
}
