"""The description of a generated KITTI folder that dataset catalogs and loaders read.

Reference: Croissant 1.1 (https://docs.mlcommons.org/croissant) and its responsible-AI vocabulary, RAI 1.0.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any, Final

from cadet.formats.kitti.files.folder import suffix_of

CROISSANT: Final = "croissant.json"
"""Its name in a dataset."""
REPOSITORY: Final = "https://github.com/cadet-sim/cadet"
"""Of the program."""
LICENSE: Final = f"{REPOSITORY}/blob/main/docs/data_license.md"
"""Of what it generates."""
_OWN: Final = (
    *("citeAs", "column", "containedIn", "arrayShape", "equivalentProperty", "extract", "field", "fileProperty"),
    *("fileObject", "fileSet", "format", "includes", "isArray", "isLiveDataset", "jsonPath", "key", "md5"),
    *("parentField", "path", "recordSet", "references", "regex", "repeated", "replace", "samplingRate", "separator"),
    *("source", "subField", "transform"),
)
_CONTEXT: Final = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "dct": "http://purl.org/dc/terms/",
    "sc": "https://schema.org/",
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "description": {"@container": "@language"},
    "name": {"@container": "@language"},
    **{name: f"cr:{name}" for name in _OWN},
}
_MIME_TYPES: Final = {"png": "image/png", "txt": "text/plain", "json": "application/json"}
_LABEL_FIELDS: Final = (
    *("type", "truncated", "occluded", "alpha_rad", "left_px", "top_px", "right_px", "bottom_px"),
    *("height_m", "width_m", "length_m", "x_cam_m", "y_cam_m", "z_cam_m", "rotation_y_rad"),
)
ABOUT: Final = {
    "rai:dataCollection": (
        "A simulated car with KITTI's sensors drove through procedurally generated streets; nothing was recorded."
    ),
    "rai:dataCollectionType": "Software Collection",
    "rai:dataAnnotationProtocol": (
        "Labels are computed from the simulated scene: boxes as KITTI's annotators draw them, or exact ones; occlusion "
        "and truncation from the pixels and returns that are seen."
    ),
    "rai:annotationsPerItem": "1",
    "rai:machineAnnotationTools": "cadet",
    "rai:dataUseCases": "For training and testing 3D object detectors, before real frames or together with them.",
    "rai:dataLimitations": (
        "Images look plausible, not photographic; streets are German; what a detector scores here says little of what "
        "it scores on real streets."
    ),
    "rai:dataBiases": (
        "Districts, weathers, and objects appear as often as the policy in manifest.json says: by default about as in "
        "KITTI, so mostly by day and dry."
    ),
    "rai:personalSensitiveInformation": "None: people, vehicles, and license plates are made up.",
}
"""How sets are made, and what they are good for, by the keys of the responsible-AI vocabulary."""


def title_of(head: Mapping[str, Any]) -> str:
    """Return a generated set's name, by what its manifest says besides the hashes of files."""
    return f"cadet-{head['policy']['name']}-{head['seed']}"


def summary_of(head: Mapping[str, Any]) -> str:
    """Tell what a generated set is, by what its manifest says besides the hashes of files."""
    counts = head["counts"]
    drives = "1 drive" if counts["episodes"] == 1 else f"{counts['episodes']} drives"
    return (
        f"{counts['frames']} frames of {drives} through procedurally generated streets: KITTI's "
        f"camera images, LIDAR scans, and 3D labels. Seed {head['seed']}, policy {head['policy']['name']}, "
        f"cadet {head['cadet']}. manifest.json has the SHA-256 of every file."
    )


def croissant(kinds: Iterable[str], head: Mapping[str, Any], manifest_sha256: str) -> bytes:
    """Return a generated folder's description, without a date, which whoever publishes it knows.

    Args:
        kinds: the folders that every frame has a file in.
        head: what `manifest.json` says besides the hashes of files.
        manifest_sha256: its own hash, in hexadecimal digits.
    """
    parts = ("training", "testing") if head["test_fraction"] > 0.0 else ("training",)
    content = {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": ["http://mlcommons.org/croissant/1.1", "http://mlcommons.org/croissant/RAI/1.0"],
        "name": title_of(head),
        "description": summary_of(head),
        "version": head["cadet"],
        "url": REPOSITORY,
        "license": LICENSE,
        "citeAs": f"The cadet authors: cadet {head['cadet']}, {REPOSITORY}",
        **ABOUT,
        "distribution": [
            {
                "@type": "cr:FileObject",
                "@id": "manifest",
                "name": "manifest.json",
                "contentUrl": "manifest.json",
                "encodingFormat": "application/json",
                "sha256": manifest_sha256,
            },
            *(_files(kind, parts) for kind in (*kinds, "meta")),
        ],
        "recordSet": [
            _records("frames", "meta", _FRAME_FIELDS),
            _records("images", "image_2", {"image": ("sc:ImageObject", {"extract": {"fileProperty": "content"}})}),
            _records("labels", "label_2", dict(map(_label_field, range(len(_LABEL_FIELDS)), _LABEL_FIELDS))),
        ],
    }
    return (json.dumps(content, indent=1) + "\n").encode("ascii")


def _files(kind: str, parts: Iterable[str]) -> dict[str, Any]:
    suffix = suffix_of(kind)
    return {
        "@type": "cr:FileSet",
        "@id": kind,
        "name": kind,
        "encodingFormat": _MIME_TYPES.get(suffix.removeprefix("."), "application/octet-stream"),
        "includes": [f"{part}/{kind}/*{suffix}" for part in parts],
    }


def _json_field(name: str) -> dict[str, Any]:
    return {"extract": {"jsonPath": f"$.{name}"}}


_FRAME_FIELDS: Final = {
    "episode": ("sc:Integer", _json_field("episode")),
    "district": ("sc:Text", _json_field("district")),
    "weather": ("sc:Text", _json_field("weather")),
    "ego_speed_mps": ("sc:Float", _json_field("ego_speed_mps")),
}


def _label_field(column: int, name: str) -> tuple[str, tuple[str, dict[str, Any]]]:
    kind = "sc:Text" if name == "type" else "sc:Float"
    return name, (kind, {"extract": {"fileProperty": "lines"}, "transform": {"regex": rf"^(?:\S+ ){{{column}}}(\S+)"}})


def _records(name: str, kind: str, fields: Mapping[str, tuple[str, dict[str, Any]]]) -> dict[str, Any]:
    """Return a record set of one kind of file, whose first field is the frame's number, as in its file's name."""
    frame = ("sc:Text", {"extract": {"fileProperty": "filename"}, "transform": {"regex": r"^(\d+)"}})
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "name": name,
        "field": [
            {
                "@type": "cr:Field",
                "@id": f"{name}/{field}",
                "name": field,
                "dataType": data_type,
                "source": {"fileSet": {"@id": kind}, **source},
            }
            for field, (data_type, source) in {"frame": frame, **fields}.items()
        ],
    }
