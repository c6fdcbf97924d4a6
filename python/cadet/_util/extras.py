"""Libraries that come with an extra of the package, imported when they are first needed."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any, Final

from cadet.errors import CadetError


@dataclass(frozen=True)
class Extra:
    """An extra of the package `cadet-sim`, as pyproject.toml names it."""

    purpose: str
    """What it is for."""
    modules: tuple[str, ...]
    """The modules that it brings."""


EXTRAS: Final = {
    "avod": Extra("train detectors, and detect", ("torch", "safetensors")),
    "onnx": Extra("export detectors", ("onnx", "onnxscript")),
    "gym": Extra("Gymnasium environment", ("gymnasium",)),
    "view": Extra("episodes in Rerun", ("rerun",)),
    "mcap": Extra("ROS 2 bags", ("mcap", "rosbags")),
    "parquet": Extra("Parquet files", ("pyarrow",)),
    "remote": Extra("object stores", ("fsspec", "gcsfs", "s3fs")),
    "cluster": Extra("a Ray cluster", ("ray",)),
}
"""The extras for users, by name."""


def load_extra(module: str, extra: str, purpose: str) -> Any:
    """Import a library that not everyone has.

    Args:
        module: its dotted name.
        extra: the extra of `cadet-sim` that brings it.
        purpose: what needs it, for the message.

    Raises:
        CadetError: it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        missing = error.name or module
        raise CadetError(f"{purpose} needs {missing}: pip install 'cadet-sim[{extra}]'") from None
