//! The numbers of the labels' definitions.

use super::box_cam::Boxes;
use super::sighting::{Placed, Sighting};
use cadet_base::actor::ActorState;
use cadet_base::error::{Error, Result};
use cadet_base::settings;

/// How occlusion is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OcclusionMethod {
    /// Visible over silhouette pixels (default).
    Pixels,
    /// The 2019 paper's: corners of the box against the depth map.
    Corners,
}

settings! {
    /// The labels' definitions.
    LabelConfig;
    others {
        /// How occlusion is measured.
        method: OcclusionMethod = OcclusionMethod::Pixels;
        /// Which boxes labels hold.
        boxes: Boxes = Boxes::Kitti;
    }
    numbers {
        /// A label's box is at least this high, pixels.
        min_height_px: f64 = 15.0, 0 to f64::INFINITY;
        /// A label's object shows at least this fraction of its silhouette.
        min_visible_fraction: f64 = 0.1, 0 to 1;
        /// A label's object is at most this deep, meters.
        max_depth_m: f64 = 80.0, 0 to f64::INFINITY;
        /// A label's object is at least this deep, meters.
        min_depth_m: f64 = 0.5, 0 to f64::INFINITY;
        /// A label's object is truncated by at most this.
        max_truncation: f64 = 0.95, 0 to 1;
        /// An object without returns keeps at least this much of its contrast through the air to get a label.
        min_contrast: f64 = 0.05, 0 to 1;
        /// A label's object has at least this many returns.
        min_points: usize = 0, 0 to 1e6;
        /// An object without a label is kept as unlabeled if it shows at least this many pixels.
        dontcare_min_pixels: f64 = 8.0, 0 to f64::INFINITY;
        /// Visible fractions from which the occlusion level is 0 and 1; below, it is 2.
        occlusion_levels: [f64; 2] = [0.8, 0.5], 0 to 1;
        /// A corner is hidden by what is nearer than it by more than this, meters.
        corner_tolerance_m: f64 = 0.1, 0 to f64::INFINITY;
        /// With this many hidden corners the object is occluded.
        max_hidden_corners: usize = 4, 1 to 8;
    }
}

impl LabelConfig {
    /// Refuses numbers that mean nothing.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], naming the field.
    pub fn validated(self) -> Result<Self> {
        self.check_settings()?;
        let [level0, level1] = self.occlusion_levels;
        if level0 < level1 {
            let expected = "at least level 1's threshold".to_owned();
            return Err(Error::OutOfRange { what: "occlusion level 0", value: level0.to_string(), expected });
        }
        Ok(self)
    }

    /// Whether an object may get a label by what its box and its projection tell.
    pub(super) fn admits(&self, placed: &Placed, actor: &ActorState) -> bool {
        let reach_m = self.max_depth_m.min(self.boxes.of(actor).farthest_m);
        let depth_m = placed.box_cam.location_cam.z;
        (self.min_depth_m..=reach_m).contains(&depth_m)
            && placed.bbox.bottom_px - placed.bbox.top_px >= self.min_height_px
            && placed.truncation <= self.max_truncation
    }

    /// The visible fraction that a label takes at a depth. KITTI's annotators left out what is mostly hidden the more
    /// the farther it is: of its cars at 15 to 30 m 31 % show less than half of themselves, at 30 to 40 m 29 %, at 40 to
    /// 50 m 18 %, beyond 13 %.
    pub(super) fn least_visible_fraction(&self, depth_m: f64) -> f64 {
        const FROM_M: f64 = 25.0;
        const MORE_PER_M: f64 = 0.014;
        const MOST: f64 = 0.38;
        match self.boxes {
            Boxes::Kitti => {
                let farther = MORE_PER_M * (depth_m - FROM_M).max(0.0);
                self.min_visible_fraction.max((self.min_visible_fraction + farther).min(MOST))
            }
            Boxes::Exact => self.min_visible_fraction,
        }
    }

    /// Whether the sensors support a label: returns, or else enough contrast.
    pub(super) fn is_supported(&self, seen: &Sighting) -> bool {
        let least = match self.boxes {
            Boxes::Kitti => self.min_points.max(seen.least_points),
            Boxes::Exact => self.min_points,
        };
        seen.num_points >= least && (seen.num_points > 0 || seen.contrast >= self.min_contrast)
    }
}

#[cfg(test)]
mod tests {
    use super::super::box_cam::{BoxCam, Rect};
    use super::*;
    use cadet_base::actor::{AnnotatedBox, ObjectClass};
    use cadet_base::math::{DPose3, DVec3};

    fn actor(farthest_m: f64) -> ActorState {
        let size_lwh = DVec3::new(4.0, 1.6, 1.5);
        ActorState {
            id: 1,
            class: ObjectClass::Car,
            model: "test".to_owned(),
            size_lwh,
            annotated: AnnotatedBox { farthest_m, ..AnnotatedBox::exact(size_lwh) },
            world_from_box: DPose3::IDENTITY,
            velocity_world: DVec3::ZERO,
            angular_velocity_world: DVec3::ZERO,
            brakes_for: None,
        }
    }

