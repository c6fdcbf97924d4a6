//! Retroreflectors that bloom: a beam that passes beside one still meets it with its halo, the light that the sensor's optics
//! scatter about it.
//!
//! The halo is an even disc. What it meets is judged by the sensor's own beams: of those inside it, as many as meet
//! retroreflectors send their share of it back, at their mean range.

use super::echo::{Echo, RETROREFLECTION_FACTOR};
use crate::lidar::casting::{Casting, TurnHits};
use crate::lidar::sensor::LidarSpec;
use crate::sense::Hits;
use cadet_base::math::wrap_angle;

/// What the halos of a turn's beams meet.
pub(crate) struct Blooming {
    /// Of each beam.
    halos: Vec<Halo>,
}

/// What a beam's halo meets of retroreflectors.
#[derive(Debug, Clone, Copy, Default)]
struct Halo {
    /// Sum over the beams inside it of reflectance, and of reflectance x range.
    reflectance: f64,
    reflectance_m: f64,
    /// Which beam met the nearest one inside it.
    nearest: Option<u32>,
}

/// A ring's beams inside of a halo: rings, and how many columns to either side.
struct Window {
    ring: usize,
    columns: usize,
}

impl Blooming {
    /// None where nothing blooms.
    pub(crate) fn of<C: Casting>(casting: &C, spec: &LidarSpec, met: &TurnHits) -> Option<Self> {
        let (scene, receiver) = (casting.scene(), spec.receiver());
        let hits = &met.opaque;
        if receiver.halo_share == 0.0 || !spec.spins() {
            return None;
        }
        let is_retro = |at: &usize| {
            let instance = scene.instances.get(hits.instance[*at] as usize);
            instance.is_some_and(|posed| posed.material(hits.face[*at]).lidar.retro)
        };
        let retro: Vec<usize> = (0..hits.depth_m.len()).filter(is_retro).collect();
        if retro.is_empty() {
            return None;
        }
        let azimuths_rad = spec.azimuths_rad();
        let windows: Vec<(Vec<Window>, f64)> = (0..hits.rows).map(|ring| windows(spec, ring)).collect();
        let mut halos = vec![Halo::default(); hits.depth_m.len()];
        for at in retro {
            let (ring, column) = (at / hits.columns, at % hits.columns);
            let material = scene.instances[hits.instance[at] as usize].material(hits.face[at]);
            let reflectance = f64::from(material.lidar.reflectance) * RETROREFLECTION_FACTOR;
            for Window { ring: other, columns } in &windows[ring].0 {
                for k in 0..=2 * columns {
                    let beside = (column + hits.columns + k - columns) % hits.columns;
                    // A sensor that sees a part of the turn has no neighbors beyond its ends.
                    if wrap_angle(azimuths_rad[beside] - azimuths_rad[column]).abs() <= receiver.halo_rad {
                        halos[other * hits.columns + beside].add(at, reflectance, hits);
                    }
                }
            }
        }
        for (at, halo) in halos.iter_mut().enumerate() {
            let share = receiver.halo_share / windows[at / hits.columns].1;
            halo.reflectance *= share;
            halo.reflectance_m *= share;
        }
        Some(Self { halos })
    }

    /// Adds to the echoes of a beam's surfaces, by rising range, what its halo brings back.
    pub(crate) fn join<C: Casting>(&self, echoes: &mut [Option<Echo>; 4], casting: &C, hits: &Hits, beam: usize) {
        let halo = &self.halos[beam];
        let Some(nearest) = halo.nearest.map(|at| at as usize) else { return };
        // A retroreflector that it meets itself outshines it.
        if echoes.iter().flatten().any(|echo| echo.retro) || echoes[3].is_some() {
            return;
        }
        let posed = &casting.scene().instances[hits.instance[nearest] as usize];
        let material = posed.material(hits.face[nearest]);
        let range_m = halo.reflectance_m / halo.reflectance;
        let echo = Echo {
            range_m,
            reflectance: halo.reflectance,
            cos_incidence: 1.0,
            normal_velo: [f32::NAN; 3],
            pattern: material.pattern,
            retro: false,
            actor_id: posed.actor_id,
            semantic: material.semantic,
        };
        let place = echoes.iter().flatten().filter(|e| e.range_m <= range_m).count();
        echoes[place..].rotate_right(1);
        echoes[place] = Some(echo);
    }
}

impl Halo {
    fn add(&mut self, at: usize, reflectance: f64, hits: &Hits) {
        let range_m = f64::from(hits.depth_m[at]);
        self.reflectance += reflectance;
        self.reflectance_m += reflectance * range_m;
        if self.nearest.is_none_or(|other| hits.depth_m[at] < hits.depth_m[other as usize]) {
            self.nearest = Some(at as u32);
        }
    }
}

