//! Many hits of one kind, one a lane: what is known of them, and what is found.

use multiversion::multiversion;

use super::face::{Face, Flags, Kind};
use super::hits::{Hits, LANES, Lane, RUN, STRIDE, set};
use super::shade::{Camera, Light, diffuse, geometry, gloss, pane, snow, texture, through_air};
use super::shadow::{Asked, Neighbours};
use crate::material::Pattern;
use crate::math::Vec3;

pub type Lane3 = [Lane; 3];

/// Hits of one kind, lane by lane; each kind fills what it needs.
pub struct Lanes {
    pub face_normal: Lane3,
    pub axis_u: Lane3,
    pub axis_v: Lane3,
    pub at_eye: [Lane; 2],
    pub normal_ab: Lane3,
    pub normal_ac: Lane3,
    pub to_b: Lane3,
    pub to_c: Lane3,
    pub weights_at_eye: [Lane; 2],
    pub least_weight: Lane,
    pub specular: Lane,
    pub roughness: Lane,
    pub transmission: Lane,
    pub face_hash: [u32; STRIDE],
    pub place_hash: [u32; STRIDE],
    pub flags: [u32; STRIDE],
    /// The sky's visibility towards the six half axes; flat faces know four of them.
    pub open: [Lane; 6],
    /// Light from all around, without what cars near by hide.
    pub around: Lane3,
    pub behind: Lane3,
    /// Unit vectors from the eye.
    pub view: Lane3,
    /// Relative to the eye.
    pub point: Lane3,
    pub distance_m: Lane,
    pub footprint_m: Lane,
    pub texture: [Lane; 2],
    /// At first of the first corner, then the unit shading normal.
    pub normal: Lane3,
    pub cos_sun: Lane,
    pub cos_face: Lane,
    pub is_asked: [bool; STRIDE],
    neighbours: Neighbours<STRIDE>,
    pub lit: Lane,
    pub near: Lane,
    /// At first of the material, then of the place.
    pub albedo: Lane3,
    /// Of the material.
    pub metal: Lane3,
    /// The radiance that arrives at the camera.
    pub out: Lane3,
}

#[inline(always)]
pub fn get<const N: usize>(lanes: &[[f32; N]; 3], i: usize) -> Vec3 {
    Vec3::new(lanes[0][i], lanes[1][i], lanes[2][i])
}

#[inline(always)]
pub fn put<const N: usize>(lanes: &mut [[f32; N]; 3], i: usize, v: Vec3) {
    (lanes[0][i], lanes[1][i], lanes[2][i]) = (v.x, v.y, v.z);
}

impl Default for Lanes {
    fn default() -> Self {
        const O: Lane = [0.0; STRIDE];
        const O3: Lane3 = [O; 3];
        Self {
            face_normal: O3,
            axis_u: O3,
            axis_v: O3,
            at_eye: [O; 2],
            normal_ab: O3,
            normal_ac: O3,
            to_b: O3,
            to_c: O3,
            weights_at_eye: [O; 2],
            least_weight: O,
            specular: O,
            roughness: O,
            transmission: O,
            face_hash: [0; STRIDE],
            place_hash: [0; STRIDE],
            flags: [0; STRIDE],
            open: [O; 6],
            around: O3,
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
            neighbours: Neighbours::default(),
            lit: O,
            near: O,
            albedo: O3,
            metal: O3,
            out: O3,
        }
    }
}

impl Lanes {
    /// Shades the first `n` hits of a kind; the outcome is in `out`.
    ///
    /// `rgb`: the picture, where panes find what is behind them.
    pub fn shade(
        &mut self,
        light: &Light,
        camera: &Camera,
        kind: Kind,
        hits: &Hits,
        n: usize,
        (faces, open): (&[Face], &[[f32; 8]]),
        rgb: &[f32],
    ) {
        let n = n.min(LANES);
        gather_faces(self, kind, hits, n, faces);
        gather_open(self, kind, hits, n, open);
        if kind.is_pane {
            for (i, pixel) in hits.behind[..n].iter().enumerate() {
                let at = *pixel as usize * 3;
                put(&mut self.behind, i, Vec3::new(rgb[at], rgb[at + 1], rgb[at + 2]));
            }
        }
        // Whole registers: what is left in the lanes beyond is nobody's.
        let m = n.next_multiple_of(16);
        geometry(self, hits, m, camera, light.sky.sun_world, kind);
        self.cast_shadows(light, camera.eye, kind, n);
        if kind.is_pane {
            pane(self, m, &light.sky);
        } else {
            if kind.is_glossy {
                self.metal = self.albedo;
            }
            texture(self, m, kind.pattern);
            if light.snow > 0.0 {
                snow(self, m, camera.eye, light.snow);
            }
            diffuse(self, m, &light.sky, kind, light.wetness);
            if kind.is_glossy {
                gloss(self, m, &light.sky, camera.eye, light.wetness);
            }
        }
        through_air(self, m, light);
    }

