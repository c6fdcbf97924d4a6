"""nuScenes' tables, filled sample by sample."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

from cadet.formats.exporter import Place
from cadet.formats.nuscenes.classes import ATTRIBUTES, CATEGORIES, VISIBILITY, attribute, category, visibility
from cadet.formats.nuscenes.scene_names import scene_names
from cadet.formats.sequences import time_us

Row = dict[str, Any]


def token(*parts: object) -> str:
    """Return a token of 32 hexadecimal digits: a function of what it names alone."""
    return sha256("/".join(str(part) for part in parts).encode("utf-8")).hexdigest()[:32]


def data_token(place: Place, channel: str) -> str:
    """Return the token of what a sensor has taken."""
    return token("sample_data", place.number, channel)


class Tables:
    """Rows by table of scenes that lie in one folder of tables. Samples come in the order of their numbers."""

    def __init__(self) -> None:
        self.num_of_type: Counter[str] = Counter()
        self._rows: dict[str, list[Row]] = defaultdict(list)
        self._sensors: dict[str, Row] = {}
        self._calibrated: dict[str, Row] = {}
        self._logs: dict[int, Row] = {}
        self._splits: dict[str, list[str]] = {"train": [], "val": [], "test": []}
        self._sweeps: list[Row] = []
        self._last_data: dict[tuple[int, str], Row] = {}
        self._last_seen: dict[tuple[int, int], Row] = {}
        self._instances: dict[tuple[int, int], Row] = {}
        self._speeds: dict[tuple[int, int], float] = {}
        self._pending: list[tuple[Row, tuple[int, int], Mapping[str, Any]]] = []

    @property
    def is_empty(self) -> bool:
        """Whether no sample was added."""
        return not self._rows

    @property
    def map_token(self) -> str:
        """The token of the only map."""
        return token("map")

    def add(
        self,
        place: Place,
        record: Mapping[str, Any],
        files: Mapping[str, str],
        labels: Mapping[str, str],
        *,
        is_key_frame: bool,
    ) -> None:
        """Add a sample of the dataset: a key frame, which nuScenes calls a sample, or a sweep between two of them.

        Args:
            place: which one.
            record: what the exporter's `record` returned.
            files: each channel's file.
            labels: the files of points' classes, by channel.
            is_key_frame: whether it is a key frame; the first one of an episode is.
        """
        stamp_us = time_us(place.episode, record["time_s"])
        if is_key_frame:
            sample = {
                "token": token("sample", place.number),
                "timestamp": stamp_us,
                "prev": "",
                "next": "",
                "scene_token": token("scene", place.episode),
            }
            self._add_to_scene(place, record, sample)
            for seen in record["objects"]:
                self._add_annotation(place, sample, seen)
        for channel, sensor in record["sensors"].items():
            data = self._add_data(
                place, stamp_us, channel, sensor, record["ego"], files[channel], is_key_frame=is_key_frame
            )
            if not is_key_frame:
                self._sweeps.append(data)
            if channel in labels:
                self._rows["lidarseg"].append(
                    {"token": data["token"], "sample_data_token": data["token"], "filename": labels[channel]}
                )

    def finished(self) -> dict[str, Any]:
        """Return the content of every table."""
        for annotation, key, seen in self._pending:
            name = attribute(seen["type"], seen["model"], seen["speed_mps"], self._speeds[key])
            annotation["attribute_tokens"] = [token("attribute", name)]
        self._pending.clear()
        categories = [
            {"token": token("category", name), "name": name, "description": text, "index": index}
            for index, (name, text) in enumerate(CATEGORIES.items())
        ]
        attributes = [
            {"token": token("attribute", name), "name": name, "description": text} for name, text in ATTRIBUTES.items()
        ]
        levels = [
            {
                "token": number,
                "level": f"v{round(low * 100)}-{round(high * 100)}",
                "description": f"between {round(low * 100)} and {round(high * 100)} % of it are visible in all images",
            }
            for number, (low, high) in VISIBILITY.items()
        ]
        the_map = {
            "token": self.map_token,
            "category": "semantic_prior",
            "filename": f"maps/{self.map_token}.png",
            "log_tokens": [log["token"] for log in self._logs.values()],
        }
        return {
            "category": categories,
            "attribute": attributes,
            "visibility": levels,
            "instance": list(self._instances.values()),
            "sensor": list(self._sensors.values()),
            "calibrated_sensor": list(self._calibrated.values()),
            "ego_pose": self._rows["ego_pose"],
            "log": list(self._logs.values()),
            "scene": self._rows["scene"],
            "sample": self._rows["sample"],
            "sample_data": self._rows["sample_data"],
            "sample_annotation": self._rows["sample_annotation"],
            "map": [the_map],
            "splits": {split: names for split, names in self._splits.items() if names},
            **({"lidarseg": self._rows["lidarseg"]} if "lidarseg" in self._rows else {}),
        }

    def _add_to_scene(self, place: Place, record: Mapping[str, Any], sample: Row) -> None:
        samples, scenes = self._rows["sample"], self._rows["scene"]
        samples.append(sample)
        sweeps, self._sweeps = self._sweeps, []
        if place.sample > 0:
            for data in sweeps:
                data["sample_token"] = sample["token"]
            before = samples[-2]
            before["next"], sample["prev"] = sample["token"], before["token"]
            scenes[-1]["last_sample_token"] = sample["token"]
            scenes[-1]["nbr_samples"] += 1
            return
        name = scene_names(place.split)[len(self._splits[place.split])]
        log = {
            "token": token("log", place.episode),
            "logfile": f"cadet-{place.episode:04d}",
            "vehicle": "cadet",
            "date_captured": "2020-01-01",
            "location": record["map"],
        }
        self._logs[place.episode] = log
        self._splits[place.split].append(name)
        scenes.append(
            {
                "token": sample["scene_token"],
                "log_token": log["token"],
                "nbr_samples": 1,
                "first_sample_token": sample["token"],
                "last_sample_token": sample["token"],
                "name": name,
                "description": f"{record['map']}, {record['weather']}",
            }
        )

    def _add_data(
        self,
        place: Place,
        stamp_us: int,
        channel: str,
        sensor: Mapping[str, Any],
        ego: Mapping[str, Any],
        file: str,
        *,
        is_key_frame: bool,
    ) -> Row:
        own = self._sensors.setdefault(
            channel, {"token": token("sensor", channel), "channel": channel, "modality": sensor["modality"]}
        )
        # The car's load turns the sensors, and stays the same through a scene.
        calibrated = {
            "token": token("calibrated_sensor", place.episode, channel),
            "sensor_token": own["token"],
            "translation": sensor["translation"],
            "rotation": sensor["rotation"],
            "camera_intrinsic": sensor["camera_intrinsic"],
        }
        self._calibrated.setdefault(calibrated["token"], calibrated)
        name = data_token(place, channel)
        self._rows["ego_pose"].append({"token": name, "timestamp": stamp_us, **ego})
        width, height = sensor["size"]
        data = {
            "token": name,
            # Of a sweep the last key frame's, until the next one comes.
            "sample_token": self._rows["sample"][-1]["token"],
            "ego_pose_token": name,
            "calibrated_sensor_token": calibrated["token"],
            "timestamp": stamp_us,
            "fileformat": "jpg" if sensor["modality"] == "camera" else "pcd",
            "is_key_frame": is_key_frame,
            "height": height,
            "width": width,
            "filename": file,
            "prev": "",
            "next": "",
        }
        _chain(self._last_data, (place.episode, channel), data)
        self._rows["sample_data"].append(data)
        return data

    def _add_annotation(self, place: Place, sample: Row, seen: Mapping[str, Any]) -> None:
        key = (place.episode, seen["id"])
        annotation = {
            "token": token("annotation", place.number, seen["id"]),
            "sample_token": sample["token"],
            "instance_token": token("instance", *key),
            "visibility_token": visibility(seen["visible_share"]),
            "attribute_tokens": [],
            "translation": seen["translation"],
            "size": seen["size_wlh"],
            "rotation": seen["rotation"],
            "prev": "",
            "next": "",
            "num_lidar_pts": seen["num_points"],
            "num_radar_pts": 0,
        }
        _chain(self._last_seen, key, annotation)
        self._rows["sample_annotation"].append(annotation)
        self.num_of_type[seen["type"]] += 1
        self._speeds[key] = max(self._speeds.get(key, 0.0), seen["speed_mps"])
        self._pending.append((annotation, key, seen))
        instance = self._instances.setdefault(
            key,
            {
                "token": annotation["instance_token"],
                "category_token": token("category", category(seen["type"], seen["model"])),
                "nbr_annotations": 0,
                "first_annotation_token": annotation["token"],
                "last_annotation_token": "",
            },
        )
        instance["nbr_annotations"] += 1
        instance["last_annotation_token"] = annotation["token"]


def _chain(last: dict[Any, Row], key: object, row: Row) -> None:
    """Let a row follow the last one of its key."""
    before = last.get(key)
    if before is not None:
        before["next"], row["prev"] = row["token"], before["token"]
    last[key] = row
