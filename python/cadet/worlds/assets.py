"""A user's own meshes, a folder with OBJ or glTF files and an `assets.toml`, and a user's own props."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from cadet import _cadet
from cadet._util.checks import (
    as_pairs,
    as_path,
    as_tuple,
    check_kind,
    check_number,
    check_text,
    is_one_of,
    known_names,
    make_plain,
    shown,
)
from cadet._util.notices import notice
from cadet._util.plain_text import toml_from_text
from cadet._util.summary import counts, summary
from cadet._util.user_files import read_file, read_settings
from cadet.errors import CadetError
from cadet.worlds.meshes import Beside, MeshTriangles, gltf_from_bytes, obj_from_bytes
from cadet.worlds.props import Props

CONFIG = "assets.toml"
"""The file of a folder of assets that lists them."""
CLASSES = ("Car", "Van", "Truck", "Tram", "Misc", "Pedestrian", "Person_sitting", "Cyclist")
"""The classes of a user's meshes; all but the first three are where `Scene.add` puts them and join no traffic."""
ROLES = ("glass", "tyre", "plate", "lamp", "interior")
LEAVE_OUT = "leave_out"
"""Beside the roles: what does not belong to the actor."""
UPS = ("z", "y")
GLTF_SUFFIXES = (".gltf", ".glb")
"""What ends in these is read as glTF 2.0, all else as Wavefront OBJ."""

_REQUIRED = ("name", "class", "mesh")
_OPTIONAL = ("scale", "yaw_deg", "up", "size_lwh", "materials")


@dataclass(frozen=True, kw_only=True)
class ActorMesh:
    """An actor's mesh, held in memory so that a run reads its files once.

    Raises:
        CadetError: a field that makes no sense. The mesh itself is checked by `Assets`.
    """

    name: str
    """The model's name in metadata: letters, digits, `_`, `.` and `-`."""
    type: str
    """KITTI's type: one of `CLASSES`."""
    mesh: MeshTriangles = field(repr=False)
    """Its triangles, as read from a file."""
    file: str = "mesh"
    """The file's name, for messages."""
    scale: float = 1.0
    """Meters per unit of the file."""
    yaw_deg: float = 0.0
    """Turns the mesh about the vertical, counter-clockwise seen from above, so that its front looks along +x."""
    up: str = "z"
    """An OBJ file's axis that points up: one of `UPS`. In glTF y points up and z forward."""
    size_lwh: tuple[float, float, float] | None = None
    """Stretches the mesh to this length, width and height, meters."""
    materials: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """For some of `ROLES`: patterns of the names of their materials, in place of the usual ones. For `LEAVE_OUT`: of
    materials, nodes, objects, or groups."""

    def __post_init__(self) -> None:
        owner = f"actor {shown(self.name)}"
        if not isinstance(self.name, str) or not re.fullmatch(r"[A-Za-z0-9_.-]{1,64}", self.name):
            raise CadetError(f"{owner}.name: expected 1 to 64 letters, digits, '_', '.' or '-'")
        if not is_one_of(self.type, CLASSES):
            raise CadetError(f"{owner}.class: expected one of {', '.join(CLASSES)}, got {shown(self.type)}")
        if not is_one_of(self.up, UPS):
            raise CadetError(f"{owner}.up: expected 'z' or 'y', got {shown(self.up)}")
        check_text(owner, "file", self.file)
        check_kind(owner, "mesh", self.mesh, MeshTriangles)
        check_number(owner, "scale", self.scale, 1e-9, 1e9)
        check_number(owner, "yaw_deg", self.yaw_deg, -360, 360)
        if self.size_lwh is not None:
            if not isinstance(self.size_lwh, tuple) or len(self.size_lwh) != 3:
                raise CadetError(f"{owner}.size_lwh: expected [length, width, height], got {shown(self.size_lwh)}")
            for side in self.size_lwh:
                check_number(owner, "size_lwh", side, 0, 1e3)
        object.__setattr__(self, "materials", as_pairs(owner, "materials", self.materials, "of a role and its names"))
        for role, patterns in self.materials:
            if not is_one_of(role, (*ROLES, LEAVE_OUT)):
                raise CadetError(
                    f"{owner}.materials: unknown key {shown(role)}; {known_names(role, (*ROLES, LEAVE_OUT))}"
                )
            if not isinstance(patterns, tuple) or not all(isinstance(pattern, str) for pattern in patterns):
                raise CadetError(f"{owner}.materials.{role}: expected a list of names, got {shown(patterns)}")
        make_plain(self)

    @property
    def sha256(self) -> str:
        """The hash of all that decides its looks: files and numbers, but not their folder."""
        values = [
            self.name,
            self.type,
            self.mesh.sha256,
            self.scale,
            self.yaw_deg,
            self.up,
            self.size_lwh,
            self.materials,
        ]
        return hashlib.sha256(json.dumps(values).encode()).hexdigest()

    def _to_native(self) -> _cadet.ActorMesh:
        """Return the fields as the core takes them."""
        return _cadet.ActorMesh(
            name=self.name,
            class_name=self.type,
            file=self.file,
            corners=self.mesh.corners,
            material_ids=self.mesh.material_ids,
            part_ids=self.mesh.part_ids,
            source_materials=[(m.name, m.albedo, m.opacity) for m in self.mesh.materials],
            parts=self.mesh.parts,
            scale=self.scale,
            yaw_rad=math.radians(self.yaw_deg),
            y_up=self.up == "y",
            size_lwh=self.size_lwh,
            materials=[(role, patterns) for role, patterns in self.materials if role != LEAVE_OUT],
            leave_out=dict(self.materials).get(LEAVE_OUT),
        )


