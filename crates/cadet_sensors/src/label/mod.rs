//! What a camera sees of actors and what of it gets a label: boxes, truncation, both occlusion methods, by the definitions of `docs/labels.md`.

mod box_cam;
mod config;
mod corners;
mod labeler;
mod motion;
mod road_plane;
mod sighting;
mod silhouette;

pub use box_cam::{BoxCam, Boxes, Rect};
pub use config::{LabelConfig, OcclusionMethod};
pub use labeler::{add_points, may_label, sightings};
pub use motion::TakenView;
pub use road_plane::road_plane_cam;
pub use sighting::Sighting;
pub use silhouette::{PinholeLook, pixels_of_actors};
