"""Results of other programs: OpenPCDet's pickled ones, and nuScenes' JSON with the tables that it refers to.

Sources: `generate_prediction_dicts` of OpenPCDet's `kitti_dataset.py`; the results format and classes of nuScenes'
detection task (nuscenes-devkit, `eval/detection/README.md`).
"""

from __future__ import annotations

import io
import pickle
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import as_array
from cadet._util.checks import as_path, shown
from cadet._util.plain_text import json_from_text
from cadet._util.user_files import read_file
from cadet.errors import CadetError, FileFormatError, MissingFileError
from cadet.evaluation.objects import Detections, GroundTruth
from cadet.formats.kitti.boxes import alpha_from_boxes, wrap_angle
from cadet.sensors.pose import rotation_of_quaternion

_Read = TypeVar("_Read")

_TABLES: Final = "nuScenes' tables"
_ARRAY: Final = np.zeros(1)
_OF_ARRAYS: Final[dict[str, Any]] = {
    "numpy.dtype": np.dtype,
    "numpy.ndarray": np.ndarray,
    "numpy.core.multiarray._reconstruct": _ARRAY.__reduce_ex__(4)[0],
    "numpy.core.multiarray.scalar": _ARRAY[0].__reduce_ex__(4)[0],
    "numpy.core.numeric._frombuffer": _ARRAY.__reduce_ex__(5)[0],
}
"""What arrays are unpickled with, by the name in the pickle; it may name any other function, and have it called."""

_DETECTION_NAMES: Final = {
    "movable_object.barrier": "barrier",
    "movable_object.trafficcone": "traffic_cone",
    "vehicle.bicycle": "bicycle",
    "vehicle.bus": "bus",
    "vehicle.car": "car",
    "vehicle.construction": "construction_vehicle",
    "vehicle.motorcycle": "motorcycle",
    "vehicle.trailer": "trailer",
    "vehicle.truck": "truck",
    "human.pedestrian.adult": "pedestrian",
    "human.pedestrian.child": "pedestrian",
    "human.pedestrian.construction_worker": "pedestrian",
    "human.pedestrian.police_officer": "pedestrian",
}
"""nuScenes' detection classes by the beginnings of its categories; all other categories take no part."""


def read_detections(path: str | Path, tables: str | Path | None = None) -> dict[str, Detections]:
    """Read a detector's results for `evaluate` and `analyze`. A folder of KITTI's text files needs no reading.

    Args:
        path: OpenPCDet's `result.pkl` for KITTI's format; or nuScenes' JSON, of which `tables` must be named.
        tables: nuScenes' folder of tables, such as `scenes/v1.0-trainval`: results stand in the world's frame, and
            these say where the car was.

    Returns:
        Detections by frame; for nuScenes by sample token, as `read_ground_truth` has them.

    Raises:
        MissingFileError: there is no such file.
        FileFormatError: it is none of these, or damaged.
        CadetError: results of nuScenes without tables.
    """
    file = as_path("path", path)
    if file.suffix == ".pkl":
        return _of_openpcdet(read_file(file), file.name)
    if file.suffix != ".json":
        raise CadetError(
            f"{file}: expected OpenPCDet's .pkl or nuScenes' .json; folders of .txt go to evaluate as such"
        )
    content = json_from_text(read_file(file), file.name)
    if tables is None:
        raise CadetError(f"{file}: nuScenes' results need tables=, the folder of tables that they refer to")
    samples = _checked(lambda: content["results"].items(), file.name)
    ego = _ego(as_path("tables", tables))

    def read() -> dict[str, Detections]:
        found = {}
        for token, rows in samples:
            boxes = ego.boxes_cam(token, rows)
            scores = np.array([row["detection_score"] for row in rows], np.float64)
            found[token] = Detections(scores=scores, **_columns([row["detection_name"] for row in rows], boxes))
        return found

    return _checked(read, file.name)


def read_ground_truth(tables: str | Path) -> dict[str, GroundTruth]:
    """Read what nuScenes' tables say of every sample, as its detection task counts it: objects with a return on them.

    Types are nuScenes' detection classes, such as "car". Boxes stand in the cam frame of a camera that looks ahead from
    the ego's origin, since objects stand all around; their 2D boxes are empty. `Level("All", 0.0, inclusive=True)`
    leaves none out, and the part "centers" of `analyze` is nuScenes' AP.

    Args:
        tables: the folder, such as `scenes/v1.0-trainval`.

    Returns:
        Objects by sample token.

    Raises:
        MissingFileError: a table is missing.
        FileFormatError: one is damaged.
    """
    folder = as_path("tables", tables)
    ego = _ego(folder)
    return _checked(lambda: _ground_truth(folder, ego), folder.name, _TABLES)


