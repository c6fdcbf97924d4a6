//! What a rig captured: neutral facts, which exporters turn into a format's files.

use cadet_core::actor::{ActorState, BrakesFor};
use cadet_core::camera::png::encode_rgb8;
use cadet_core::camera::{SurfaceMapKinds, SurfaceMaps};
use cadet_core::label::{Rect, Sighting as CoreSighting};
use cadet_core::lidar::{ReturnSurface, Scan};
use cadet_core::math::DPose3;
use cadet_core::scene as core;
use cadet_core::town::GeoReference;
use numpy::{PyArray1, PyArray3};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays;
use crate::guard;

type Corners = (f64, f64, f64, f64);

/// Request for a capture.
#[pyclass(frozen, module = "cadet._cadet")]
pub(crate) struct Request {
    pub(crate) inner: core::CaptureRequest,
}

#[pymethods]
impl Request {
    #[new]
    #[pyo3(signature = (sample, *, maps, normals, scene_flow, optical_flow_s, radiance, pixels, sightings, cameras, lidars))]
    fn new(
        sample: u64,
        maps: bool,
        normals: bool,
        scene_flow: bool,
        optical_flow_s: Option<f64>,
        radiance: bool,
        pixels: bool,
        sightings: bool,
        cameras: Vec<usize>,
        lidars: Vec<usize>,
    ) -> Self {
        let inner = core::CaptureRequest {
            sample,
            maps: maps.then_some(SurfaceMapKinds { normals, scene_flow, optical_flow_s }),
            with_radiance: radiance,
            with_pixels: pixels,
            with_all_sightings: sightings,
            cameras,
            lidars,
        };
        Self { inner }
    }
}

/// Everything that was asked for at one instant.
#[pyclass(frozen, module = "cadet._cadet")]
pub(crate) struct Capture {
    frame: core::CapturedFrame,
    map: String,
    map_offset_m: [f64; 2],
    map_geo_reference: Option<GeoReference>,
    weather: String,
    sun_rad: (f64, f64),
    ego_from_velo: DPose3,
}

/// An actor around the ego.
#[pyclass(frozen, get_all, module = "cadet._cadet")]
pub(crate) struct Agent {
    id: i32,
    class_name: &'static str,
    model: String,
    size_lwh: [f64; 3],
    world_from_agent: [[f64; 4]; 4],
    velocity_world: [f64; 3],
    brakes_for: Option<(&'static str, Option<i32>)>,
    /// Of its outline in all images, and seen; `None` unless asked for.
    pixels: Option<[f64; 2]>,
}

impl Agent {
    pub(crate) fn of(actor: &ActorState, pixels: Option<[f64; 2]>) -> Self {
        Self {
            id: actor.id,
            class_name: actor.class.kitti_name(),
            model: actor.model.clone(),
            size_lwh: actor.size_lwh.to_array(),
            world_from_agent: arrays::pose_rows(&actor.world_from_box),
            velocity_world: actor.velocity_world.to_array(),
            brakes_for: actor.brakes_for.map(BrakesFor::name_and_id),
            pixels,
        }
    }
}

/// What a camera sees of an actor.
#[pyclass(frozen, get_all, module = "cadet._cadet")]
pub(crate) struct Sighting {
    actor_id: i32,
    class_name: &'static str,
    model: String,
    is_labeled: bool,
    truncation: f64,
    occlusion_level: u8,
    observation_angle: f64,
    bbox: Corners,
    visible_fraction: f64,
    visible_pixels: f64,
    contrast: f64,
    num_points: usize,
    velocity_world: [f64; 3],
    silhouette_bbox: Option<Corners>,
    corner_visible: Vec<bool>,
    size_lwh: [f64; 3],
    location_cam: [f64; 3],
    rotation_y: f64,
}

impl From<&CoreSighting> for Sighting {
    fn from(s: &CoreSighting) -> Self {
        Self {
            actor_id: s.actor_id,
            class_name: s.class.kitti_name(),
            model: s.model.clone(),
            is_labeled: s.is_labeled,
            truncation: s.truncation,
            occlusion_level: s.occlusion_level,
            observation_angle: s.observation_angle_rad,
            bbox: corners(&s.bbox),
            visible_fraction: s.visible_fraction,
            visible_pixels: s.visible_px,
            contrast: s.contrast,
            num_points: s.num_points,
            velocity_world: s.velocity_world.to_array(),
            silhouette_bbox: s.silhouette_bbox.as_ref().map(corners),
            corner_visible: s.corner_visible.to_vec(),
            size_lwh: s.box_cam.size_lwh.to_array(),
            location_cam: s.box_cam.location_cam.to_array(),
            rotation_y: s.box_cam.rotation_y,
        }
    }
}

fn corners(rect: &Rect) -> Corners {
    (rect.left_px, rect.top_px, rect.right_px, rect.bottom_px)
}

impl Capture {
    pub(crate) fn new(frame: core::CapturedFrame, scene: &core::Scene) -> Self {
        let weather = scene.weather();
        Self {
            frame,
            map: scene.town().name.clone(),
            map_offset_m: scene.town().network.offset_m.to_array(),
            map_geo_reference: scene.town().network.geo_reference.clone(),
            weather: weather.name.to_string(),
            sun_rad: (weather.sun_elevation_rad, weather.sun_azimuth_rad),
            ego_from_velo: scene.rig().lidars()[0].mount.ego_from_sensor(),
        }
    }