    /// Looks up what the sun's shadows and the cars near by leave.
    fn cast_shadows(&mut self, light: &Light, eye: Vec3, kind: Kind, n: usize) {
        match &light.shadows {
            Some(shadows) if ask_sun(self, kind, n) => {
                let asked = Asked {
                    points: &self.point,
                    normals: &self.face_normal,
                    cos_sun: &self.cos_face,
                    is_asked: &self.is_asked,
                    count: n,
                };
                shadows.sunlit(eye, &asked, &mut self.neighbours, &mut self.lit);
            }
            _ => self.lit.fill(0.0),
        }
        ask_contacts(self, n);
        light.sky_view.contacts.shade(eye, &self.point, &self.is_asked, n, &mut self.near);
    }
}

/// Asks for what the sun sees of the first `n` hits; true if there is any.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn ask_sun(l: &mut Lanes, kind: Kind, n: usize) -> bool {
    let is_leaf = kind.pattern == Pattern::Leaves;
    let mut any = [0_u8; LANES];
    for i in 0..LANES {
        let faces_sun = (l.cos_face[i] > 0.0) & ((l.cos_sun[i] > 0.0) | kind.is_pane);
        let is_asked = (i < n) & (is_leaf | faces_sun);
        l.is_asked[i] = is_asked;
        any[i] = u8::from(is_asked);
    }
    any.into_iter().fold(0, |all, one| all | one) != 0
}

/// Asks for what vehicles leave of the sky to the first `n` hits.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn ask_contacts(l: &mut Lanes, n: usize) {
    for i in 0..LANES {
        l.is_asked[i] = (i < n) & (l.flags[i] & Flags::CONTACT > 0);
    }
}

/// The lanes from `start` on; those that are nobody's yet are filled again when their turn comes.
#[inline(always)]
fn run<T: Copy>(lane: &mut [T; STRIDE], start: usize, value: T) {
    set(lane, start, [value; RUN]);
}

#[inline(always)]
fn run3(lanes: &mut Lane3, start: usize, value: Vec3) {
    let [x, y, z] = lanes;
    run(x, start, value.x);
    run(y, start, value.y);
    run(z, start, value.z);
}

/// How many numbers from `start` on, at most `RUN`, agree with the first of them.
#[inline(always)]
fn run_of(of: &[u32; STRIDE], start: usize) -> usize {
    let Some(run) = of[start..].first_chunk::<RUN>() else { return 1 };
    // Without branches: how long a run is cannot be foretold.
    let mut same = [0_u32; RUN];
    for k in 0..RUN {
        same[k] = u32::from(run[k] == run[0]) << k;
    }
    same.into_iter().fold(0, |all, bit| all | bit).trailing_ones() as usize
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn gather_faces(l: &mut Lanes, kind: Kind, hits: &Hits, n: usize, faces: &[Face]) {
    let (has_coat, is_leaf) = (kind.is_glossy || kind.is_pane, kind.pattern == Pattern::Leaves);
    let has_axes = kind.pattern != Pattern::Plain && !is_leaf;
    let mut i = 0;
    while i < n {
        let face = &faces[hits.face[i] as usize];
        run3(&mut l.face_normal, i, face.face_normal);
        run3(&mut l.albedo, i, face.albedo);
        run(&mut l.flags, i, face.flags);
        if !kind.is_flat() {
            run3(&mut l.normal, i, face.normal);
        }
        if kind.is_smooth {
            run3(&mut l.normal_ab, i, face.normal_ab);
            run3(&mut l.normal_ac, i, face.normal_ac);
            run3(&mut l.to_b, i, face.to_b);
            run3(&mut l.to_c, i, face.to_c);
            run(&mut l.weights_at_eye[0], i, face.weights_at_eye[0]);
            run(&mut l.weights_at_eye[1], i, face.weights_at_eye[1]);
            run(&mut l.least_weight, i, face.least_weight);
        }
        if has_axes {
            run3(&mut l.axis_u, i, face.axes[0]);
            run3(&mut l.axis_v, i, face.axes[1]);
        }
        if has_axes || is_leaf {
            run(&mut l.at_eye[0], i, face.at_eye[0]);
            run(&mut l.at_eye[1], i, face.at_eye[1]);
        }
        if is_leaf {
            run(&mut l.face_hash, i, face.face_hash);
            run(&mut l.place_hash, i, face.place_hash);
        }
        if has_coat {
            run(&mut l.specular, i, face.specular);
            run(&mut l.roughness, i, face.roughness);
            run(&mut l.transmission, i, face.transmission);
        }
        i += run_of(&hits.face, i);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn gather_open(l: &mut Lanes, kind: Kind, hits: &Hits, n: usize, open: &[[f32; 8]]) {
    let mut i = 0;
    while i < n {
        let [a, b, c, d, e, f, g, _] = open[hits.open[i] as usize];
        if kind.is_flat() {
            run3(&mut l.around, i, Vec3::new(a, b, c));
            if kind.is_glossy || kind.is_pane {
                for (lane, o) in l.open.iter_mut().zip([d, e, f, g]) {
                    run(lane, i, o);
                }
            }
        } else {
            for (lane, o) in l.open.iter_mut().zip([a, b, c, d, e, f]) {
                run(lane, i, o);
            }
        }
        i += run_of(&hits.open, i);
    }
}
