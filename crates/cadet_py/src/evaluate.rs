//! KITTI's average precision, overlaps of boxes, and suppression.

use std::path::PathBuf;

use cadet_core::evaluate as core;
use cadet_core::{Error, Result};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::arrays;
use crate::error::BorderError;
use crate::guard;

/// Types, neighbors and least overlaps of each class.
type Classes = Vec<(Vec<String>, Vec<String>, [f64; 3])>;
/// Least height, whether it belongs to the level, most occlusion, most truncation.
type Levels = Vec<(f64, bool, f64, f64)>;
/// The frames' objects one after the other: where each frame begins and the end, types, numbers.
type Packed<'py> = (Vec<usize>, Vec<String>, PyReadonlyArray2<'py, f64>);

/// Where one side of the comparison comes from.
#[derive(FromPyObject)]
pub(crate) enum Source<'py> {
    /// A folder and each frame's id, None where the frame has no file.
    Files((PathBuf, Vec<Option<String>>)),
    /// Memory.
    Packed(Packed<'py>),
}

fn settings(classes: Classes, levels: Levels) -> core::Settings {
    core::Settings {
        classes: classes
            .into_iter()
            .map(|(kinds, neighbors, min_overlap)| core::ClassLimits {
                kinds: kinds_of(&kinds),
                neighbors: kinds_of(&neighbors),
                min_overlap,
            })
            .collect(),
        levels: levels
            .into_iter()
            .map(|(min_height_px, is_inclusive, max_occlusion, max_truncation)| core::Level {
                min_height_px,
                is_inclusive,
                max_occlusion_level: max_occlusion,
                max_truncation,
            })
            .collect(),
    }
}

fn kinds_of(names: &[String]) -> core::ObjectTypes {
    names.iter().map(|name| core::ObjectType::from_name(name)).collect()
}

/// Evaluates detections against ground truth, each from files or from memory.
#[pyfunction]
#[pyo3(signature = (truths, detections, *, classes, levels))]
pub(crate) fn evaluate<'py>(
    py: Python<'py>,
    truths: Source<'py>,
    detections: Source<'py>,
    classes: Classes,
    levels: Levels,
) -> PyResult<Bound<'py, PyDict>> {
    let settings = settings(classes, levels);
    settings.check().map_err(BorderError::from)?;
    let sides = read(py, truths, detections)?;
    let frames = sides.frames;
    let curves = guard::detached(py, || core::evaluate(&frames, &settings))?;
    let result = PyDict::new(py);
    result.set_item("num_truths", frames.iter().map(|frame| frame.truths.len()).sum::<usize>())?;
    result.set_item("num_detections", frames.iter().map(|frame| frame.detections.len()).sum::<usize>())?;
    let is_left = |kind: core::ObjectType| !settings.classes.iter().any(|class| class.kinds.contains(kind));
    for (name, others) in [("other_truths", &sides.other_truths), ("other_detections", &sides.other_detections)] {
        let left = others.iter().filter(|&(kind, ..)| is_left(kind)).map(|(_, name, count)| (name, count));
        result.set_item(name, left.collect::<Vec<_>>())?;
    }
    let sight = core::sight(&frames, &settings);
    result.set_item("absent_classes", sight.absent_classes)?;
    result.set_item("num_own_truths", sight.num_truths)?;
    result.set_item("num_own_detections", sight.num_detections)?;
    result.set_item("num_low_detections", sight.num_low_detections)?;
    result.set_item("num_truths_without_box", sight.num_truths_without_box)?;
    result.set_item("num_detections_without_box", sight.num_detections_without_box)?;
    let list = PyList::empty(py);
    for curve in &curves {
        list.append(curve_dict(py, curve)?)?;
    }
    result.set_item("curves", list)?;
    Ok(result)
}

/// Where each draw begins and the end, and the drawn frames one draw after the other.
type Draws<'py> = (Vec<usize>, PyReadonlyArray1<'py, u32>);

