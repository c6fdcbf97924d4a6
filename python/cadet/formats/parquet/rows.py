"""A sample as a row: KITTI's files in typed columns, from which the same files come back byte for byte."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np

from cadet._util.extras import load_extra
from cadet.formats.kitti.calib import KEYS, Calibration
from cadet.formats.kitti.files.planes import plane_from_text, text_from_plane
from cadet.formats.kitti.label import Label, labels_from_text, text_from_labels

_NEEDED_FOR: Final = ("parquet", "--format parquet")
"""The extra that brings pyarrow, and what needs it."""
FACTS: Final = {
    "seed": "of the dataset",
    "episode": "the drive that the frame is of; all frames of a drive are in one split",
    "sample": "the frame's number in its drive",
    "district": "the kind of streets",
    "weather": "the weather's name",
    "map": "the map's name",
    "rig": "the sensors' name",
    "time_s": "seconds since the drive began",
    "ego_speed_mps": "the car's speed, meters per second",
}
"""Columns that repeat what `meta` says, and what each holds."""
COLUMNS: Final = {
    "id": "the frame's number as six digits: the name of its files in KITTI's folder",
    "image": "the left color camera's image, as PNG",
    "points_velo": "the scan's bytes: little-endian float32 x, y, z in meters and intensity 0 to 1, point by point",
    "labels": (
        "objects and DontCare regions: type, truncated, occluded, alpha, bbox, dimensions_hwl, location_cam, "
        "rotation_y, as in KITTI's files"
    ),
    "calib": "P0, P1, P2, P3, R0_rect, Tr_velo_to_cam, Tr_imu_to_velo: KITTI's matrices, row by row",
    "plane": "the ground as a, b, c, d in the cam frame, meters",
    **FACTS,
    "meta": "what else is known, as JSON: pose, sun, and for each label its visibility, returns, and velocity",
}
"""The columns in their order, and what each holds."""


class _Kind(NamedTuple):
    """How a kind of KITTI's files stands in a row."""

    column: str
    value: Callable[[bytes], Any]
    """Returns the column's value."""
    data: Callable[[Any], bytes]
    """Returns the file's bytes."""


KINDS: Final = {
    "image_2": _Kind("image", lambda data: {"bytes": data}, lambda value: bytes(value["bytes"])),
    "velodyne": _Kind("points_velo", bytes, bytes),
    "calib": _Kind(
        "calib",
        lambda data: {key: getattr(Calibration.from_text(data.decode("ascii")), key).tolist() for key in KEYS},
        lambda value: _text_of_calib(value).encode("ascii"),
    ),
    "label_2": _Kind(
        "labels",
        lambda data: [_fields(label) for label in labels_from_text(data.decode("ascii"))],
        lambda value: text_from_labels(Label(**fields) for fields in value).encode("ascii"),
    ),
    "planes": _Kind(
        "plane",
        lambda data: plane_from_text(data.decode("ascii")).tolist(),
        lambda value: text_from_plane(np.array(value)).encode("ascii"),
    ),
    "meta": _Kind("meta", lambda data: data.decode("ascii"), lambda value: str(value).encode("ascii")),
}
"""The kinds of files that a row holds."""


def arrow() -> Any:
    """Return pyarrow, with its module `parquet`.

    Raises:
        CadetError: it is not installed.
    """
    load_extra("pyarrow.parquet", *_NEEDED_FOR)
    return load_extra("pyarrow", *_NEEDED_FOR)


@cache
def schema() -> Any:
    """Return the columns' types, with what tells `datasets` that images are images.

    Raises:
        CadetError: pyarrow is not installed.
    """
    pa = arrow()
    text, whole, real = pa.string(), pa.int64(), pa.float64()
    # As Parquet files name the values of a list.
    reals = pa.list_(pa.field("element", real))
    of_label = {"type": text, "truncated": real, "occluded": whole, "alpha": real, "bbox": reals}
    of_label |= {"dimensions_hwl": reals, "location_cam": reals, "rotation_y": real}
    types = {
        **dict.fromkeys(COLUMNS, text),
        **dict.fromkeys(("seed", "episode", "sample"), whole),
        **dict.fromkeys(("time_s", "ego_speed_mps"), real),
        "image": pa.struct({"bytes": pa.binary(), "path": text}),
        "points_velo": pa.binary(),
        "labels": pa.list_(pa.field("element", pa.struct(of_label))),
        "calib": pa.struct(dict.fromkeys(KEYS, pa.list_(pa.field("element", reals)))),
        "plane": reals,
    }
    features = {"info": {"features": {"image": {"_type": "Image"}}}}
    return pa.schema(types, {"huggingface": json.dumps(features)})


def row_of_files(frame_id: str, files: Mapping[str, bytes]) -> dict[str, Any]:
    """Return the row of a sample.

    Args:
        frame_id: the sample's id.
        files: its files by kind. What one that is missing would tell has no entry.
    """
    row = {"id": frame_id, **{KINDS[kind].column: KINDS[kind].value(data) for kind, data in files.items()}}
    meta = json.loads(row.get("meta", "{}"))
    return row | {fact: meta[fact] for fact in FACTS if fact in meta}


def _fields(label: Label) -> dict[str, Any]:
    fields = asdict(label)
    del fields["score"]
    return fields


def _text_of_calib(matrices: Mapping[str, Any]) -> str:
    arrays: dict[str, Any] = {key: np.array(matrices[key]) for key in KEYS}
    return Calibration(**arrays).to_text()
