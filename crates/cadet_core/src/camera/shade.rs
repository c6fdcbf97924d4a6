//! The light that leaves surfaces towards the camera: many hits of one kind at a time, one a lane.
//!
//! Every lane computes the same IEEE operations in the same order whatever the instruction set, so that the bytes are
//! the same with wide registers and without.

use multiversion::multiversion;

use super::ambient::SkyView;
use super::faces::{Face, Flags, Kind};
use super::pattern::{self, PatternPoint};
use super::shadow::{Asked, Shadows};
use super::sky::Sky;
use crate::material::Pattern;
use crate::math::Vec3;
use crate::weather::Weather;

/// All the light of a scene.
#[derive(Debug, Clone)]
pub struct Light {
    /// Sun and sky.
    pub sky: Sky,
    /// The sun's shadows; none under an overcast sky.
    pub shadows: Option<Shadows>,
    /// What hides the sky.
    pub sky_view: SkyView,
    /// 0 is dry, 1 a film of water.
    pub wetness: f32,
    /// Extinction of the air, 1/m.
    pub extinction_per_m: f32,
    /// Cover of snow on level ground, 0..1.
    pub snow: f32,
}

/// Haze of clear air, 1/m.
const CLEAR_AIR_PER_M: f32 = 0.000_8;

impl Light {
    /// Puts the parts together.
    #[must_use]
    pub fn new(weather: &Weather, sky: Sky, shadows: Option<Shadows>, sky_view: SkyView) -> Self {
        Self {
            sky,
            shadows,
            sky_view,
            wetness: weather.wetness as f32,
            extinction_per_m: CLEAR_AIR_PER_M + weather.extinction_per_m() as f32,
            snow: weather.snow_cover() as f32,
        }
    }

    /// The air between: haze, fog, rain.
    #[must_use]
    pub fn through_air(&self, radiance: Vec3, view_world: Vec3, distance_m: f32) -> Vec3 {
        let t = clear_share(self.extinction_per_m, distance_m);
        radiance * t + self.air(view_world) * (1.0 - t)
    }

    /// Radiance of the air along a view, were it endless.
    #[inline]
    #[must_use]
    pub fn air(&self, view_world: Vec3) -> Vec3 {
        self.sky.radiance(Vec3::new(view_world.x, view_world.y, view_world.z.max(0.02))) * 0.8
    }
}

/// Share of the light that the air lets through: exp(-x) by (1 + x/16)^-16.
#[inline(always)]
fn clear_share(extinction_per_m: f32, distance_m: f32) -> f32 {
    let mut t = 1.0 / (1.0 + extinction_per_m * distance_m * (1.0 / 16.0));
    t *= t;
    t *= t;
    t *= t;
    t * t
}

/// Hits that are shaded together.
pub const LANES: usize = 128;
/// A few more than are used: arrays a power of two apart would share the sets of the cache.
const STRIDE: usize = LANES + 16;
type Lane = [f32; STRIDE];
type Lane3 = [Lane; 3];

/// One hit to be shaded: samples of a pixel that show the same face.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Index of the face.
    pub face: u32,
    /// Index of the sky's visibility.
    pub open: u32,
    /// Index of the pixel in the band.
    pub pixel: u32,
    /// Where the colour is kept of what is seen through a pane; `NO_SLOT` without one.
    pub slot: u32,
    /// Share of the pixel.
    pub weight: f32,
    /// Image point.
    pub u: f32,
    /// Image point.
    pub v: f32,
    /// Along the optical axis, metres.
    pub depth: f32,
}

/// No pane before a hit.
pub const NO_SLOT: u32 = u32::MAX;