    fn box_at(depth_m: f64) -> BoxCam {
        let location_cam = DVec3::new(0.0, 1.65, depth_m);
        BoxCam { size_lwh: DVec3::new(4.0, 1.6, 1.5), location_cam, rotation_y: 0.0 }
    }

    fn placed(depth_m: f64, height_px: f64, truncation: f64) -> Placed {
        let bbox = Rect { left_px: 500.0, top_px: 150.0, right_px: 600.0, bottom_px: 150.0 + height_px };
        Placed { box_cam: box_at(depth_m), bbox, truncation }
    }

    fn sighting(num_points: usize, least_points: usize, contrast: f64) -> Sighting {
        Sighting {
            actor_id: 1,
            class: ObjectClass::Car,
            model: String::new(),
            is_labeled: true,
            truncation: 0.0,
            occlusion_level: 0,
            observation_angle_rad: 0.0,
            bbox: Rect { left_px: 500.0, top_px: 150.0, right_px: 600.0, bottom_px: 190.0 },
            visible_fraction: contrast,
            visible_px: 1000.0,
            contrast,
            num_points,
            least_points,
            velocity_world: DVec3::ZERO,
            silhouette_bbox: None,
            corner_visible: [true; 8],
            box_cam: box_at(20.0),
        }
    }

    fn with(boxes: Boxes) -> LabelConfig {
        LabelConfig { boxes, ..LabelConfig::default() }
    }

    #[test]
    fn depth_height_and_truncation_have_limits_that_belong_to_them() {
        let config = with(Boxes::Exact);
        let admits =
            |depth_m, height_px, truncated| config.admits(&placed(depth_m, height_px, truncated), &actor(60.0));
        assert!(admits(20.0, 40.0, 0.0));
        for (inside, outside) in [
            ((0.5, 40.0, 0.0), (0.49, 40.0, 0.0)),
            ((80.0, 40.0, 0.0), (80.01, 40.0, 0.0)),
            ((20.0, 15.0, 0.0), (20.0, 14.99, 0.0)),
            ((20.0, 40.0, 0.95), (20.0, 40.0, 0.951)),
        ] {
            assert!(admits(inside.0, inside.1, inside.2), "{inside:?}");
            assert!(!admits(outside.0, outside.1, outside.2), "{outside:?}");
        }
    }

    #[test]
    fn annotated_boxes_end_where_their_annotator_stopped() {
        for (farthest_m, depth_m, expected) in [(50.0, 49.9, true), (50.0, 50.1, false), (95.0, 80.1, false)] {
            assert_eq!(with(Boxes::Kitti).admits(&placed(depth_m, 40.0, 0.0), &actor(farthest_m)), expected);
        }
        assert!(with(Boxes::Exact).admits(&placed(70.0, 40.0, 0.0), &actor(50.0)));
    }

    #[test]
    fn the_least_visible_fraction_rises_with_depth_to_its_most_and_never_below_what_was_asked() {
        let kitti = with(Boxes::Kitti);
        for (depth_m, expected) in [(5.0, 0.1), (25.0, 0.1), (35.0, 0.24), (44.0, 0.366), (45.0, 0.38), (79.0, 0.38)] {
            assert!((kitti.least_visible_fraction(depth_m) - expected).abs() < 1e-12, "{depth_m}");
            assert_eq!(with(Boxes::Exact).least_visible_fraction(depth_m), 0.1);
        }
        let strict = LabelConfig { min_visible_fraction: 0.6, ..kitti };
        assert_eq!(strict.least_visible_fraction(60.0), 0.6);
    }

    #[test]
    fn a_label_needs_its_returns_or_else_contrast() {
        let (kitti, exact) = (with(Boxes::Kitti), with(Boxes::Exact));
        for (num_points, least_points, contrast, of_kitti, of_exact) in [
            (0, 0, 0.051, true, true),
            (0, 0, 0.049, false, false),
            (1, 0, 0.0, true, true),
            (3, 4, 1.0, false, true),
            (4, 4, 0.01, true, true),
        ] {
            let seen = sighting(num_points, least_points, contrast);
            assert_eq!((kitti.is_supported(&seen), exact.is_supported(&seen)), (of_kitti, of_exact), "{seen:?}");
        }
        let five = LabelConfig { min_points: 5, ..exact };
        assert!(five.is_supported(&sighting(5, 0, 1.0)) && !five.is_supported(&sighting(4, 0, 1.0)));
    }

    #[test]
    fn numbers_that_mean_nothing_are_refused_by_name() {
        let fine = LabelConfig::default;
        for (config, what) in [
            (LabelConfig { min_depth_m: -1.0, ..fine() }, "min_depth_m"),
            (LabelConfig { max_truncation: 1.1, ..fine() }, "max_truncation"),
            (LabelConfig { min_contrast: f64::NAN, ..fine() }, "min_contrast"),
            (LabelConfig { occlusion_levels: [0.4, 0.5], ..fine() }, "occlusion level 0"),
        ] {
            assert!(config.validated().expect_err("refused").to_string().contains(what), "{what}");
        }
        assert!(fine().validated().is_ok());
    }
}