fn split_draws((starts, indices): &Draws<'_>) -> std::result::Result<Vec<Vec<u32>>, BorderError> {
    let indices = indices.as_array().to_vec();
    if starts.first() != Some(&0) || starts.last() != Some(&indices.len()) || !starts.is_sorted() {
        let got = format!("{} for {} starts", indices.len(), starts.len());
        let expected = "frames split by rising starts".to_owned();
        return Err(Error::Shape { what: "draws", got, expected }.into());
    }
    Ok(starts.windows(2).map(|pair| indices[pair[0]..pair[1]].to_vec()).collect())
}

/// AP of each class, metric and level in draws of frames with replacement.
#[pyfunction]
#[pyo3(signature = (truths, detections, *, classes, levels, draws))]
pub(crate) fn evaluate_draws<'py>(
    py: Python<'py>,
    truths: Source<'py>,
    detections: Source<'py>,
    classes: Classes,
    levels: Levels,
    draws: Draws<'py>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let settings = settings(classes, levels);
    settings.check().map_err(BorderError::from)?;
    let frames = read(py, truths, detections)?.frames;
    let draws = split_draws(&draws)?;
    let drawn = guard::detached(py, || core::evaluate_draws(&frames, &settings, &draws, guard::handle_signals))?;
    let means = |ap: &[[f64; 2]]| arrays::plane(py, ap.as_flattened().to_vec(), ap.len(), 2);
    let dict = |ap: &core::DrawnAp| {
        let dict = PyDict::new(py);
        dict.set_item("class", ap.class)?;
        dict.set_item("metric", ap.metric as usize)?;
        dict.set_item("level", ap.level)?;
        dict.set_item("ap", means(&ap.ap))?;
        dict.set_item("heading", ap.heading.as_deref().map(means))?;
        Ok(dict)
    };
    drawn.iter().map(dict).collect()
}

/// Objects read from files: where each frame begins and the end, types, numbers.
type PackedFiles<'py> = (Vec<usize>, Vec<String>, Bound<'py, PyArray2<f64>>);

/// Reads label files as `evaluate` takes them from memory.
#[pyfunction]
pub(crate) fn read_truths(
    py: Python<'_>,
    folder: PathBuf,
    ids: Vec<Option<String>>,
) -> std::result::Result<PackedFiles<'_>, BorderError> {
    let frames = guard::detached(py, || core::read_files(&folder, &ids, core::parse_truths))?;
    Ok(pack(py, &frames, |t: &core::Truth| (t.kind, truth_row(t))))
}

/// Reads result files likewise; a frame without one, whose id is None, has no detections.
#[pyfunction]
pub(crate) fn read_detections(
    py: Python<'_>,
    folder: PathBuf,
    ids: Vec<Option<String>>,
) -> std::result::Result<PackedFiles<'_>, BorderError> {
    let frames = guard::detached(py, || core::read_files(&folder, &ids, core::parse_detections))?;
    Ok(pack(py, &frames, |d: &core::Detection| (d.kind, detection_row(d))))
}

fn pack<'py, T, const N: usize>(
    py: Python<'py>,
    frames: &[core::Parsed<T>],
    row: impl Fn(&T) -> (core::ObjectType, [f64; N]),
) -> PackedFiles<'py> {
    let mut starts = vec![0];
    let (mut names, mut numbers) = (Vec::new(), Vec::new());
    for frame in frames {
        for object in &frame.objects {
            let (kind, values) = row(object);
            names.push(frame.other_names.name(kind).to_owned());
            numbers.extend_from_slice(&values);
        }
        starts.push(names.len());
    }
    let numbers = arrays::plane(py, numbers, names.len(), N);
    (starts, names, numbers)
}

/// Both sides, and the types that KITTI does not have.
struct Sides {
    frames: Vec<core::FramePair>,
    other_truths: core::OtherNames,
    other_detections: core::OtherNames,
}