/// Hits of one kind, lane by lane: what is known of them, and what is found.
pub struct Lanes {
    u: Lane,
    v: Lane,
    depth: Lane,
    origin: Lane3,
    face_normal: Lane3,
    axis_u: Lane3,
    axis_v: Lane3,
    at_origin: [Lane; 2],
    normal_ab: Lane3,
    normal_ac: Lane3,
    to_b: Lane3,
    to_c: Lane3,
    specular: Lane,
    roughness: Lane,
    transmission: Lane,
    face_hash: [u32; STRIDE],
    place_hash: [u32; STRIDE],
    flags: [u32; STRIDE],
    open: [Lane; 6],
    air: Lane3,
    behind: Lane3,
    /// Unit vectors from the eye.
    view: Lane3,
    /// Relative to the eye.
    point: Lane3,
    distance_m: Lane,
    footprint_m: Lane,
    texture: [Lane; 2],
    /// At first of the first corner, then the unit shading normal.
    normal: Lane3,
    cos_sun: Lane,
    cos_face: Lane,
    is_asked: [bool; STRIDE],
    lit: Lane,
    near: Lane,
    /// At first of the material, then of the place.
    albedo: Lane3,
    metal: Lane3,
    /// The radiance that arrives at the camera.
    pub out: Lane3,
}

#[inline(always)]
fn get<const N: usize>(lanes: &[[f32; N]; 3], i: usize) -> Vec3 {
    Vec3::new(lanes[0][i], lanes[1][i], lanes[2][i])
}

#[inline(always)]
fn put<const N: usize>(lanes: &mut [[f32; N]; 3], i: usize, v: Vec3) {
    (lanes[0][i], lanes[1][i], lanes[2][i]) = (v.x, v.y, v.z);
}

/// The same for all hits of an image.
#[derive(Debug, Clone, Copy)]
pub struct Camera {
    /// World coordinates.
    pub eye: Vec3,
    /// Directions of image points, of length 1 along the optical axis: `corner + right * u + down * v`.
    pub corner: Vec3,
    /// See `corner`.
    pub right: Vec3,
    /// See `corner`.
    pub down: Vec3,
    /// Size of a pixel at 1 m.
    pub pixel_per_m: f32,
}

impl Default for Lanes {
    fn default() -> Self {
        const O: Lane = [0.0; STRIDE];
        const O3: Lane3 = [O; 3];
        Self {
            u: O,
            v: O,
            depth: O,
            origin: O3,
            face_normal: O3,
            axis_u: O3,
            axis_v: O3,
            at_origin: [O; 2],
            normal_ab: O3,
            normal_ac: O3,
            to_b: O3,
            to_c: O3,
            specular: O,
            roughness: O,
            transmission: O,
            face_hash: [0; STRIDE],
            place_hash: [0; STRIDE],
            flags: [0; STRIDE],
            open: [O; 6],
            air: O3,
            behind: O3,
            view: O3,
            point: O3,
            distance_m: O,
            footprint_m: O,
            texture: [O; 2],
            normal: O3,
            cos_sun: O,
            cos_face: O,
            is_asked: [false; STRIDE],
            lit: O,
            near: O,
            albedo: O3,
            metal: O3,
            out: O3,
        }
    }
}

impl Lanes {
    /// Shades up to `LANES` hits of one kind; the outcome is in `out`.
    ///
    /// `air`: red, green and blue of the endless air for each pixel; `behind`: the colours behind panes.
    pub fn shade(
        &mut self,
        light: &Light,
        camera: &Camera,
        kind: Kind,
        hits: &[Hit],
        (faces, open): (&[Face], &[[f32; 8]]),
        air: &[[f32; 3]],
        behind: &[[f32; 3]],
    ) {
        let n = hits.len().min(LANES);
        self.gather(kind, hits, (faces, open), air, behind);
        // Whole registers: what is left in the lanes beyond is nobody's.
        let m = n.next_multiple_of(16);
        geometry(self, m, camera, light.sky.sun_world, kind.is_smooth);
        self.cast_shadows(light, camera.eye, kind, n);
        if kind.is_pane {
            pane(self, m, &light.sky);
        } else {
            texture(self, m, kind.pattern);
            if light.snow > 0.0 {
                snow(self, m, camera.eye, light.snow);
            }
            let wetness = light.wetness;
            diffuse(self, m, &light.sky, kind.pattern == Pattern::Leaves, wetness);
            if kind.is_glossy {
                gloss(self, m, &light.sky, camera.eye, wetness);
            }
        }
        through_air(self, m, light.extinction_per_m);
    }

