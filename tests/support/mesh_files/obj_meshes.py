"""Small meshes and folders of assets, for tests."""

from __future__ import annotations

from pathlib import Path

from cadet.worlds.meshes import Beside, MeshTriangles, obj_from_bytes

Vector = tuple[float, float, float]

MTL = "newmtl Body\nKd 0.1 0.2 0.5\nnewmtl Glass\nKd 0.2 0.2 0.2\nd 0.2\nnewmtl Tyre\nKd 0 0 0\n"


Block = tuple[str, Vector, Vector]


def obj_of(blocks: list[Block]) -> str:
    """Return cuboids, each of a material and two opposite corners."""
    lines = ["mtllib C:\\work\\car.mtl"]
    for number, (material, low, high) in enumerate(blocks):
        for corner in range(8):
            xyz = (high[axis] if corner >> axis & 1 else low[axis] for axis in range(3))
            lines.append("v " + " ".join(f"{value:.3f}" for value in xyz))
        lines.append(f"usemtl {material}")
        for face in ((1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)):
            lines.append("f " + " ".join(str(number * 8 + corner) for corner in face))
    return "\n".join(lines) + "\n"


def car_obj() -> str:
    """Return a car of 4.0 x 1.7 x 1.4 m that looks along +x: a body, a cabin of panes, four wheels."""
    blocks: list[Block] = [
        ("Body", (-2.0, -0.85, 0.2), (2.0, 0.85, 0.8)),
        ("Glass", (-1.6, -0.7, 0.8), (0.8, 0.7, 1.4)),
    ]
    blocks += [("Tyre", (x - 0.3, y - 0.1, 0.0), (x + 0.3, y + 0.1, 0.6)) for x in (-1.2, 1.3) for y in (-0.7, 0.7)]
    return obj_of(blocks)


def car_mesh() -> MeshTriangles:
    """Return the car, read without its library."""
    return obj_from_bytes(car_obj().encode(), "car.obj", Beside(Path(__file__).parent, Path(__file__)))


def wall_obj() -> str:
    """Return an opaque wall of 28 x 0.4 x 4 m along x."""
    return obj_of([("Body", (-14.0, -0.2, 0.0), (14.0, 0.2, 4.0))])


CAR = '[[actor]]\nname = "mine"\nclass = "Car"\nmesh = "meshes/car.obj"\n'
WALL = '[[actor]]\nname = "wall"\nclass = "Truck"\nmesh = "meshes/wall.obj"\nmaterials.glass = []\n'


def assets_folder(root: Path, toml: str = CAR) -> Path:
    """Write a folder with the car and the wall in it and an `assets.toml`."""
    (root / "meshes").mkdir(parents=True)
    (root / "meshes" / "car.obj").write_text(car_obj())
    (root / "meshes" / "wall.obj").write_text(wall_obj())
    (root / "meshes" / "car.mtl").write_text(MTL)
    (root / "assets.toml").write_text(toml)
    return root
