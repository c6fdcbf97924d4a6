//! A plain renderer, the oracle of the fast one: rays find what every sample sees, and each formula stands for one point.
//!
//! What it shares with the fast one are scalar functions of a point or a direction: patterns, the sky's radiance, what a
//! mirror shows. Visibility, shadow maps, ambient visibility, transparency, fog, and exposure are its own.

mod ambient;
mod coarse;
mod exposure;
mod shading;
mod shadow;

use std::sync::Arc;

use self::ambient::Ambient;
pub use self::coarse::SkyRate;
pub use self::exposure::{gain, veil};
use self::shading::{Half, Surface};
use self::shadow::ShadowMap;
use crate::camera::View;
use crate::camera::sky::Sky;
use crate::math::{DVec3, Vec3};
use crate::sense::{FaceHit, FaceTrees, Motion, MovingCaster, PosedScene};
use crate::weather::Weather;

pub struct Reference {
    view: View,
    scene: Arc<PosedScene>,
    caster: MovingCaster,
    sky: Sky,
    /// Fine and near, then coarse and far; none without a sun.
    shadows: Vec<ShadowMap>,
    ambient: Ambient,
    wetness: f32,
    snow: f32,
    extinction_per_m: f32,
    /// By instance and face.
    halves: Vec<Vec<Half>>,
}

/// An instance and its face.
type Key = (u32, u32);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layer {
    Open,
    /// Behind what is transparent, by both samples of a pixel or by one of them.
    BehindBoth,
    BehindOne,
    Transparent,
}

/// What some samples of a pixel see in a layer; no key for the sky.
#[derive(Debug, Clone, Copy)]
struct Part {
    layer: Layer,
    key: Option<Key>,
    samples: [bool; 2],
}

impl Part {
    fn share(&self) -> f32 {
        0.5 * self.samples.iter().filter(|s| **s).count() as f32
    }
}

impl Reference {
    pub fn new(scene: &Arc<PosedScene>, view: &View, weather: &Weather) -> Self {
        let sky = Sky::new(weather);
        let maps = if sky.has_shadows() { ShadowMap::both(scene, view, sky.sun_world) } else { Vec::new() };
        let rest = |_| Motion::default();
        Self {
            view: view.clone(),
            caster: MovingCaster::new(Arc::clone(scene), &mut FaceTrees::default(), rest, 0.0, |_| true),
            scene: Arc::clone(scene),
            sky,
            shadows: maps,
            ambient: Ambient::new(scene, view),
            wetness: weather.wetness as f32,
            snow: weather.snow_cover() as f32,
            // Clear air has some haze.
            extinction_per_m: 0.000_8 + weather.extinction_per_m() as f32,
            halves: scene.instances.iter().map(|i| shading::halves_of(&i.mesh)).collect(),
        }
    }

    /// Linear radiance of a pixel, the light of each surface found in the middle of the samples that see it.
    pub fn pixel(&self, row: usize, column: usize) -> Vec3 {
        self.color(&self.parts(row, column), row, column, |surface, part| {
            let [u, v] = middle(column, row, &part.samples);
            let at = self.point(surface, u, v);
            (self.albedo(surface, &at), self.light(surface, &at, &self.open(surface, &at)))
        })
    }

    /// World direction of an image point, of length 1 along the optical axis.
    fn direction(&self, u: f64, v: f64) -> DVec3 {
        let [fx, fy, cx, cy] = self.view.intrinsics;
        self.view.world_from_cam.rotation * DVec3::new((u - cx) / fx, (v - cy) / fy, 1.0)
    }

    /// What a pixel's two samples see: one on its center, the other half a pixel to the right and below.
    fn parts(&self, row: usize, column: usize) -> Vec<Part> {
        let now = self.caster.at(0.0);
        let seen = [0.0, 0.5].map(|aside| {
            let direction = self.direction(column as f64 + aside, row as f64 + aside).normalize();
            now.cast(self.view.world_from_cam.translation, direction)
        });
        let key = |hit: FaceHit| (hit.instance, self.halves[hit.instance as usize][hit.face as usize].first);
        let [mut opaque, transparent] = [seen.map(|s| s.opaque.map(key)), seen.map(|s| s.transparent.map(key))];
        let behind = transparent.map(|p| p.is_some());
        if let ([Some(a), Some(b)], true) = (opaque, behind[0] == behind[1]) {
            // Leaves differ without order: the first one stands for both. What is one surface to the eye is shaded once.
            let are_one = self.are_of_one_plant(a, b) || !behind[0] && self.look_alike(a, b);
            opaque[1] = if are_one { Some(a) } else { Some(b) };
        }
        let layer = |is_behind: bool| match (is_behind, behind) {
            (false, _) => Layer::Open,
            (true, [true, true]) => Layer::BehindBoth,
            (true, _) => Layer::BehindOne,
        };
        let all = (0..2).map(|i| (i, layer(behind[i]), opaque[i]));
        let transparent = (0..2).filter(|i| behind[*i]).map(|i| (i, Layer::Transparent, transparent[i]));
        let mut parts: Vec<Part> = Vec::new();
        for (sample, layer, key) in all.chain(transparent) {
            match parts.iter_mut().find(|p| (p.layer, p.key) == (layer, key)) {
                Some(part) => part.samples[sample] = true,
                None => parts.push(Part { layer, key, samples: [sample == 0, sample == 1] }),
            }
        }
        parts
    }

    /// Puts a pixel together. `shaded` says a surface's albedo and its light: what counts with the albedo (or with what is
    /// behind), and what does not.
    fn color(
        &self,
        parts: &[Part],
        row: usize,
        column: usize,
        shaded: impl Fn(&Surface<'_>, &Part) -> (Vec3, [Vec3; 2]),
    ) -> Vec3 {
        let (mut sum, mut behind, mut share_behind) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for part in parts.iter().filter(|p| p.layer != Layer::Transparent) {
            let color = match part.key {
                None => self.sky_at(column as f64 + 0.25, row as f64 + 0.25),
                Some(key) => {
                    let (albedo, [diffuse, specular]) = shaded(&self.surface(key), part);
                    albedo * diffuse + specular
                }
            };
            if part.layer == Layer::Open {
                sum += color * part.share();
            } else {
                (behind, share_behind) = (behind + color * part.share(), share_behind + part.share());
            }
        }
        for (part, key) in parts.iter().filter(|p| p.layer == Layer::Transparent).filter_map(|p| Some((p, p.key?))) {
            let (_, [through, specular]) = shaded(&self.surface(key), part);
            sum += (behind / share_behind * through + specular) * part.share();
        }
        sum
    }
}

/// The middle of some samples of pixels side by side, two a pixel.
fn middle(column: usize, row: usize, samples: &[bool]) -> [f64; 2] {
    let set = samples.iter().enumerate().filter(|(_, is_set)| **is_set).map(|(i, _)| i);
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    for i in set {
        let aside = 0.5 * (i % 2) as f64;
        sum = [sum[0] + column as f64 + (i / 2) as f64 + aside, sum[1] + row as f64 + aside];
        count += 1.0;
    }
    sum.map(|s| s / count)
}
