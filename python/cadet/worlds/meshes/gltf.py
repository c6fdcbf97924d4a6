"""Triangles of glTF 2.0 files: scenes, nodes, meshes at rest (Khronos Group, glTF 2.0 Specification, 2021)."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet.errors import FileFormatError
from cadet.worlds.meshes.beside import Beside
from cadet.worlds.meshes.coloring import Batch, Look, materials_of
from cadet.worlds.meshes.gltf_accessors import Accessors
from cadet.worlds.meshes.gltf_container import Container
from cadet.worlds.meshes.gltf_extensions import COMPRESSED, DRACO, VISIBILITY, check_extensions
from cadet.worlds.meshes.gltf_materials import Materials
from cadet.worlds.meshes.gltf_tables import Table
from cadet.worlds.meshes.triangles import MAX_TRIANGLES, MeshTriangles

# Nodes within nodes: deeper ones go around in a circle.
_MAX_DEPTH: Final = 256
# Nodes of a scene, those met several times included.
_MAX_NODES: Final = 100_000
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_POSITIONS: Final = ("VEC3",)
Array = NDArray[np.float64]


def gltf_from_bytes(document: bytes, file: str, beside: Beside) -> MeshTriangles:
    """Read the default scene of a glTF file, or the first, or all nodes; skins and morph targets as they rest.

    Args:
        document: the file's bytes, JSON or a binary container.
        file: its name, for messages.
        beside: the files beside it.

    Raises:
        FileFormatError: what is wrong, and where in the JSON.
        MissingFileError: a buffer that is not there.
        CadetError: a path out of the folder.
    """
    container = Container(document, file, beside)
    notes = check_extensions(container.root)
    scene = _Scene(container)
    with np.errstate(over="ignore", invalid="ignore"):
        for root in scene.roots():
            scene.place(root, np.eye(4), (), 0)
        for node, names in scene.meshes:
            scene.read_mesh(container.items("nodes")[node], scene.worlds[node], names)
    if not scene.batches:
        raise FileFormatError("no triangles in its scene", file)
    notes += scene.notes()
    ids, materials = materials_of(scene.batches)
    corners = np.concatenate([batch.corners for batch in scene.batches])
    # glTF: y up, z forward, x to the left.
    return MeshTriangles(
        sha256=beside.sha256(document),
        corners=corners[..., [2, 0, 1]].reshape(-1, 9).astype(np.float32),
        material_ids=np.concatenate(ids),
        part_ids=np.concatenate([batch.part_ids for batch in scene.batches]),
        materials=materials,
        parts=tuple(scene.parts),
        notes=tuple(dict.fromkeys(notes)),
    )


class _Scene:
    def __init__(self, container: Container) -> None:
        self._container = container
        self._accessors = Accessors(container)
        self._materials = Materials(container)
        self._num_nodes = self._num_triangles = 0
        self.worlds: dict[int, Array] = {}
        self.meshes: list[tuple[int, tuple[str, ...]]] = []
        self.parts: dict[tuple[str, ...], int] = {}
        self.batches: list[Batch] = []

    def notes(self) -> list[str]:
        """Return what was not read of the materials met so far."""
        return self._materials.notes()

    def roots(self) -> list[int]:
        """Return the nodes at the top of the scene; of a file without scenes those that are no other's child."""
        root, scenes = self._container.root, self._container.items("scenes")
        num_nodes = len(self._container.items("nodes"))
        if scenes:
            return scenes[root.whole("scene", 0, below=len(scenes))].indices("nodes", num_nodes)
        children = {child for node in self._container.items("nodes") for child in node.indices("children", num_nodes)}
        return [node for node in range(num_nodes) if node not in children]

    def place(self, number: int, world_from_parent: Array, outer: tuple[str, ...], depth: int) -> None:
        """Note where a node and all within it stand, and which of them show a mesh."""
        node = self._container.items("nodes")[number]
        self._num_nodes += 1
        if depth > _MAX_DEPTH or self._num_nodes > _MAX_NODES:
            raise FileFormatError(
                f"{node.where}: more than {_MAX_DEPTH} nodes within each other or {_MAX_NODES} in all", node.file
            )
        visibility = node.extension(VISIBILITY)
        if visibility is not None and not visibility.flag("visible", default=True):
            return
        world = _product(world_from_parent, _local(node))
        names = (*outer, node.text("name"))
        self.worlds[number] = world
        if "mesh" in node:
            self.meshes.append((number, names))
        for child in node.indices("children", len(self._container.items("nodes"))):
            self.place(child, world, names, depth + 1)

    def read_mesh(self, node: Table, world_from_node: Array, names: tuple[str, ...]) -> None:
        """Add the triangles of a node's mesh."""
        mesh = self._container.item(node, "mesh", "meshes")
        names = tuple(dict.fromkeys(name for name in (*names, mesh.text("name")) if name)) or ("",)
        part = self.parts.setdefault(names, len(self.parts))
        weights = node.weights("weights") or mesh.weights("weights") or []
        for primitive in mesh.tables("primitives"):
            if primitive.whole("mode", _TRIANGLES) not in (_TRIANGLES, _STRIP, _FAN):
                continue
            self._read_primitive(primitive, node, world_from_node, part, weights)

    def _read_primitive(
        self, primitive: Table, node: Table, world_from_node: Array, part: int, weights: list[float]
    ) -> None:
        attributes = primitive.table("attributes")
        self._check_draco(primitive, attributes)
        if "POSITION" not in attributes:
            return
        positions = self._positions(primitive, attributes, weights)
        faces = self._faces(primitive, len(positions))
        self._num_triangles += len(faces)
        if self._num_triangles > MAX_TRIANGLES:
            raise FileFormatError(f"more than {MAX_TRIANGLES} triangles: simplify the mesh", primitive.file)
        if not len(faces):
            return
        matrices = self._skin(node, attributes, len(positions))
        placed = _transformed(world_from_node if matrices is None else matrices, positions)
        if not np.isfinite(placed[faces]).all():
            raise FileFormatError(f"{primitive.where}: a coordinate is not finite", primitive.file)
        if matrices is None and np.linalg.det(world_from_node[:3, :3]) < 0.0:
            faces = faces[:, [0, 2, 1]]
        look = Look()
        if "material" in primitive:
            look = self._materials.look(primitive.whole("material", below=len(self._container.items("materials"))))
        uv = colors = None
        if look.picture is not None and f"TEXCOORD_{look.uv_set}" in attributes:
            uv = self._of_corners(attributes, f"TEXCOORD_{look.uv_set}", ("VEC2",), positions)[faces]
        if "COLOR_0" in attributes:
            colors = self._of_corners(attributes, "COLOR_0", ("VEC3", "VEC4"), positions)[faces]
            if colors.shape[2] == 3:
                colors = np.concatenate([colors, np.ones((*colors.shape[:2], 1))], axis=2)
        part_ids = np.full(len(faces), part, np.uint32)
        self.batches.append(Batch(look, placed[faces], part_ids, uv, colors))

    def _positions(self, primitive: Table, attributes: Table, weights: list[float]) -> Array:
        """Return (n, 3) the corners, morphed as they rest."""
        positions = self._accessors.floats(attributes, "POSITION", _POSITIONS)
        for weight, target in zip(weights, primitive.tables("targets"), strict=False):
            if weight and "POSITION" in target:
                moved = self._accessors.floats(target, "POSITION", _POSITIONS)
                if len(moved) != len(positions):
                    raise FileFormatError(f"{target.where}: {len(moved)} corners of {len(positions)}", target.file)
                positions = positions + weight * moved
        return positions

    def _check_draco(self, primitive: Table, attributes: Table) -> None:
        if primitive.extension(DRACO) is not None and "POSITION" in attributes:
            accessor = self._container.item(attributes, "POSITION", "accessors")
            if "bufferView" not in accessor:
                raise FileFormatError(f"{primitive.where}: {DRACO} is not read: {COMPRESSED[DRACO]}", primitive.file)

    def _of_corners(self, attributes: Table, key: str, kinds: tuple[str, ...], positions: Array) -> Array:
        values = self._accessors.floats(attributes, key, kinds)
        if len(values) < len(positions):
            raise FileFormatError(
                f"{attributes.where}.{key}: {len(values)} values for {len(positions)} corners", attributes.file
            )
        return values

    def _faces(self, primitive: Table, num_corners: int) -> NDArray[np.int64]:
        """Return (n, 3) corners of each triangle; in strips every other one is turned (specification, 3.7.2.1)."""
        if "indices" in primitive:
            indices = self._accessors.wholes(primitive, "indices")[:, 0]
        else:
            indices = np.arange(num_corners)
        if len(indices) and indices.max() >= num_corners:
            raise FileFormatError(
                f"{primitive.where}: a face names corner {indices.max()} of {num_corners}", primitive.file
            )
        mode = primitive.whole("mode", _TRIANGLES)
        if mode == _TRIANGLES:
            return indices[: len(indices) // 3 * 3].reshape(-1, 3)
        if len(indices) < 3:
            return np.empty((0, 3), np.int64)
        if mode == _FAN:
            return np.column_stack([np.full(len(indices) - 2, indices[0]), indices[1:-1], indices[2:]])
        strip = np.column_stack([indices[:-2], indices[1:-1], indices[2:]])
        strip[1::2] = strip[1::2][:, [0, 2, 1]]
        return strip

    def _skin(self, node: Table, attributes: Table, num_corners: int) -> Array | None:
        """Return (n, 4, 4) where each corner's joints carry it as they rest (specification, 3.7.3.3); None without."""
        if "skin" not in node or not {"JOINTS_0", "WEIGHTS_0"} <= {
            k for k in ("JOINTS_0", "WEIGHTS_0") if k in attributes
        }:
            return None
        skin = self._container.item(node, "skin", "skins")
        joints = skin.indices("joints", len(self._container.items("nodes")))
        if not all(joint in self.worlds for joint in joints):
            return None
        matrices: Array = np.array([self.worlds[joint] for joint in joints]).reshape(-1, 4, 4)
        if "inverseBindMatrices" in skin:
            inverse = (
                self._accessors.floats(skin, "inverseBindMatrices", ("MAT4",)).reshape(-1, 4, 4).transpose(0, 2, 1)
            )
            if len(inverse) < len(joints):
                raise FileFormatError(f"{skin.where}: {len(inverse)} matrices of {len(joints)} joints", skin.file)
            matrices = _product(matrices, inverse[: len(joints)])
        ids = self._accessors.wholes(attributes, "JOINTS_0", ("VEC4",))
        weights = self._accessors.floats(attributes, "WEIGHTS_0", ("VEC4",))
        if min(len(ids), len(weights)) < num_corners or (ids.size and ids.max() >= len(joints)):
            raise FileFormatError(f"{attributes.where}: joints that the skin has not", attributes.file)
        weights = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-9)
        carried = np.zeros((len(ids), 4, 4))
        for number in range(4):
            carried += weights[:, number, None, None] * matrices[ids[:, number]]
        return carried[:num_corners]


