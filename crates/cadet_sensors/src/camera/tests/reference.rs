//! A plain renderer, the oracle of the fast one: rays find what every sample sees, and each formula stands for one point.
//!
//! What it shares with the fast one are functions of a point or a direction that have tests of their own: patterns, the sky's
//! radiance and visibility, what a mirror shows. Visibility, shadow maps, light, transparency, and fog are its own.
//!
//! Light is found as coarsely as the fast one promises: [`rate`] says how, and [`Rate::Pixel`] does without.

mod lamps;
mod rate;
mod shading;
mod shadow;

use std::sync::Arc;

pub use self::rate::Rate;
use self::shadow::ShadowMap;
use crate::camera::View;
use crate::camera::light::{Light, Occluder, SkyProbes};
use crate::sense::{FaceHit, FaceTrees, MovingCaster, PosedScene, RigidMotion};
use crate::weather::Weather;
use cadet_base::math::{DVec3, Vec3};

pub const COLUMNS: usize = 8;
pub const ROWS: usize = 4;
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
}

/// The rows and columns of a block.
fn pixels() -> impl Iterator<Item = (usize, usize)> {
    (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column)))
}

impl Reference {
    pub fn new(scene: &Arc<PosedScene>, view: &View, weather: &Weather) -> Self {
        let (eye, forward) = (view.world_from_cam.translation, view.world_from_cam.rotation * DVec3::Z);
        let (sky, night) = Light::sources(scene, weather, eye);
        let shadows = if sky.has_shadows() { ShadowMap::both(scene, eye, forward, sky.sun_world) } else { Vec::new() };
        // The fast renderer places probes about what it sees: here they stand everywhere.
        let everywhere = (-150..150).flat_map(|x| (-150..150).map(move |y| DVec3::new(x.into(), y.into(), 0.0)));
        let everywhere: Vec<Vec3> = everywhere.map(|p| (eye + p).as_vec3()).collect();
        let rest = |_| RigidMotion::default();
        Self {
            view: view.clone(),
            caster: MovingCaster::new(Arc::clone(scene), &mut FaceTrees::default(), rest, 0.0, |_| true),
            scene: Arc::clone(scene),
            light: Light::new(weather, (sky, night), None, SkyProbes::new(scene, eye, forward, &everywhere)),
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
}