    fn image_at(&self, index: usize) -> PyResult<&core::Image> {
        self.frame.images.get(index).ok_or_else(|| PyIndexError::new_err(format!("no image {index}")))
    }
}

#[pymethods]
impl Capture {
    #[getter]
    fn time_s(&self) -> f64 {
        self.frame.time_s
    }

    /// Rows of a 4 x 4 matrix.
    #[getter]
    fn world_from_ego(&self) -> [[f64; 4]; 4] {
        arrays::pose_rows(&self.frame.world_from_ego)
    }

    #[getter]
    fn ego_from_velo(&self) -> [[f64; 4]; 4] {
        arrays::pose_rows(&self.ego_from_velo)
    }

    #[getter]
    fn ego_speed_mps(&self) -> f64 {
        self.frame.ego_velocity_world.length()
    }

    #[getter]
    fn ego_velocity_world(&self) -> [f64; 3] {
        self.frame.ego_velocity_world.to_array()
    }

    #[getter]
    fn ego_angular_velocity_world(&self) -> [f64; 3] {
        self.frame.ego_angular_velocity_world.to_array()
    }

    #[getter]
    fn map(&self) -> &str {
        &self.map
    }

    #[getter]
    fn map_offset_m(&self) -> [f64; 2] {
        self.map_offset_m
    }

    /// Projection, offset, and heading.
    #[getter]
    fn map_geo_reference(&self) -> Option<(String, [f64; 3], f64)> {
        let of = self.map_geo_reference.as_ref()?;
        Some((of.projection.clone(), of.offset_m, of.heading_rad))
    }

    #[getter]
    fn weather(&self) -> &str {
        &self.weather
    }

    /// Elevation and azimuth.
    #[getter]
    fn sun_rad(&self) -> (f64, f64) {
        self.sun_rad
    }

    #[getter]
    fn boxes(&self) -> &str {
        self.frame.boxes.as_ref()
    }

