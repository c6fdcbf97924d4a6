"""KITTI's folder as an exporter's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import tee
from typing import Any, Final

from cadet._util.checks import shown
from cadet._util.sink import Sink, read_each
from cadet.errors import CadetError
from cadet.formats.exporter import Ending, FilesInPlace, Finished, Place
from cadet.formats.kitti.croissant import CROISSANT, croissant
from cadet.formats.kitti.dataset import encode_facts, encode_maps, encode_meta
from cadet.formats.kitti.files.folder import (
    CAMERAS,
    REQUIRED,
    camera_kind,
    ids_among,
    is_camera_name,
    is_numbered,
    suffix_of,
)
from cadet.formats.kitti.files.point_labels import bytes_from_point_labels, point_labels
from cadet.formats.kitti.files.range_image import bytes_from_range_image, range_image
from cadet.formats.kitti.from_sample import calibration_of, labels_of, meta_of, move_off_zero_depth
from cadet.formats.kitti.image_sets import ImageSet
from cadet.formats.kitti.label import text_from_labels
from cadet.formats.point_files import POINT_FILES, columns_of_points
from cadet.sensors.camera import Camera
from cadet.sensors.rig import RIGHT_CAMERA, Rig
from cadet.sensors.sample import MORE_MAPS, Sample, Wanted

_MAPS: Final = ("depth", "instance", "semantic", *MORE_MAPS)
_RIGHT_LABELS: Final = "label_3"
_POINTS: Final = {f"points_{suffix}": encode for suffix, encode in POINT_FILES.items()}


class KittiExporter(FilesInPlace):
    """One image, one scan, labels, a calibration and a plane for each sample; see `cadet.formats.exporter.Exporter`."""

    name = "kitti"
    extras: tuple[str, ...] = (
        *(*_MAPS, RIGHT_CAMERA, _RIGHT_LABELS, CAMERAS),
        *("point_labels", "point_times", *_POINTS, "range_image"),
    )
    base: tuple[str, ...] = ("image_2", "velodyne", "calib", "label_2", "planes")
    needs_sequence = False

    def check(self, rig: Rig, extras: tuple[str, ...]) -> None:
        """Refuse what a rig has no camera for, and cameras whose names are none of folders."""
        for extra in (RIGHT_CAMERA, _RIGHT_LABELS):
            if extra in extras and not rig.has_right_camera:
                raise CadetError(f"cannot write {extra}: the rig {rig.name} has no right color camera")
        if CAMERAS in extras:
            if not rig.mounted_cameras:
                raise CadetError(f"cannot write {CAMERAS}: the rig {rig.name} has no further camera")
            for name in rig.mounted_cameras:
                if not is_camera_name(name):
                    rule = "expected letters, digits, _, and -, up to 64"
                    raise CadetError(f"cannot write the camera {shown(name)} of the rig {rig.name}: {rule}")

    def wanted(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> Wanted:
        """Return what the folders need."""
        right = (RIGHT_CAMERA,) if RIGHT_CAMERA in extras or _RIGHT_LABELS in extras else ()
        more = next((rig.mounted_cameras for rig in rigs), ()) if CAMERAS in extras else ()
        return Wanted(
            sensors=right + more,
            maps=any(name in extras for name in _MAPS),
            labels=_RIGHT_LABELS in extras or CAMERAS in extras,
            more_maps=tuple(name for name in MORE_MAPS if name in extras),
        )

    def kinds(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> tuple[str, ...]:
        """Return the folders.

        Raises:
            CadetError: further cameras are to be written, and the rigs have different ones.
        """
        own = tuple(extra for extra in self.extras if extra in extras and extra != CAMERAS)
        of_cameras = {_kinds_of_cameras(rig, extras) for rig in rigs} if CAMERAS in extras else {()}
        if len(of_cameras) != 1:
            raise CadetError(f"cannot write {CAMERAS}: expected the same further cameras on all rigs of the policy")
        return self.base + own + of_cameras.pop()

    def path(self, place: Place, kind: str) -> str:
        """Return a file's name under `training` or `testing`."""
        folder = "meta" if kind == "record" else kind
        part = "testing" if place.split == "test" else "training"
        return f"{part}/{folder}/{place.id}{suffix_of(folder)}"

    def encode(self, sample: Sample, extras: tuple[str, ...]) -> dict[str, bytes]:
        """Return the files by folder. Images are encoded by the core that made them."""
        calib, scan = calibration_of(sample.rig), sample.scan()
        points_velo = move_off_zero_depth(scan.points_velo, calib)
        files = {"image_2": sample.png()} | encode_facts(points_velo, calib, labels_of(sample), sample.plane)
        files |= _maps(sample, None, extras)
        if RIGHT_CAMERA in extras:
            files[RIGHT_CAMERA] = sample.png(RIGHT_CAMERA)
        if _RIGHT_LABELS in extras:
            files[_RIGHT_LABELS] = text_from_labels(labels_of(sample, RIGHT_CAMERA)).encode("ascii")
        if "point_labels" in extras:
            files["point_labels"] = bytes_from_point_labels(point_labels(scan, sample.agents))
        if "point_times" in extras:
            files["point_times"] = scan.time_s.astype("<f4").tobytes()
        for name in sample.rig.mounted_cameras if CAMERAS in extras else ():
            files |= {camera_kind(name, kind): data for kind, data in _of_camera(sample, name, extras).items()}
        if any(kind in extras for kind in _POINTS):
            columns = columns_of_points(points_velo, scan.ring, scan.time_s)
            files |= {kind: encode(columns) for kind, encode in _POINTS.items() if kind in extras}
        if "range_image" in extras:
            files["range_image"] = bytes_from_range_image(range_image(scan, sample.rig.lidar))
        return files

    def record(self, sample: Sample) -> dict[str, Any]:
        """Return the `meta` of a sample."""
        return meta_of(sample)

    def record_bytes(self, record: Mapping[str, Any]) -> bytes:
        """Return the `meta` file."""
        return encode_meta(dict(record))

    def written(self, sink: Sink) -> set[int]:
        """Return the numbers of the frames. Strange files, such as a copy that a file manager made, are no frames."""
        found = set()
        for part in ("training", "testing"):
            for kind in REQUIRED:
                ids = ids_among(sink.names(f"{part}/{kind}"), kind)
                found |= {int(frame_id) for frame_id in ids if is_numbered(frame_id)}
        return found

    def finish(self, sink: Sink, places: Iterable[Place]) -> Ending:
        """Return `ImageSets`, and count the labels of the files."""
        places, same = tee(places)
        labels = read_each(sink, (self.path(place, "label_2") for place in same))
        # Tools of others list these folders, be there a test frame or none.
        folders = tuple(f"testing/{folder}" for folder in REQUIRED)
        return replace(ending(places, labels), folders=folders)

    def describe(self, dataset: Finished) -> dict[str, bytes]:
        """Return the description in Croissant's format."""
        return {CROISSANT: croissant(dataset.kinds, dataset.head, dataset.manifest_sha256)}


