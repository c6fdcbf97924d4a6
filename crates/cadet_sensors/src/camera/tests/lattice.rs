//! Blocks of 8 x 4 pixels are shaded together: nobody may see where they meet.

use super::{View, visibility_pass};
use crate::camera::render::{Scratch, radiance};
use crate::camera::sensor::{LUMA_WEIGHTS, MEAN_LUMA, MeteredPixel, blur, gain_for_mean_luma};
use crate::sense::PosedScene;
use crate::weather::Weather;
use cadet_base::math::{DMat3, DPose3, DQuat, DVec3};
use cadet_base::rng::StreamKey;
use cadet_town::{PropConfig, SuburbConfig, Town};

const SIZE: (usize, usize) = (1242, 375);
/// Pixels of a block.
const BLOCK: [usize; 2] = [8, 4];
/// Gradients count no more than so much, nor than twice the picture's mean: few edges would hide what all smooth surfaces
/// have, in fog a single pole's.
const MOST: f32 = 3.0;

/// Views along the streets of a suburb.
fn views(seed: u64, count: usize) -> Vec<(PosedScene, View)> {
    let town = Town::suburb(&StreamKey::scene(seed), &SuburbConfig::default(), &PropConfig::default()).unwrap();
    let lanes: Vec<_> = town.network.driving().filter(|l| l.length_m() > 40.0).collect();
    let along = lanes.iter().step_by(lanes.len() / count).take(count);
    along
        .map(|lane| {
            let pose = lane.pose_at(lane.length_m() / 3.0);
            let eye = pose.translation + DVec3::Z * 1.65;
            let cam = DQuat::from_mat3(&DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X));
            let world_from_cam = DPose3 { rotation: pose.rotation * cam, translation: eye };
            let view =
                View { intrinsics_px: [721.5, 721.5, 609.6, 172.9], width: SIZE.0, height: SIZE.1, world_from_cam };
            (PosedScene::new(&town.scenery, eye), view)
        })
        .collect()
}

/// Luma before the sensor's noise, exposed as a picture is.
fn luma(scene: &PosedScene, view: &View, weather: &Weather) -> Vec<f32> {
    let seen = visibility_pass(scene, view).unwrap();
    let mut scratch = Scratch::default();
    let _ = radiance(scene, view, weather, &seen, &mut scratch);
    let _ = blur(&mut scratch.rgb, SIZE.0, SIZE.1, f32::INFINITY);
    let rgb = scratch.rgb.as_chunks::<3>().0.get(..SIZE.0 * SIZE.1).expect("an image");
    let metered: Vec<MeteredPixel> = rgb.iter().map(|p| (*p, 1.0)).collect();
    let gain = gain_for_mean_luma(&metered, MEAN_LUMA[0]);
    rgb.iter().map(|p| (0..3).map(|k| (p[k] * gain).min(255.0) * LUMA_WEIGHTS[k]).sum()).collect()
}

/// Sums and numbers of the gradients across and down, by their place in a block.
#[derive(Default)]
struct Phases {
    sums: [[f64; 8]; 2],
    counts: [[f64; 8]; 2],
}

impl Phases {
    fn add(&mut self, luma: &[f32]) {
        let across = luma.windows(2).map(|pair| (pair[1] - pair[0]).abs().min(MOST));
        let most = (2.0 * across.sum::<f32>() / luma.len() as f32).min(MOST);
        for row in 1..SIZE.1 {
            for column in 1..SIZE.0 {
                let at = row * SIZE.0 + column;
                for (k, (before, place)) in [(at - 1, column), (at - SIZE.0, row)].into_iter().enumerate() {
                    self.sums[k][place % BLOCK[k]] += f64::from((luma[at] - luma[before]).abs().min(most));
                    self.counts[k][place % BLOCK[k]] += 1.0;
                }
            }
        }
    }

    /// How far the mean gradients at each place of a block exceed the mean of all, across and down: the borders' first.
    fn excess(&self) -> [Vec<f64>; 2] {
        [0, 1].map(|k| {
            let mean = self.sums[k].iter().sum::<f64>() / self.counts[k].iter().sum::<f64>();
            (0..BLOCK[k]).map(|place| self.sums[k][place] / self.counts[k][place] / mean - 1.0).collect()
        })
    }
}

#[test]
fn gradients_at_the_borders_of_blocks_are_those_of_elsewhere_in_every_weather() {
    let views: Vec<_> = (0..2).flat_map(|seed| views(seed, 3)).collect();
    for name in Weather::NAMES {
        let mut phases = Phases::default();
        for (scene, view) in &views {
            phases.add(&luma(scene, view, &Weather::preset(name).unwrap()));
        }
        let [across, down] = phases.excess();
        // KITTI's 45 frames: 0.004 at most.
        // Edges of few things favor some places of a block and those beside them; borders of blocks favor theirs alone.
        let [at_borders, beside] = [0, 1].map(|k| [&across, &down].map(|e| (e[k] + e[(e.len() - k) % e.len()]) / 2.0));
        let alone = [0, 1].map(|k| (at_borders[k] - beside[k]).abs());
        assert!(alone[0] < 0.01 && alone[1] < 0.01, "{name}: {across:.4?} across, {down:.4?} down");
    }
}