fn read(py: Python<'_>, truths: Source<'_>, detections: Source<'_>) -> std::result::Result<Sides, BorderError> {
    let (truths, other_truths) = match truths {
        Source::Files((folder, ids)) => {
            joined(guard::detached(py, || core::read_files(&folder, &ids, core::parse_truths))?)
        }
        Source::Packed(packed) => unpack("truths", &packed, truth)?,
    };
    let (detections, other_detections) = match detections {
        Source::Files((folder, ids)) => {
            joined(guard::detached(py, || core::read_files(&folder, &ids, core::parse_detections))?)
        }
        Source::Packed(packed) => unpack("detections", &packed, detection)?,
    };
    if truths.len() != detections.len() {
        let (got, expected) = (detections.len().to_string(), format!("{} as truths", truths.len()));
        return Err(Error::Shape { what: "frames of detections", got, expected }.into());
    }
    let pair = |(truths, detections)| core::FramePair { truths, detections };
    Ok(Sides { frames: truths.into_iter().zip(detections).map(pair).collect(), other_truths, other_detections })
}

/// The objects of frames, and the names among them that KITTI does not have.
type Objects<T> = (Vec<Vec<T>>, core::OtherNames);

fn joined<T>(frames: Vec<core::Parsed<T>>) -> Objects<T> {
    let mut names = core::OtherNames::default();
    let mut objects = Vec::with_capacity(frames.len());
    for frame in frames {
        names.merge(frame.other_names);
        objects.push(frame.objects);
    }
    (objects, names)
}

fn curve_dict<'py>(py: Python<'py>, curve: &core::Curve) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("class", curve.class)?;
    dict.set_item("metric", curve.metric as usize)?;
    dict.set_item("level", curve.level)?;
    dict.set_item("num_valid", curve.num_valid)?;
    dict.set_item("thresholds", &curve.thresholds)?;
    dict.set_item("num_tp", &curve.num_tp)?;
    dict.set_item("num_fp", &curve.num_fp)?;
    dict.set_item("precision", samples(py, &curve.precision)?)?;
    dict.set_item("heading", curve.heading.as_ref().map(|heading| samples(py, heading)).transpose()?)?;
    dict.set_item("perfect", samples(py, &core::perfect(curve.num_valid))?)?;
    Ok(dict)
}

/// The samples, and their means over 11 and 40 recall positions.
fn samples<'py>(py: Python<'py>, samples: &core::PrecisionByRecall) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("samples", samples.to_vec())?;
    dict.set_item("r11", core::average_r11(samples))?;
    dict.set_item("r40", core::average_r40(samples))?;
    Ok(dict)
}

/// Splits packed objects into frames.
fn unpack<T, const N: usize>(
    what: &'static str,
    (starts, names, numbers): &Packed<'_>,
    object: fn(core::ObjectType, [f64; N]) -> T,
) -> Result<Objects<T>> {
    let rows = numbers.as_array();
    let is_whole = starts.first() == Some(&0) && starts.last() == Some(&names.len()) && starts.is_sorted();
    if rows.ncols() != N || rows.nrows() != names.len() || !is_whole {
        let got = format!("({}, {}) for {} names", rows.nrows(), rows.ncols(), names.len());
        return Err(Error::Shape {
            what,
            got,
            expected: format!("a row of {N} for each name, split by rising starts"),
        });
    }
    let mut others = core::OtherNames::default();
    let mut row = |index: usize| {
        let kind = core::ObjectType::from_name(&names[index]);
        others.count(kind, &names[index]);
        object(kind, std::array::from_fn(|column| rows[[index, column]]))
    };
    let frames = starts.windows(2).map(|pair| (pair[0]..pair[1]).map(&mut row).collect()).collect();
    Ok((frames, others))
}

fn box_img(n: &[f64]) -> core::BoxImg {
    core::BoxImg { left_px: n[0], top_px: n[1], right_px: n[2], bottom_px: n[3] }
}

