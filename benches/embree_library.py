"""Embree's C API for a benchmark: the shared library of the embreex wheel, driven by a compiled loop over the rays."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from importlib.metadata import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_SOURCE = Path(__file__).with_name("embree_packets.c")
_TRIANGLES, _INDICES, _VERTICES = 0, 0, 1
_FLOAT3, _UINT3 = 0x9003, 0x5003
_COHERENT = 1 << 16


def _library() -> ctypes.CDLL:
    paths = [file.locate() for file in files("embreex") or () if file.name.startswith("libembree")]
    return ctypes.CDLL(str(paths[0]))


def _compiled() -> ctypes.CDLL:
    with tempfile.TemporaryDirectory() as folder:
        built = Path(folder) / "packets.so"
        subprocess.run(["cc", "-O3", "-march=native", "-shared", "-fPIC", "-o", built, _SOURCE], check=True)
        return ctypes.CDLL(str(built))


class EmbreeLibrary:
    """Triangles in Embree's tree, for one thread.

    Args:
        vertices: (V, 3) float32.
        faces: (F, 3) their numbers.

    Raises:
        RuntimeError: Embree reports an error.
    """

    def __init__(self, vertices: NDArray[np.float32], faces: NDArray[Any]) -> None:
        self._embree, self._loops = _library(), _compiled()
        for name in ("rtcNewDevice", "rtcNewScene", "rtcNewGeometry", "rtcSetNewGeometryBuffer"):
            getattr(self._embree, name).restype = ctypes.c_void_p
        self._device = ctypes.c_void_p(self._embree.rtcNewDevice(b"threads=1,set_affinity=0"))
        self._scene = ctypes.c_void_p(self._embree.rtcNewScene(self._device))
        geometry = ctypes.c_void_p(self._embree.rtcNewGeometry(self._device, _TRIANGLES))
        for kind, layout, values in (
            (_VERTICES, _FLOAT3, np.ascontiguousarray(vertices, np.float32)),
            (_INDICES, _UINT3, np.ascontiguousarray(faces, np.uint32)),
        ):
            stride, count = ctypes.c_size_t(values.strides[0]), ctypes.c_size_t(len(values))
            memory = self._embree.rtcSetNewGeometryBuffer(geometry, kind, 0, layout, stride, count)
            ctypes.memmove(memory, values.ctypes.data, values.nbytes)
        self._embree.rtcCommitGeometry(geometry)
        self._embree.rtcAttachGeometry(self._scene, geometry)
        self._embree.rtcReleaseGeometry(geometry)
        self._embree.rtcCommitScene(self._scene)
        if error := self._embree.rtcGetDeviceError(self._device):
            raise RuntimeError(f"Embree: error {error}")

    def close(self) -> None:
        """Free the tree."""
        self._embree.rtcReleaseScene(self._scene)
        self._embree.rtcReleaseDevice(self._device)

    def trace(
        self, origins: NDArray[np.float32], directions: NDArray[np.float32], *, packets: bool
    ) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """Trace rays (N, 3), one by one or in packets of 16 that Embree is told are coherent.

        Returns:
            (N,) distances, infinite for a miss, and (N,) numbers of the triangles that were hit.
        """
        count = len(origins)
        ranges, primitives = np.empty(count, np.float32), np.empty(count, np.uint32)
        trace = self._loops.trace_packets if packets else self._loops.trace_single
        intersect = self._embree.rtcIntersect16 if packets else self._embree.rtcIntersect1
        arrays = (ctypes.c_void_p(array.ctypes.data) for array in (origins, directions, ranges, primitives))
        flags = _COHERENT if packets else 0
        trace(ctypes.cast(intersect, ctypes.c_void_p), self._scene, flags, ctypes.c_size_t(count), *arrays)
        return ranges, primitives