@dataclass(frozen=True)
class Assets:
    """A user's actors and props. `Assets.read` reads the meshes of actors from a folder, `Props.read` props.

    Args:
        actors: no name twice; at least one if there are no props.
        share: the fraction of driven and parked vehicles that are drawn from them; people and riders are not.
        props: what stands about beside the package's own props.

    Raises:
        CadetError: a mesh that can't be of its class, or a share outside 0 to 1.
    """

    actors: tuple[ActorMesh, ...] = ()
    share: float = 0.5
    props: Props | None = None

    def __repr__(self) -> str:
        types = counts(actor.type for actor in self.actors)
        return summary(self, actors=types, share=self.share, props=self.props)

    def __post_init__(self) -> None:
        check_number("assets", "share", self.share, 0, 1)
        make_plain(self)
        object.__setattr__(self, "actors", as_tuple("assets", "actors", self.actors, "ActorMesh"))
        for actor in self.actors:
            check_kind("assets", "actors", actor, ActorMesh)
        if self.props is not None:
            check_kind("assets", "props", self.props, Props)
        elif not self.actors:
            raise CadetError("assets: expected at least one actor, got none")
        names = [actor.name for actor in self.actors]
        for name in names:
            if names.count(name) > 1:
                raise CadetError(f"assets: two actors are named {name!r}")
        # Bad meshes are refused here rather than in the middle of a run.
        assumed = self._to_native().assumptions()
        notes = [note for actor in self.actors for note in actor.mesh.notes]
        notice([*notes, *assumed], about=tuple(actor.sha256 for actor in self.actors))

    @classmethod
    def read(cls, folder: str | Path, *, skip_bad: bool = False) -> Assets:
        """Read a folder with an `assets.toml`.

        Args:
            folder: the folder.
            skip_bad: leave out actors whose meshes are missing or broken, with a `CadetWarning` for each.

        Raises:
            MissingFileError: there is no `assets.toml`, or a file that it or a mesh names is missing.
            CadetError: anything else that is wrong with them, in one line; with `skip_bad`, no actor that is left.
        """
        root = as_path("assets", folder)
        values = _read_config(root)
        _check_keys(CONFIG, values, required=("actor",), optional=("share",))
        tables = values["actor"]
        if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
            raise CadetError(f"{CONFIG}: actor: expected [[actor]] tables, got {tables!r}")
        share = values.get("share", 0.5)
        actors = []
        for number, table in enumerate(tables, 1):
            try:
                actor = _actor(root, number, table)
                if skip_bad:
                    cls((actor,), share)
            except CadetError as error:
                if not skip_bad:
                    raise
                notice([f"{error}; actor {number} is left out"], about=str(root.resolve()))
                continue
            actors.append(actor)
        if skip_bad and tables and not actors:
            raise CadetError(f"{str(root)!r}: none of its {len(tables)} actors can be used")
        return cls(tuple(actors), share)

    def to_dict(self) -> dict[str, Any]:
        """Return what a manifest says of them: names and hashes, no paths."""
        actors = [{"name": actor.name, "sha256": actor.sha256} for actor in self.actors]
        values: dict[str, Any] = {"share": float(self.share), "actors": actors} if actors else {}
        return values if self.props is None else {**values, "props": self.props.to_list()}

    def _to_native(self) -> _cadet.Assets:
        """Return the core's own; the meshes are built once a process."""
        return _native(self)