/// The beams inside the halo of a ring's beams, and how many they are.
fn windows(spec: &LidarSpec, ring: usize) -> (Vec<Window>, f64) {
    let (halo_rad, step_rad) = (spec.receiver().halo_rad, spec.beam_step_rad());
    let within = |other: usize| {
        let up_rad = spec.rings()[other].elevation_rad - spec.rings()[ring].elevation_rad;
        let across_rad = (halo_rad * halo_rad - up_rad * up_rad).max(0.0).sqrt();
        (up_rad.abs() <= halo_rad).then(|| Window {
            ring: other,
            columns: ((across_rad / step_rad) as usize).min((spec.num_columns() - 1) / 2),
        })
    };
    let windows: Vec<Window> = (0..spec.rings().len()).filter_map(within).collect();
    let num_beams = windows.iter().map(|w| 2 * w.columns + 1).sum::<usize>();
    (windows, num_beams as f64)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use crate::lidar::{LidarSpec, Receiver, ReturnMode, Scan, scan};
    use crate::sense::PosedScene;
    use crate::weather::Weather;
    use cadet_base::geometry::{LodSet, MeshBuilder};
    use cadet_base::instance::Instance;
    use cadet_base::material::{LidarMaterial, Material, Palette, Pattern, Semantic};
    use cadet_base::math::{DPose3, DVec3, Vec3};
    use cadet_base::rng::Stream;

    /// A board that faces the sensor across x.
    fn board(id: i32, ahead_m: f32, half_m: f32, retro: bool) -> Instance {
        let mut b = MeshBuilder::new();
        b.cuboid(Vec3::new(ahead_m, -half_m, -half_m), Vec3::new(ahead_m + 0.1, half_m, half_m), 0);
        let lidar = LidarMaterial { retro, ..LidarMaterial::diffuse(0.5) };
        let material = Material { lidar, ..Material::matt(Semantic::TrafficSign, [0.5; 3], Pattern::Plain, 0.5) };
        let shape = Arc::new(LodSet::single(b.build("board", 0.5)));
        Instance::new(shape, Arc::new(Palette::new(vec![material])), DPose3::IDENTITY, id)
    }

    fn scan_of(boards: &[Instance], halo_share: f64, returns: ReturnMode) -> Scan {
        let mut spec = LidarSpec::hdl64e_uniform();
        let receiver = Receiver { range_noise_m: 0.0, halo_share, halo_rad: 10e-3, ..*spec.receiver() };
        spec = spec.with_receiver(receiver).expect("valid");
        spec.returns = returns;
        let scene = PosedScene::new(boards, DVec3::ZERO);
        let weather = Weather::preset("clear_noon").expect("exists");
        scan(&scene, &DPose3::IDENTITY, &spec, &weather, &mut Stream::from_seed("halo", 0)).expect("valid")
    }

    /// How far points at a board's range lie beyond its edge, at most.
    fn beyond_m(scan: &Scan, half_m: f32) -> f32 {
        let off = |p: &[f32; 4]| (p[1].abs() - half_m).max(p[2].abs() - half_m);
        scan.points_velo.iter().filter(|p| (p[0] - 20.0).abs() < 0.02).map(off).fold(f32::MIN, f32::max)
    }

    #[test]
    fn a_sign_blooms_as_far_as_the_halo_reaches_and_only_where_it_has_a_share() {
        let sign = [board(1, 20.0, 0.4, true)];
        let all = scan_of(&sign, 1e-2, ReturnMode::Strongest);
        // 10 mrad are three columns of 3 mrad, of 0.06 m each; of the halo a tenth of a percent is enough.
        assert!((0.12..0.181).contains(&beyond_m(&all, 0.4)), "{}", beyond_m(&all, 0.4));
        assert!(all.actor_id.iter().all(|id| *id == 1));
        // A column less where a share of 0.13 is needed: 0.5 x 1000 x 1e-4 x 0.13 / 20^2 is the threshold.
        let some = beyond_m(&scan_of(&sign, 1e-4, ReturnMode::Strongest), 0.4);
        assert!((0.05..0.13).contains(&some), "{some}");
        for (boards, share) in [(&sign, 0.0), (&[board(1, 20.0, 0.4, false)], 1e-2)] {
            assert!(beyond_m(&scan_of(boards, share, ReturnMode::Strongest), 0.4) <= 0.001);
        }
    }

    #[test]
    fn what_stands_behind_outshines_a_halo_and_both_are_told_apart() {
        let boards = [board(1, 20.0, 0.4, true), board(2, 30.0, 8.0, false)];
        let strongest = scan_of(&boards, 1e-4, ReturnMode::Strongest);
        assert!(beyond_m(&strongest, 0.4) < 0.06, "{}", beyond_m(&strongest, 0.4));
        let both = scan_of(&boards, 1e-4, ReturnMode::Triple);
        assert!(beyond_m(&both, 0.4) > 0.05, "{}", beyond_m(&both, 0.4));
        assert!(both.points_velo.len() > strongest.points_velo.len() + 20);
        assert!(both.echo.contains(&2));
    }
}