def _kinds_of_cameras(rig: Rig, extras: tuple[str, ...]) -> tuple[str, ...]:
    """Return the folders of a rig's further cameras."""
    maps = tuple(name for name in _MAPS if name in extras)
    return tuple(
        camera_kind(name, kind)
        for name in rig.mounted_cameras
        for kind in ("image_2", "label_2", *(() if _is_fisheye(rig, name) else ("calib",)), *maps)
    )


def _of_camera(sample: Sample, name: str, extras: tuple[str, ...]) -> dict[str, bytes]:
    files = {"image_2": sample.png(name), "label_2": text_from_labels(labels_of(sample, name)).encode("ascii")}
    # No projection by a matrix.
    if not _is_fisheye(sample.rig, name):
        files["calib"] = calibration_of(sample.rig, name).to_text().encode("ascii")
    return files | _maps(sample, name, extras)


def _is_fisheye(rig: Rig, name: str) -> bool:
    camera = rig.sensor(name)
    return isinstance(camera, Camera) and camera.model == "fisheye"


def _maps(sample: Sample, camera: str | None, extras: tuple[str, ...]) -> dict[str, bytes]:
    maps = sample.maps(camera) if any(name in extras for name in _MAPS) else None
    if maps is None:
        return {}
    return encode_maps({name: getattr(maps, name) for name in _MAPS if name in extras})


def ending(places: Iterable[Place], labels: Iterable[bytes]) -> Ending:
    """Return `ImageSets`, and count the labels of samples' label files."""
    ids: dict[str, list[str]] = {"train": [], "val": [], "trainval": [], "test": []}
    types: Counter[str] = Counter()
    for place, text in zip(places, labels, strict=True):
        ids[place.split].append(place.id)
        if place.split != "test":
            ids["trainval"].append(place.id)
        lines = text.decode("ascii").splitlines()
        types.update(line.split(" ", 1)[0] for line in lines)
    files = {f"ImageSets/{split}.txt": ImageSet(tuple(i)).to_text().encode("ascii") for split, i in ids.items()}
    return Ending(files, types)