@lru_cache(maxsize=4)
def _native(assets: Assets) -> _cadet.Assets:
    files = () if assets.props is None else assets.props.files
    return _cadet.Assets(float(assets.share), [actor._to_native() for actor in assets.actors], files)


def as_assets(assets: Assets | str | Path | None) -> Assets | None:
    """Read a folder; return what has been read already, and None, as they are.

    Raises:
        CadetError: as `Assets.read`, or neither assets nor a path.
    """
    if assets is None or isinstance(assets, Assets):
        return assets
    if not isinstance(assets, (str, Path)):
        raise CadetError(f"assets: expected a folder or cadet.Assets, got {shown(assets)}")
    return Assets.read(assets)


def _read_config(root: Path) -> dict[str, Any]:
    return toml_from_text(read_settings(root / CONFIG, missing=f"{str(root)!r}: no {CONFIG} in it"), CONFIG)


def _check_keys(owner: str, values: Mapping[str, Any], *, required: tuple[str, ...], optional: tuple[str, ...]) -> None:
    for key in required:
        if key not in values:
            raise CadetError(f"{owner}: missing key {key!r}")
    for key in values:
        if key not in (*required, *optional):
            raise CadetError(f"{owner}: unknown key {key!r}; {known_names(key, (*required, *optional))}")


def _actor(root: Path, number: int, table: Mapping[str, Any]) -> ActorMesh:
    owner = f"{CONFIG}: actor {number}"
    _check_keys(owner, table, required=_REQUIRED, optional=_OPTIONAL)
    materials = table.get("materials", {})
    if not isinstance(materials, Mapping):
        raise CadetError(f"{owner}.materials: expected a table, got {materials!r}")
    path = _inside(root, table["mesh"], owner)
    is_gltf = path.suffix.lower() in GLTF_SUFFIXES
    if is_gltf and "up" in table:
        raise CadetError(f"{owner}.up: glTF files say themselves that y points up")
    data = read_file(path, missing=f"{owner}: no mesh {table['mesh']!r}")
    mesh = (gltf_from_bytes if is_gltf else obj_from_bytes)(data, table["mesh"], Beside(root, path))
    try:
        return ActorMesh(
            name=table["name"],
            type=table["class"],
            mesh=mesh,
            file=table["mesh"],
            scale=table.get("scale", 1.0),
            yaw_deg=table.get("yaw_deg", 0.0),
            up=table.get("up", "z"),
            size_lwh=_as_tuple(table.get("size_lwh")),
            materials=tuple((role, _as_tuple(patterns)) for role, patterns in materials.items()),
        )
    except CadetError as error:
        raise CadetError(f"{CONFIG}: {error}") from None


def _as_tuple(values: Any) -> Any:
    return tuple(values) if isinstance(values, list) else values


def _inside(root: Path, name: object, owner: str) -> Path:
    if not isinstance(name, str) or "\0" in name:
        raise CadetError(f"{owner}.mesh: expected the path of an OBJ or glTF file, got {name!r}")
    path = root / name
    try:
        is_inside = path.resolve().is_relative_to(root.resolve())
    except (OSError, RuntimeError):  # links that lead to each other
        is_inside = False
    if not is_inside:
        raise CadetError(f"{owner}.mesh: {name!r} leads out of the folder")
    return path