    fn gather(
        &mut self,
        kind: Kind,
        hits: &[Hit],
        (faces, open): (&[Face], &[[f32; 8]]),
        air: &[[f32; 3]],
        behind: &[[f32; 3]],
    ) {
        let hits = &hits[..hits.len().min(LANES)];
        gather_faces(self, kind, hits, faces);
        gather_open(self, hits, open);
        for (i, hit) in hits.iter().enumerate() {
            (self.u[i], self.v[i], self.depth[i]) = (hit.u, hit.v, hit.depth);
            put(&mut self.air, i, air[hit.pixel as usize].into());
        }
        if kind.is_pane {
            for (i, hit) in hits.iter().enumerate() {
                put(&mut self.behind, i, behind[hit.slot as usize].into());
            }
        }
    }

    /// Looks up what the sun's shadows and the cars near by leave.
    fn cast_shadows(&mut self, light: &Light, eye: Vec3, kind: Kind, n: usize) {
        let is_leaf = kind.pattern == Pattern::Leaves;
        for i in 0..LANES {
            let faces_sun = (self.cos_face[i] > 0.0) & ((self.cos_sun[i] > 0.0) | kind.is_pane);
            self.is_asked[i] = (i < n) & (is_leaf | faces_sun);
        }
        match &light.shadows {
            Some(shadows) if self.is_asked.contains(&true) => {
                let asked = Asked {
                    points: &self.point,
                    normals: &self.face_normal,
                    cos_sun: &self.cos_face,
                    is_asked: &self.is_asked,
                    count: n,
                };
                shadows.sunlit(eye, &asked, &mut self.lit);
            }
            _ => self.lit.fill(0.0),
        }
        for i in 0..n {
            self.is_asked[i] = self.flags[i] & Flags::CONTACT > 0;
        }
        light.sky_view.contact(eye, &self.point, &self.is_asked, n, &mut self.near);
    }
}

/// Lanes that are filled together: neighbours often show one face.
const RUN: usize = 8;

/// The lanes from `start` on; those that are nobody's yet are filled again when their turn comes.
#[inline(always)]
fn run<T: Copy, const N: usize>(lane: &mut [T; N], start: usize, value: T) {
    if let Some(run) = lane[start..].first_chunk_mut::<RUN>() {
        *run = [value; RUN];
    }
}

#[inline(always)]
fn run3(lanes: &mut Lane3, start: usize, value: Vec3) {
    let [x, y, z] = lanes;
    run(x, start, value.x);
    run(y, start, value.y);
    run(z, start, value.z);
}

/// How many of the first hits, at most `RUN`, agree in something with the first of them.
#[inline(always)]
fn run_of(hits: &[Hit], of: impl Fn(&Hit) -> u32) -> usize {
    hits.iter().take(RUN).take_while(|hit| of(hit) == of(&hits[0])).count()
}