    #[getter]
    fn plane<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.frame.plane_cam)
    }

    #[getter]
    fn agents(&self) -> Vec<Agent> {
        self.frame.actors.iter().enumerate().map(|(i, a)| Agent::of(a, self.frame.pixels.get(i).copied())).collect()
    }

    /// What the camera of an image sees of actors; `None` unless asked for.
    fn sightings(&self, index: usize) -> PyResult<Option<Vec<Sighting>>> {
        let sightings = self.image_at(index)?.sightings.as_ref();
        Ok(sightings.map(|all| all.iter().map(Sighting::from).collect()))
    }

    /// Names of the images and of the scans.
    #[getter]
    fn names(&self) -> (Vec<String>, Vec<String>) {
        let images = self.frame.images.iter().map(|i| i.name.clone()).collect();
        (images, self.frame.scans.iter().map(|s| s.name.clone()).collect())
    }

    fn image<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let image = self.image_at(index)?;
        Ok(arrays::rgb(py, image.rendered.image.clone(), image.height, image.width))
    }

    /// The light of an image in shares of white; `None` unless asked for.
    fn radiance<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Option<Bound<'py, PyArray3<f32>>>> {
        let image = self.image_at(index)?;
        let pixels = image.rendered.radiance.as_ref().map(|rgb| rgb.as_chunks::<3>().0.to_vec());
        Ok(pixels.map(|pixels| arrays::vectors_of_pixels(py, pixels, image.height, image.width)))
    }

    /// The image as a PNG file.
    fn png<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyBytes>> {
        let image = self.image_at(index)?;
        let pixels = &image.rendered.image;
        let bytes = guard::detached(py, || encode_rgb8(image.width as u32, image.height as u32, pixels))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Depth, instances and classes of an image, and those maps of surfaces that were asked for; `None` unless asked for.
    fn maps<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Option<Bound<'py, PyDict>>> {
        let image = self.image_at(index)?;
        let Some(maps) = &image.rendered.maps else { return Ok(None) };
        let dict = PyDict::new(py);
        dict.set_item("depth", arrays::plane(py, maps.depth_m.clone(), image.height, image.width))?;
        dict.set_item("instance", arrays::plane(py, maps.instance.clone(), image.height, image.width))?;
        dict.set_item("semantic", arrays::plane(py, maps.semantic.clone(), image.height, image.width))?;
        let SurfaceMaps { normal_cam, velocity_cam_m_per_s, flow_px } = &maps.surfaces;
        for (name, vectors) in [("normals", normal_cam), ("scene_flow", velocity_cam_m_per_s)] {
            if !vectors.is_empty() {
                dict.set_item(name, arrays::vectors_of_pixels(py, vectors.clone(), image.height, image.width))?;
            }
        }
        if !flow_px.is_empty() {
            dict.set_item("optical_flow", arrays::vectors_of_pixels(py, flow_px.clone(), image.height, image.width))?;
        }
        Ok(Some(dict))
    }

    fn scan<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        let scan = &self.frame.scans.get(index).ok_or_else(|| PyIndexError::new_err(format!("no scan {index}")))?.scan;
        scan_to_dict(py, scan.clone())
    }
}

/// A scan by the fields of `cadet.Scan`.
pub(crate) fn scan_to_dict(py: Python<'_>, scan: Scan) -> PyResult<Bound<'_, PyDict>> {
    let semantic = scan.semantic.into_iter().map(|s| s as u8).collect();
    let time_s = scan.column.iter().map(|column| scan.firing_times_s[*column as usize] as f32).collect();
    let dict = PyDict::new(py);
    dict.set_item("points_velo", arrays::rows(py, scan.points_velo))?;
    dict.set_item("ring", PyArray1::from_vec(py, scan.ring))?;
    dict.set_item("column", PyArray1::from_vec(py, scan.column))?;
    dict.set_item("actor_id", PyArray1::from_vec(py, scan.actor_id))?;
    dict.set_item("semantic", PyArray1::<u8>::from_vec(py, semantic))?;
    dict.set_item("range_m", PyArray1::from_vec(py, scan.range_m))?;
    dict.set_item("time_s", PyArray1::<f32>::from_vec(py, time_s))?;
    dict.set_item("echo", PyArray1::from_vec(py, scan.echo))?;
    let surfaces = (!scan.surface.is_empty()).then(|| surfaces_to_dict(py, &scan.surface)).transpose()?;
    dict.set_item("surfaces", surfaces)?;
    Ok(dict)
}

/// What returned each point by the fields of `cadet.ScanSurfaces`.
fn surfaces_to_dict<'py>(py: Python<'py>, surfaces: &[ReturnSurface]) -> PyResult<Bound<'py, PyDict>> {
    let each = |of: fn(&ReturnSurface) -> f32| PyArray1::from_iter(py, surfaces.iter().map(of));
    let dict = PyDict::new(py);
    dict.set_item("cos_incidence", each(|s| s.cos_incidence))?;
    dict.set_item("reflectance", each(|s| s.reflectance))?;
    dict.set_item("normal_velo", arrays::rows(py, surfaces.iter().map(|s| s.normal_velo).collect()))?;
    let material = surfaces.iter().map(|s| s.pattern.map_or(-1, |pattern| pattern as i8));
    dict.set_item("material", PyArray1::from_iter(py, material))?;
    Ok(dict)
}