fn box_cam(n: &[f64]) -> core::RotatedBox {
    core::RotatedBox::from_array(std::array::from_fn(|i| n[i]))
}

fn truth(kind: core::ObjectType, n: [f64; 15]) -> core::Truth {
    core::Truth {
        kind,
        truncation: n[0],
        occlusion_level: n[1],
        alpha: n[2],
        box_img: box_img(&n[3..7]),
        box_cam: box_cam(&n[7..14]),
        is_optional: n[14] != 0.0,
    }
}

fn truth_row(t: &core::Truth) -> [f64; 15] {
    let [x1, y1, x2, y2] = [t.box_img.left_px, t.box_img.top_px, t.box_img.right_px, t.box_img.bottom_px];
    let [x, y, z, l, w, h, ry] = t.box_cam.to_array();
    [t.truncation, t.occlusion_level, t.alpha, x1, y1, x2, y2, x, y, z, l, w, h, ry, f64::from(u8::from(t.is_optional))]
}

fn detection_row(d: &core::Detection) -> [f64; 14] {
    let [x1, y1, x2, y2] = [d.box_img.left_px, d.box_img.top_px, d.box_img.right_px, d.box_img.bottom_px];
    let [x, y, z, l, w, h, ry] = d.box_cam.to_array();
    [d.alpha, x1, y1, x2, y2, x, y, z, l, w, h, ry, d.score, f64::from(u8::from(d.is_optional))]
}

fn detection(kind: core::ObjectType, n: [f64; 14]) -> core::Detection {
    core::Detection {
        kind,
        alpha: n[0],
        box_img: box_img(&n[1..5]),
        box_cam: box_cam(&n[5..12]),
        score: n[12],
        is_optional: n[13] != 0.0,
    }
}

fn boxes_cam(what: &'static str, array: &PyReadonlyArray2<'_, f64>) -> Result<Vec<core::RotatedBox>> {
    let view = array.as_array();
    if view.ncols() != 7 {
        let got = format!("({}, {})", view.nrows(), view.ncols());
        return Err(Error::Shape { what, got, expected: "(n, 7)".to_owned() });
    }
    Ok(view.rows().into_iter().map(|row| core::RotatedBox::from_array(std::array::from_fn(|i| row[i]))).collect())
}

/// The IoU of each box of `a` with each box of `b`, from above or of volumes.
#[pyfunction]
pub(crate) fn box_iou<'py>(
    py: Python<'py>,
    a: PyReadonlyArray2<'py, f64>,
    b: PyReadonlyArray2<'py, f64>,
    is_3d: bool,
) -> std::result::Result<Bound<'py, PyArray2<f64>>, BorderError> {
    let (a, b) = (boxes_cam("a", &a)?, boxes_cam("b", &b)?);
    let iou = if is_3d { core::iou_3d } else { core::iou_bev };
    let matrix = guard::detached(py, || core::iou_matrix(&a, &b, iou, guard::handle_signals))?;
    Ok(arrays::plane(py, matrix, a.len(), b.len()))
}

/// The indices of the boxes that no better kept one overlaps by more than the threshold.
#[pyfunction]
pub(crate) fn nms_bev<'py>(
    py: Python<'py>,
    boxes: PyReadonlyArray2<'py, f64>,
    scores: PyReadonlyArray1<'py, f64>,
    threshold: f64,
) -> std::result::Result<Bound<'py, PyArray1<i64>>, BorderError> {
    let boxes = boxes_cam("boxes", &boxes)?;
    let scores: Vec<f64> = scores.as_array().to_vec();
    if scores.len() != boxes.len() {
        let (got, expected) = (format!("({},)", scores.len()), format!("({},)", boxes.len()));
        return Err(Error::Shape { what: "scores", got, expected }.into());
    }
    let kept = guard::detached(py, || Ok::<_, Error>(core::nms_bev(&boxes, &scores, threshold)))?;
    Ok(PyArray1::from_vec(py, kept.into_iter().map(|index| index as i64).collect()))
}
