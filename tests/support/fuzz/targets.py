"""What is fed with damaged input, and what the input is made from: everything that reads a file of the user's."""

from __future__ import annotations

import io
import json
import random
import tempfile
from collections.abc import Callable
from functools import cache

import numpy as np

import cadet
from cadet import _cadet, kitti
from cadet._util.plain_text import json_from_text, toml_from_text
from cadet.evaluation import Rules
from cadet.evaluation.analysis.groups import groups_from_text
from cadet.formats.kitti.files import dialects
from cadet.formats.kitti.files.planes import plane_from_text
from cadet.formats.kitti.files.range_image import bytes_from_range_image, range_image_from_bytes
from cadet.formats.kitti.files.velodyne import points_from_bytes
from cadet.formats.scan_files.read import scan_from_data
from cadet.formats.webdataset import Member, read_members
from cadet.formats.webdataset.index import index_from_text, text_from_index
from cadet.sensors.beam_table import BeamTable
from fuzz.archives import damage_archive, tar_archive
from fuzz.checkpoints import checkpoint_targets
from fuzz.meshes import MESH_TARGETS
from fuzz.mutations import damage_bytes, damage_text, nested
from fuzz.pictures import picture_targets
from fuzz.road_text import ROADS
from fuzz.settings import SETTINGS_TARGETS
from fuzz.target import Input, Target
from scans.scan_writers import Columns, npy, pcd, ply
from synthetic import make_calib, make_frame


def _text(value: Input) -> str:
    assert isinstance(value, str)
    return value


def _bytes(value: Input) -> bytes:
    assert isinstance(value, bytes)
    return value


def _texts(name: str, valid: str, read: Callable[[str], object], *, nests: bool = False) -> Target:
    def make(rng: random.Random) -> str:
        return nested(rng) if nests and rng.random() < 0.05 else damage_text(rng, valid)

    return Target(name, make, lambda value: read(_text(value)))


def _files(name: str, valid: bytes, read: Callable[[bytes], object]) -> Target:
    return Target(name, lambda rng: damage_bytes(rng, valid), lambda value: read(_bytes(value)))


@cache
def _small_rig() -> cadet.Rig:
    return cadet.Rig(camera=cadet.Camera.kitti().resized(124, 38), lidar=cadet.Lidar.vlp16())


def _read_calib(text: str) -> object:
    calib = kitti.Calibration.from_text(text)
    return calib.points_velo_from_cam(np.ones((2, 3))), calib.eye_cam


def _read_lidar(text: str) -> object:
    return cadet.Lidar.custom(BeamTable.from_toml(text))._to_native().num_rings


def _read_points(data: bytes) -> object:
    with dialects.collected():
        return points_from_bytes(data)


def _read_scan(data: bytes) -> object:
    with dialects.collected():
        return scan_from_data(data, "scan")


def _read_simulation(text: str) -> object:
    with tempfile.NamedTemporaryFile("w", suffix=".toml", encoding="utf-8", newline="") as file:
        file.write(text)
        file.flush()
        return cadet.Simulation.read(file.name)


def _read_roads(text: str) -> object:
    return _cadet.Scene.empty(
        map_name="map.xodr",
        map_xodr=text,
        weather=cadet.Weather()._to_native(),
        rig=_small_rig()._to_native(),
        config=cadet.SceneConfig(num_cars=2, num_pedestrians=2)._to_native(),
        assets=None,
    )


SIMULATION = """
seed = 7
policy = "paper"
rig = "kitti"
lidar = "vlp16"
image_size = [310, 94]
weathers = ["snow", "dusk"]
samples_per_episode = 3
"""
RULES = """
[[levels]]
name = "Near"
min_height_px = 40
max_occlusion = 1
[classes.Vehicle]
types = ["Car", "Van"]
neighbors = ["Truck"]
min_overlap = { 2d = 0.7, bev = 0.5, 3d = 0.5 }
"""
_FRAME = make_frame()
_FIVE = np.column_stack([_FRAME.points_velo[:300], np.arange(300) % 32]).astype("<f4")
_COLUMNS: Columns = dict(zip(("x", "y", "z", "intensity", "ring"), _FIVE[:90].T, strict=True))
_SCANS = {
    **{f"PCD, {kind}": pcd(_COLUMNS, kind) for kind in ("ascii", "binary", "binary_compressed")},
    **{f"PLY, {kind}": ply(_COLUMNS, kind) for kind in ("ascii", "binary_big_endian")},
    "npy": npy(_FIVE[:90]),
}
_META = json.dumps({"image_size": [1242, 375], "objects": [{"actor_id": 1}], "sha256": {"image_2": "0" * 64}})

_ARCHIVE = tar_archive()
_MEMBERS = {"000001.calib.txt": Member(512, 700), "000001.planes.txt": Member(2048, 3)}


def _read_archive(value: Input) -> object:
    return read_members(io.BytesIO(_bytes(value)), "000000.tar")


TARGETS = (
    _texts("labels", "".join(f"{label.to_line()}\n" for label in _FRAME.labels), kitti.labels_from_text),
    _texts("calib", make_calib().to_text(), _read_calib),
    _texts("planes", "# Matrix\nWIDTH 4\nHEIGHT 1\n0.0 -1.0 0.0 1.65 \n", plane_from_text),
    _texts("image sets", "000001\n000002\n000017\n", kitti.ImageSet.from_text),
    _files("scans", _FRAME.points_velo[:50].tobytes(), _read_points),
    _files("scans of five columns", _FIVE.tobytes(), _read_points),
    *(_files(f"scans as {name}", data, _read_scan) for name, data in _SCANS.items()),
    _files("range images", bytes_from_range_image(np.ones((4, 20), np.float32)), range_image_from_bytes),
    _texts("JSON", _META, lambda text: json_from_text(text, "meta.json"), nests=True),
    _texts(
        "TOML", cadet.Lidar.vlp16().beam_table().to_toml(), lambda text: toml_from_text(text, "file.toml"), nests=True
    ),
    _texts("LIDARs", cadet.Lidar.vlp16().beam_table().to_toml(), _read_lidar, nests=True),
    _texts("rules of evaluation", RULES, lambda text: Rules.from_toml(text, file="rules.toml"), nests=True),
    _texts("groups", "000001 a\n000002 a\n000017 b\n", lambda text: groups_from_text(text, "groups.txt")),
    *MESH_TARGETS,
    _texts("roads", ROADS, _read_roads),
    _texts("simulations", SIMULATION, _read_simulation, nests=True),
    Target("archives", lambda rng: damage_archive(rng, _ARCHIVE), _read_archive),
    _texts("indexes of archives", text_from_index(_MEMBERS), lambda text: index_from_text(text, "000000.idx")),
    *SETTINGS_TARGETS,
    *checkpoint_targets(),
    *picture_targets(),
)