def _local(node: Table) -> Array:
    """Return a node's transform, (4, 4)."""
    if "matrix" in node:
        identity = tuple(np.eye(4).flatten().tolist())
        return np.array(node.numbers("matrix", identity)).reshape(4, 4).T
    x, y, z, w = node.numbers("rotation", (0.0, 0.0, 0.0, 1.0))
    length = float(np.sqrt(x * x + y * y + z * z + w * w)) or 1.0
    x, y, z, w = x / length, y / length, z / length, w / length
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    local = np.eye(4)
    local[:3, :3] = np.array(turn) * node.numbers("scale", (1.0, 1.0, 1.0))
    local[:3, 3] = node.numbers("translation", (0.0, 0.0, 0.0))
    return local


def _product(a: Array, b: Array) -> Array:
    """Multiply (..., 4, 4) matrices, with the same last bit on every machine."""
    products: Any = a[..., :, 0, None] * b[..., None, 0, :]
    for k in range(1, 4):
        products = products + a[..., :, k, None] * b[..., None, k, :]
    return np.asarray(products)


def _transformed(matrix: Array, points: Array) -> Array:
    x, y, z = points.T
    rows = [matrix[..., i, 0] * x + matrix[..., i, 1] * y + matrix[..., i, 2] * z + matrix[..., i, 3] for i in range(3)]
    return np.stack(rows, axis=1)
