//! Whether a view shows something that the view before did not: the ego or a labeled object has moved.

use super::box_cam::Rect;
use super::sighting::Sighting;
use cadet_base::math::DPose3;

/// A view that was taken: where the ego was, and the rectangles of what was labeled.
#[derive(Debug, Clone)]
pub struct TakenView {
    world_from_ego: DPose3,
    objects: Vec<(i32, Rect)>,
}

impl TakenView {
    /// The ego has moved if it is at least this far from where it was.
    pub const EGO_MOVED_M: f64 = 0.5;
    /// An object has moved visibly if a side of its rectangle has, by this fraction of the image's width: 8 px of KITTI's.
    pub const OBJECT_MOVED_SHARE: f64 = 8.0 / 1242.0;

    /// Remembers a view.
    #[must_use]
    pub fn new(world_from_ego: DPose3, sightings: &[Sighting]) -> Self {
        let objects = sightings.iter().filter(|s| s.is_labeled).map(|s| (s.actor_id, s.bbox)).collect();
        Self { world_from_ego, objects }
    }

    /// Whether the ego has moved since.
    #[must_use]
    pub fn ego_has_moved(&self, world_from_ego: &DPose3) -> bool {
        (world_from_ego.translation - self.world_from_ego.translation).length() >= Self::EGO_MOVED_M
    }

    /// Whether a labeled object has come into view since, or moved visibly.
    #[must_use]
    pub fn object_has_moved(&self, sightings: &[Sighting], image_width: usize) -> bool {
        let least_px = Self::OBJECT_MOVED_SHARE * image_width as f64;
        sightings.iter().filter(|s| s.is_labeled).any(|s| {
            let before = self.objects.iter().find(|(id, _)| *id == s.actor_id);
            before.is_none_or(|(_, before)| {
                let (a, b) = (before, &s.bbox);
                let sides =
                    [a.left_px - b.left_px, a.top_px - b.top_px, a.right_px - b.right_px, a.bottom_px - b.bottom_px];
                sides.iter().any(|d| d.abs() >= least_px)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::box_cam::BoxCam;
    use super::*;
    use cadet_base::actor::ObjectClass;
    use cadet_base::math::{DQuat, DVec3};

    const WIDTH: usize = 1242;

    fn sighting(actor_id: i32, is_labeled: bool, u1: f64) -> Sighting {
        let box_cam =
            BoxCam { size_lwh: DVec3::new(4.0, 1.6, 1.5), location_cam: DVec3::new(0.0, 1.6, 18.0), rotation_y: 0.0 };
        Sighting {
            actor_id,
            class: ObjectClass::Car,
            model: String::new(),
            is_labeled,
            truncation: 0.0,
            occlusion_level: 0,
            observation_angle_rad: 0.0,
            bbox: Rect { left_px: u1, top_px: 150.0, right_px: u1 + 80.0, bottom_px: 210.0 },
            visible_fraction: 1.0,
            visible_px: 4800.0,
            contrast: 1.0,
            least_points: 0,
            num_points: 0,
            velocity_world: DVec3::ZERO,
            silhouette_bbox: None,
            corner_visible: [true; 8],
            box_cam,
        }
    }

    fn ego_at(x: f64) -> DPose3 {
        DPose3 { rotation: DQuat::IDENTITY, translation: DVec3::new(x, 0.0, 0.0) }
    }

    #[test]
    fn the_ego_moves_by_half_a_meter_or_not_at_all() {
        let taken = TakenView::new(ego_at(3.0), &[]);
        assert!(!taken.ego_has_moved(&ego_at(3.0)) && !taken.ego_has_moved(&ego_at(3.4)));
        assert!(taken.ego_has_moved(&ego_at(3.6)) && taken.ego_has_moved(&ego_at(2.4)));
    }

    #[test]
    fn objects_move_by_pixels_of_the_image_or_come_into_view() {
        let car = |u| sighting(1, true, u);
        let taken = TakenView::new(ego_at(0.0), &[car(500.0)]);
        assert!(!taken.object_has_moved(&[car(500.0)], WIDTH));
        assert!(!taken.object_has_moved(&[car(507.0)], WIDTH) && taken.object_has_moved(&[car(509.0)], WIDTH));
        assert!(taken.object_has_moved(&[car(495.0)], WIDTH / 2), "pixels scale with the image");
        assert!(taken.object_has_moved(&[car(500.0), sighting(2, true, 40.0)], WIDTH));
        // Who left is no reason to look again, and nobody looks at what has no label.
        assert!(!taken.object_has_moved(&[], WIDTH));
        assert!(!taken.object_has_moved(&[car(500.0), sighting(2, false, 40.0)], WIDTH));
    }

    #[test]
    fn small_motions_add_up_against_the_view_that_was_taken() {
        let taken = TakenView::new(ego_at(0.0), &[sighting(1, true, 500.0)]);
        let moved: Vec<bool> =
            [503.0, 506.0, 509.0].iter().map(|u| taken.object_has_moved(&[sighting(1, true, *u)], WIDTH)).collect();
        assert_eq!(moved, [false, false, true]);
    }
}