def _ground_truth(folder: Path, ego: _Ego) -> dict[str, GroundTruth]:
    categories = {row["token"]: row["name"] for row in _table(folder, "category")}
    instances = {row["token"]: categories[row["category_token"]] for row in _table(folder, "instance")}
    rows: dict[str, list[Mapping[str, Any]]] = defaultdict(list)
    names: dict[str, list[str]] = defaultdict(list)
    for row in _table(folder, "sample_annotation"):
        category = instances[row["instance_token"]]
        name = next((name for start, name in _DETECTION_NAMES.items() if category.startswith(start)), None)
        if name is not None and row["num_lidar_pts"] + row["num_radar_pts"] > 0:
            rows[row["sample_token"]].append(row)
            names[row["sample_token"]].append(name)
    truths = {}
    for token in ego.samples:
        zeros = np.zeros(len(rows[token]))
        boxes = ego.boxes_cam(token, rows[token])
        truths[token] = GroundTruth(truncated=zeros, occluded=zeros, **_columns(names[token], boxes))
    return truths


class _Ego:
    """Where the car was at each sample."""

    def __init__(self, folder: Path) -> None:
        lidars = {row["token"] for row in _table(folder, "sensor") if row["modality"] == "lidar"}
        on_lidar = {row["token"] for row in _table(folder, "calibrated_sensor") if row["sensor_token"] in lidars}
        poses = {row["token"]: row for row in _table(folder, "ego_pose")}
        self.samples = {
            row["sample_token"]: poses[row["ego_pose_token"]]
            for row in _table(folder, "sample_data")
            if row["is_key_frame"] and row["calibrated_sensor_token"] in on_lidar
        }

    def boxes_cam(self, token: str, rows: Iterable[Mapping[str, Any]]) -> NDArray[np.float64]:
        """Bring boxes of the world's frame into the cam frame of a sample: (n, 7)."""
        if token not in self.samples:
            raise CadetError(f"sample {shown(token)}: the tables have no such sample with a LIDAR's scan")
        pose = self.samples[token]
        ego_from_world = rotation_of_quaternion(pose["rotation"]).T
        boxes = []
        for row in rows:
            x, y, z = ego_from_world @ (np.array(row["translation"], np.float64) - pose["translation"])
            width, length, height = row["size"]
            ahead = ego_from_world @ rotation_of_quaternion(row["rotation"])[:, 0]
            heading = float(wrap_angle(-np.arctan2(ahead[1], ahead[0]) - 0.5 * np.pi))
            boxes.append([-y, 0.5 * height - z, x, length, width, height, heading])
        return np.array(boxes, np.float64).reshape(-1, 7)


def _ego(folder: Path) -> _Ego:
    return _checked(lambda: _Ego(folder), folder.name, _TABLES)


def _columns(names: list[str], boxes_cam: NDArray[np.float64]) -> dict[str, Any]:
    alphas = alpha_from_boxes(boxes_cam)
    return {"types": tuple(names), "boxes_img": np.zeros((len(names), 4)), "boxes_cam": boxes_cam, "alphas": alphas}


def _table(folder: Path, name: str) -> list[Mapping[str, Any]]:
    path = folder / f"{name}.json"
    rows: Any = json_from_text(read_file(path), path.name)
    if not isinstance(rows, list) or not all(isinstance(row, Mapping) for row in rows):
        raise FileFormatError("expected a list of tables", path.name)
    return rows


class _ArraysOnly(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        found = _OF_ARRAYS.get(f"{module.replace('numpy._core', 'numpy.core')}.{name}")
        if found is None:
            raise pickle.UnpicklingError(f"it names {module}.{name}, and only arrays are read")
        return found


def _of_openpcdet(data: bytes, file: str) -> dict[str, Detections]:
    try:
        frames = _ArraysOnly(io.BytesIO(data)).load()
    except Exception as error:  # noqa: BLE001 - a damaged pickle raises whatever its own bytes lead to
        raise FileFormatError(f"no pickle of arrays: {str(error) or type(error).__name__}", file) from None

    def read() -> dict[str, Detections]:
        return {str(frame["frame_id"]): _frame_of_openpcdet(frame) for frame in frames}

    return _checked(read, file)


def _frame_of_openpcdet(frame: Mapping[str, Any]) -> Detections:
    names = [str(name) for name in frame["name"]]
    count = len(names)
    place, lhw = (as_array(frame[name], name, (count, 3)) for name in ("location", "dimensions"))
    length, height, width = np.hsplit(lhw, 3)
    return Detections(
        types=tuple(names),
        boxes_img=frame["bbox"],
        boxes_cam=np.hstack([place, length, width, height, np.reshape(frame["rotation_y"], (count, 1))]),
        alphas=frame["alpha"],
        scores=frame["score"],
    )


def _checked(read: Callable[[], _Read], file: str, what: str = "a detector's results") -> _Read:
    """Name the file in what is wrong with it, unless its error names one."""
    try:
        return read()
    except (FileFormatError, MissingFileError):
        raise
    except CadetError as error:
        raise FileFormatError(str(error), file) from None
    except (ArithmeticError, AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        reason = f"{type(error).__name__}: {error}"
        raise FileFormatError(f"not laid out as {what} are ({reason})", file) from None
