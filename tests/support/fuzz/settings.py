"""Files of settings and lists as targets: their documents stay TOML or JSON, so that damage gets past the parser."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cadet
from cadet._util.plain_text import toml_from_text
from cadet.datasets.object_bank import ObjectBank
from cadet.formats.bdd100k import labels_from_text
from cadet.formats.kitti.lint.manifest import read_manifest
from cadet.sensors.beam_table import BeamTable
from fuzz.mutations import damage_values
from fuzz.target import Input, Target

_BOX = {"x1": 10.0, "y1": 20.5, "x2": 60, "y2": 90}
_BDD = [
    {
        "name": "a.jpg",
        "labels": [
            {"category": "car", "attributes": {"occluded": True, "truncated": False}, "box2d": _BOX},
            {"category": "rider", "box2d": _BOX},
            {"category": "bike", "box2d": _BOX},
        ],
    }
]
_CORNER = [0.1, 0.2, 14.0]
_BANK = {
    "format": "cadet-object-bank",
    "version": 1,
    "objects": [
        {
            "type": "Car",
            "source": "000000",
            "box_scan": [0.7, 1.5, 14.6, 3.6, 1.6, 1.4, -1.5],
            "corners_scan": [_CORNER] * 4,
            "num_points": 122,
        }
    ],
}
_MANIFEST = {
    "format": 2,
    "cadet": "0.1.0",
    "counts": {"frames": 1, "episodes": 1, "labels": {"Car": 3}},
    "policy": {"name": "kitti", "samples_per_episode": 20, "weathers": {"clear_noon": 1.0}},
    "rig": {"range_m": [1.45, 80.0]},
    "sha256": {"training/calib/000000.txt": "0" * 64, "ImageSets/train.txt": "1" * 64},
}
_PRESETS = Path(cadet.__file__).parent / "sensors" / "presets"
_RIG = toml_from_text((_PRESETS / "rigs" / "nuscenes.toml").read_bytes(), "nuscenes.toml")
_LIDAR = toml_from_text(cadet.Lidar.vlp16().to_toml(), "vlp16.toml")


def _toml(value: Any) -> str:
    """Write a value as TOML has it within a line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if value is None:
        return '""'
    return json.dumps(value) if isinstance(value, (str, bool)) else repr(value)


def _as_toml(document: Any) -> str:
    return "".join(f"{json.dumps(key)} = {_toml(value)}\n" for key, value in document.items())


def _target(name: str, document: Any, write: Callable[[Any], str], read: Callable[[str], object]) -> Target:
    def read_text(value: Input) -> object:
        assert isinstance(value, str)
        return read(value)

    return Target(name, lambda rng: write(damage_values(rng, document)), read_text)


def _beside(name: str, read: Callable[[Path], object]) -> Callable[[str], object]:
    """Return what reads a text as the file of a name in a folder of its own."""

    def read_text(text: str) -> object:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / name).write_bytes(text.encode("utf-8", "surrogatepass"))
            return read(Path(folder))

    return read_text


SETTINGS_TARGETS = (
    _target("rigs, values", _RIG, _as_toml, _beside("r.toml", lambda folder: cadet.Rig.from_toml(folder / "r.toml"))),
    _target("LIDARs, values", _LIDAR, _as_toml, lambda text: cadet.Lidar.custom(BeamTable.from_toml(text)).to_native()),
    _target("BDD100K, values", _BDD, json.dumps, lambda text: labels_from_text(text, "labels.json")),
    _target("banks, values", _BANK, json.dumps, _beside("bank.json", ObjectBank)),
    _target("manifests, values", _MANIFEST, json.dumps, _beside("manifest.json", read_manifest)),
)
