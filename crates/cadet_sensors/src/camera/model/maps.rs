//! Maps of an image: what its pixels' centers show.

use super::distortion::Warp;

/// What the pixels' centers show; every array is row-major.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Maps {
    /// z along the optical axis, meters; infinite for the sky.
    pub depth_m: Vec<f32>,
    /// -1 sky, 0 static world, actors from 1; transparent surfaces carry their car's id.
    pub instance: Vec<i32>,
    /// [`Semantic`](cadet_base::material::Semantic) as a byte.
    pub semantic: Vec<u8>,
    /// What the surfaces do, if asked for.
    pub surfaces: SurfaceMaps,
}

impl Maps {
    /// The maps as a lens shows them; without a `warp` as they are.
    #[must_use]
    pub fn through(self, warp: Option<&Warp>) -> Self {
        let Some(warp) = warp else { return self };
        Self {
            depth_m: warp.nearest(&self.depth_m),
            instance: warp.nearest(&self.instance),
            semantic: warp.nearest(&self.semantic),
            surfaces: self.surfaces.through(warp),
        }
    }
}

/// What the surfaces at the pixels' centers do; every array is row-major, and empty unless asked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurfaceMaps {
    /// Unit normals of the triangles, towards the camera, in its axes; 0 for the sky.
    pub normal_cam: Vec<[f32; 3]>,
    /// Velocity over the ground in the camera's axes, m/s; 0 for the static world and for the sky.
    pub velocity_cam_m_per_s: Vec<[f32; 3]>,
    /// Columns and rows by which what a pixel shows moves in the image; NaN for the sky and for what comes behind the
    /// camera.
    pub flow_px: Vec<[f32; 2]>,
}

impl SurfaceMaps {
    /// The maps as a lens shows them.
    pub(crate) fn through(&self, warp: &Warp) -> Self {
        Self {
            normal_cam: warp.nearest(&self.normal_cam),
            velocity_cam_m_per_s: warp.nearest(&self.velocity_cam_m_per_s),
            flow_px: warp.nearest(&self.flow_px),
        }
    }
}
