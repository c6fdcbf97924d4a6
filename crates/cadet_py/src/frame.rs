//! A captured frame as a dictionary, by the fields of `cadet.Frame`.

use cadet_core::label::{Labeled, Rect};
use cadet_core::math::DVec3;
use cadet_core::scene::Frame;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::arrays;

/// Image, scan, labels, plane and what is known beyond KITTI's files.
pub(crate) fn to_dict<'py>(py: Python<'py>, frame: Frame, width: usize, height: usize) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let labels = frame.labels.iter().map(|l| label(py, l)).collect::<PyResult<Vec<_>>>()?;
    let objects = frame.labels.iter().map(|l| object(py, l)).collect::<PyResult<Vec<_>>>()?;
    let meta = PyDict::new(py);
    meta.set_item("time_s", frame.time_s)?;
    meta.set_item("ego_speed_mps", frame.ego_speed_mps)?;
    let pose: Vec<Vec<f64>> = arrays::pose_rows(&frame.world_from_ego).iter().map(|r| r.to_vec()).collect();
    meta.set_item("world_from_ego", pose)?;
    meta.set_item("boxes", frame.boxes.name())?;
    meta.set_item("objects", PyList::new(py, objects)?)?;
    dict.set_item("image", arrays::rgb(py, frame.rendered.image, height, width))?;
    if let Some(maps) = frame.rendered.maps {
        dict.set_item("depth", arrays::plane(py, maps.depth, height, width))?;
        dict.set_item("instance", arrays::plane(py, maps.instance, height, width))?;
        dict.set_item("semantic", arrays::plane(py, maps.semantic, height, width))?;
    }
    dict.set_item("points_velo", arrays::rows(py, frame.scan.points_velo))?;
    dict.set_item("labels", PyList::new(py, labels)?)?;
    dict.set_item("plane", PyArray1::from_slice(py, &frame.plane))?;
    dict.set_item("meta", meta)?;
    Ok(dict)
}

fn label<'py>(py: Python<'py>, labeled: &Labeled) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let line = &labeled.label;
    dict.set_item("type", line.class.kitti_name())?;
    dict.set_item("truncated", line.truncated)?;
    dict.set_item("occluded", line.occluded)?;
    dict.set_item("alpha", line.alpha)?;
    dict.set_item("bbox", corners(&line.bbox))?;
    let (hwl, location, rotation_y) = match &line.box_cam {
        Some(b) => ((b.size_lwh.z, b.size_lwh.y, b.size_lwh.x), b.location_cam.into(), b.rotation_y),
        None => ((-1.0, -1.0, -1.0), (-1000.0, -1000.0, -1000.0), -10.0),
    };
    dict.set_item("dimensions_hwl", hwl)?;
    dict.set_item("location_cam", location)?;
    dict.set_item("rotation_y", rotation_y)?;
    Ok(dict)
}

fn object<'py>(py: Python<'py>, labeled: &Labeled) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let meta = &labeled.meta;
    dict.set_item("actor_id", meta.actor_id)?;
    dict.set_item("type", meta.class.kitti_name())?;
    dict.set_item("model", &meta.model)?;
    dict.set_item("visible_fraction", rounded(meta.visible_fraction))?;
    dict.set_item("visible_pixels", meta.visible_pixels)?;
    dict.set_item("contrast", rounded(meta.contrast))?;
    dict.set_item("num_points", meta.num_points)?;
    dict.set_item("velocity_world", vector(meta.velocity_world))?;
    dict.set_item("silhouette_bbox", meta.silhouette_bbox.as_ref().map(corners))?;
    dict.set_item("corner_visible", meta.corner_visible.to_vec())?;
    dict.set_item("dimensions_hwl", {
        let s = meta.box_cam.size_lwh;
        vec![rounded(s.z), rounded(s.y), rounded(s.x)]
    })?;
    dict.set_item("location_cam", vector(meta.box_cam.location_cam))?;
    dict.set_item("rotation_y", rounded(meta.box_cam.rotation_y))?;
    Ok(dict)
}

fn corners(rect: &Rect) -> (f64, f64, f64, f64) {
    (rect.u1, rect.v1, rect.u2, rect.v2)
}

fn vector(v: DVec3) -> Vec<f64> {
    v.to_array().map(rounded).to_vec()
}

/// To a millionth: keeps the sidecar short.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
}