#[multiversion(targets("x86_64+avx2"))]
fn gather_faces(l: &mut Lanes, kind: Kind, hits: &[Hit], faces: &[Face]) {
    let mut i = 0;
    while i < hits.len().min(LANES) {
        let face = &faces[hits[i].face as usize];
        run3(&mut l.origin, i, face.origin);
        run3(&mut l.face_normal, i, face.face_normal);
        run3(&mut l.normal, i, face.normal);
        if kind.is_smooth {
            run3(&mut l.normal_ab, i, face.normal_ab);
            run3(&mut l.normal_ac, i, face.normal_ac);
            run3(&mut l.to_b, i, face.to_b);
            run3(&mut l.to_c, i, face.to_c);
        }
        if kind.pattern != Pattern::Plain {
            run3(&mut l.axis_u, i, face.axes[0]);
            run3(&mut l.axis_v, i, face.axes[1]);
            run(&mut l.at_origin[0], i, face.at_origin[0]);
            run(&mut l.at_origin[1], i, face.at_origin[1]);
        }
        if kind.pattern == Pattern::Leaves {
            run(&mut l.face_hash, i, face.face_hash);
            run(&mut l.place_hash, i, face.place_hash);
        }
        run3(&mut l.albedo, i, face.albedo);
        if kind.is_glossy || kind.is_pane {
            run3(&mut l.metal, i, face.albedo);
            run(&mut l.specular, i, face.specular);
            run(&mut l.roughness, i, face.roughness);
            run(&mut l.transmission, i, face.transmission);
        }
        run(&mut l.flags, i, face.flags);
        i += run_of(&hits[i..], |hit| hit.face);
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn gather_open(l: &mut Lanes, hits: &[Hit], open: &[[f32; 8]]) {
    let mut i = 0;
    while i < hits.len().min(LANES) {
        for (lane, o) in l.open.iter_mut().zip(&open[hits[i].open as usize]) {
            run(lane, i, *o);
        }
        i += run_of(&hits[i..], |hit| hit.open);
    }
}

/// Where the hits are, how the surfaces lie there, and the sun to them.
#[multiversion(targets("x86_64+avx2"))]
fn geometry(l: &mut Lanes, m: usize, camera: &Camera, sun: Vec3, is_smooth: bool) {
    for i in 0..m.min(LANES) {
        let direction = camera.corner + camera.right * l.u[i] + camera.down * l.v[i];
        let length = direction.dot(direction).sqrt();
        let point = direction * l.depth[i];
        let view = direction * (1.0 / length);
        put(&mut l.view, i, view);
        put(&mut l.point, i, point);
        l.distance_m[i] = l.depth[i] * length;
        let d = point - get(&l.origin, i);
        l.texture[0][i] = d.dot(get(&l.axis_u, i)) + l.at_origin[0][i];
        l.texture[1][i] = d.dot(get(&l.axis_v, i)) + l.at_origin[1][i];
        let face_normal = get(&l.face_normal, i);
        let cos_view = view.dot(face_normal).abs().max(0.02);
        l.footprint_m[i] = l.depth[i] * camera.pixel_per_m / cos_view.sqrt();
        l.cos_face[i] = face_normal.dot(sun);
    }
    if is_smooth {
        for i in 0..m.min(LANES) {
            let d = get(&l.point, i) - get(&l.origin, i);
            let wb = d.dot(get(&l.to_b, i)).clamp(0.0, 1.0);
            let wc = d.dot(get(&l.to_c, i)).max(0.0).min(1.0 - wb);
            let normal = get(&l.normal, i) + get(&l.normal_ab, i) * wb + get(&l.normal_ac, i) * wc;
            let scale = 1.0 / normal.dot(normal).max(1e-20).sqrt();
            put(&mut l.normal, i, normal * scale);
        }
    }
    for i in 0..m.min(LANES) {
        l.cos_sun[i] = get(&l.normal, i).dot(sun);
    }
}

/// The albedo, by the kind's texture.
#[multiversion(targets("x86_64+avx2"))]
fn texture(l: &mut Lanes, m: usize, pattern: Pattern) {
    macro_rules! fill {
        ($($of:ident),*) => {
            match pattern {
                Pattern::Plain => (),
                $(Pattern::$of => {
                    for i in 0..m.min(LANES) {
                        let at = PatternPoint {
                            u: l.texture[0][i],
                            v: l.texture[1][i],
                            footprint_m: l.footprint_m[i],
                            face_hash: l.face_hash[i],
                            place_hash: l.place_hash[i],
                        };
                        let albedo = pattern::albedo(Pattern::$of, get(&l.albedo, i), &at);
                        put(&mut l.albedo, i, albedo);
                    }
                })*
            }
        };
    }
    fill!(Asphalt, Slabs, Blocks, Bricks, Render, Tiles, Grass, Leaves, Wood, Cloth);
}

#[multiversion(targets("x86_64+avx2"))]
fn snow(l: &mut Lanes, m: usize, eye: Vec3, snow: f32) {
    for i in 0..m.min(LANES) {
        let (x, y) = (l.point[0][i] + eye.x, l.point[1][i] + eye.y);
        let drift = pattern::value_noise(x * 0.6, y * 0.6, 0x5E0);
        let worn = if l.flags[i] & Flags::ROAD > 0 { 0.55 } else { 1.0 };
        let lies = if l.flags[i] & Flags::VEHICLE > 0 { 0.0 } else { 1.0 };
        let level = ((l.normal[2][i] - 0.4) * 2.0).clamp(0.0, 1.0);
        let cover = level * (snow * worn * (0.5 + drift)).min(1.0) * lies;
        let albedo = get(&l.albedo, i);
        put(&mut l.albedo, i, albedo + (Vec3::splat(0.8) - albedo) * cover);
    }
}

/// The light that a matt surface sends.
#[multiversion(targets("x86_64+avx2"))]
fn diffuse(l: &mut Lanes, m: usize, sky: &Sky, is_leaf: bool, wetness: f32) {
    for i in 0..m.min(LANES) {
        let normal = get(&l.normal, i);
        let open = [l.open[0][i], l.open[1][i], l.open[2][i], l.open[3][i], l.open[4][i], l.open[5][i]];
        // What hides the sky sends some light itself, from sunlit walls and ground.
        let mean_open = (open[0] + open[1] + open[2] + open[3] + open[4]) * 0.2;
        let from_around = sky.ground * (0.60 * (1.0 - mean_open));
        let ambient = (sky.ambient(normal, &open) + from_around) * l.near[i];
        let cos_sun = l.cos_sun[i];
        let facing = cos_sun.max(0.0);
        let direct = if is_leaf {
            // Leaves turn to all sides and let through a third of the light, yellower.
            let through = Vec3::new(0.85, 1.0, 0.50) * (0.40 * (-cos_sun).max(0.0));
            (Vec3::splat(facing) + through) * 0.8 + Vec3::splat(0.12)
        } else {
            Vec3::splat(facing)
        };
        let wet = if normal.z > 0.5 { 1.0 - 0.45 * wetness } else { 1.0 };
        let albedo = get(&l.albedo, i) * wet;
        put(&mut l.out, i, albedo * (sky.sun * direct * l.lit[i] + ambient));
    }
}

/// Adds what a coat or a film of water mirrors.
#[multiversion(targets("x86_64+avx2"))]
fn gloss(l: &mut Lanes, m: usize, sky: &Sky, eye: Vec3, wetness: f32) {
    for i in 0..m.min(LANES) {
        let (view, normal) = (get(&l.view, i), get(&l.normal, i));
        let (x, y) = (l.point[0][i] + eye.x, l.point[1][i] + eye.y);
        let puddle = pattern::value_noise(x * 0.35, y * 0.35, 0xF11);
        let is_wet = l.flags[i] & Flags::GROUND > 0 && normal.z > 0.5;
        let film = if is_wet { (wetness * 1.5 - 0.9 * puddle).clamp(0.0, 1.0) } else { 0.0 };
        let f0 = if film > 0.0 { 0.02 } else { l.specular[i] };
        let roughness = if film > 0.0 { 0.45 - 0.37 * film } else { l.roughness[i] };
        let cos_view = (-view.dot(normal)).clamp(0.0, 1.0);
        let smooth = (1.0 - roughness) * (1.0 - roughness);
        let fresnel = f0 + (1.0 - f0) * fifth(1.0 - cos_view) * smooth;
        let fresnel = if f0 > 0.0 { fresnel } else { 0.0 };
        let mirrored = view + normal * (2.0 * cos_view);
        let open = [l.open[0][i], l.open[1][i], l.open[2][i], l.open[3][i]];
        let shine = environment(sky, mirrored, &open, roughness) * l.near[i].max(0.3)
            + highlight(sky, mirrored, roughness) * l.lit[i];
        // Metals colour what they reflect.
        let is_metal = f0 > 0.5;
        let metal = get(&l.metal, i);
        let tint = Vec3::new(
            if is_metal { metal.x } else { 1.0 },
            if is_metal { metal.y } else { 1.0 },
            if is_metal { metal.z } else { 1.0 },
        );
        let matt = get(&l.out, i);
        put(&mut l.out, i, matt * (1.0 - fresnel) + shine * tint * fresnel);
    }
}

/// A pane with what is seen through it.
#[multiversion(targets("x86_64+avx2"))]
fn pane(l: &mut Lanes, m: usize, sky: &Sky) {
    for i in 0..m.min(LANES) {
        let (view, normal) = (get(&l.view, i), get(&l.normal, i));
        let cos_view = (-view.dot(normal)).clamp(0.0, 1.0);
        // Both faces of the pane reflect.
        let f0 = l.specular[i].max(0.045) * 1.8;
        let fresnel = (f0 + (1.0 - f0) * fifth(1.0 - cos_view)).min(1.0);
        let mirrored = view + normal * (2.0 * cos_view);
        let glint = highlight(sky, mirrored, 0.15) * l.lit[i];
        let tint = Vec3::new(0.93, 1.0, 0.95) * l.transmission[i];
        let open = [l.open[0][i], l.open[1][i], l.open[2][i], l.open[3][i]];
        let shine = environment(sky, mirrored, &open, 0.0) + glint;
        let behind = get(&l.behind, i);
        put(&mut l.out, i, behind * tint * (1.0 - fresnel) + shine * fresnel);
        // What is behind has come through the air already.
        l.distance_m[i] = 0.0;
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn through_air(l: &mut Lanes, m: usize, extinction_per_m: f32) {
    for i in 0..m.min(LANES) {
        let air = 1.0 - clear_share(extinction_per_m, l.distance_m[i]);
        let left = get(&l.out, i);
        put(&mut l.out, i, left + (get(&l.air, i) - left) * air);
    }
}

/// What a mirror shows: sky above the roofs and trees, a dark street below them, ground.
#[inline(always)]
fn environment(sky: &Sky, direction: Vec3, open: &[f32; 4], roughness: f32) -> Vec3 {
    let d2 = direction * direction;
    let level = (d2.x + d2.y).max(1e-6);
    let toward_x = if direction.x < 0.0 { open[1] } else { open[0] };
    let toward_y = if direction.y < 0.0 { open[3] } else { open[2] };
    let free = (toward_x * d2.x + toward_y * d2.y) / level;
    // Sine of the skyline's elevation there, uneven as roofs and crowns are.
    let uneven = pattern::value_noise(direction.x * 7.0 + 31.0, direction.y * 7.0 + 31.0, 0xE17);
    let skyline = (0.10 + 0.85 * (1.0 - free).max(0.0).sqrt()) * (0.65 + 0.7 * uneven);
    let soft = 0.02 + 0.35 * roughness;
    let above = ((direction.z - skyline) / soft + 0.5).clamp(0.0, 1.0);
    let over_ground = ((direction.z + 0.01) / soft + 0.5).clamp(0.0, 1.0);
    let street = sky.sky_on_level * 0.16 + sky.sun * 0.030;
    let up = Vec3::new(direction.x, direction.y, direction.z.max(0.0));
    let low = sky.ground * 0.8 + (street - sky.ground * 0.8) * over_ground;
    low + (sky.radiance(up) - low) * above
}

/// The sun's own reflection, a GGX lobe about the mirrored direction.
#[inline(always)]
fn highlight(sky: &Sky, mirrored: Vec3, roughness: f32) -> Vec3 {
    let alpha2 = (roughness * roughness * roughness * roughness).max(0.002);
    let miss = 1.0 - mirrored.dot(sky.sun_world);
    let lobe = 1.0 + miss / (2.0 * alpha2);
    sky.sun * (1.0 / (4.0 * alpha2 * lobe * lobe))
}

#[inline(always)]
fn fifth(x: f32) -> f32 {
    let x2 = x * x;
    x2 * x2 * x
}
