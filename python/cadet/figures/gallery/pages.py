"""The pages of the gallery, each a picture file."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

from cadet._util import style
from cadet.errors import CadetError, MissingFileError
from cadet.figures.gallery.studio import Sitter, portrait, survey
from cadet.figures.gallery.tiles import page
from cadet.figures.picture import write_picture
from cadet.formats.kitti.dataset import Dataset
from cadet.formats.kitti.drawing.bev import bev_figure
from cadet.formats.kitti.drawing.camera import lidar_figure
from cadet.formats.kitti.frame import Frame
from cadet.sensors.lidar import LIDAR_PRESETS, Lidar
from cadet.sensors.rig import Rig
from cadet.simulation.scene import Scene
from cadet.worlds.districts import DISTRICTS
from cadet.worlds.policy import ResetPolicy

Page = tuple[str, style.Image]

_PER_FAMILY: Final = 24
# Rare families would need thousands of seeds: their pages hold what these many seeds give.
_VEHICLES: Final = {"car": 480, "van": 160, "truck": 240, "misc": 160}
_PEOPLE: Final = {"pedestrian": 1.3, "cyclist": 4.5, "person_sitting": None}
_WEATHERS: Final = ("clear_noon", "cloudy_noon", "clear_sunset", "hard_rain_noon", "dusk", "clear_night", "wet_night")
_OTHER_WEATHERS: Final = ("wet_sunset", "hard_rain_noon", "light_fog", "snow", "dusk", "clear_night", "wet_night")
_VIEWS_PER_WEATHER: Final = 2
_PORTRAIT_PX: Final = (300, 200)
_PERSON_PX: Final = (150, 240)
_STREET_PX: Final = (828, 250)
_SMALL_PX: Final = (360, 109)
_LIDAR_PX: Final = 330
_LIDAR_SEED: Final = 1
_SCANS_PER_DISTRICT: Final = 2
_REAL_SCANS: Final = 8


def _vehicles() -> Iterator[Page]:
    """Each family of vehicles: 24 of it from three sides and behind."""
    for kind, num_seeds in _VEHICLES.items():
        families: dict[str, list[Sitter]] = defaultdict(list)
        for sitter in survey(kind, range(num_seeds)):
            families[sitter.family].append(sitter)
        for family, sitters in sorted(families.items()):
            tiles = [
                (f"{kind} {sitter.model_seed}, {sitter.length_m:.1f} m", portrait(sitter, number))
                for number, sitter in enumerate(sitters[:_PER_FAMILY])
            ]
            title = f"{kind}: {family}, {len(sitters)} of {num_seeds} seeds"
            yield f"vehicle_{kind}_{family}", page(title, tiles, across=6, tile_px=_PORTRAIT_PX)


def _people() -> Iterator[Page]:
    """24 people of each kind: half of those who can move do."""
    for kind, speed_mps in _PEOPLE.items():
        tiles = []
        for number, sitter in enumerate(survey(kind, range(_PER_FAMILY))):
            moves = number % 2 == 1
            picture = portrait(sitter, number // 2, speed_mps=speed_mps if moves else None)
            tiles.append((f"{sitter.family} {sitter.model_seed}", picture))
        size_px = _PORTRAIT_PX if kind == "cyclist" else _PERSON_PX
        yield f"people_{kind}", page(kind, tiles, across=6 if kind == "cyclist" else 12, tile_px=size_px)


def _streets() -> Iterator[Page]:
    """Each district in seven weathers, dusk and nights among them."""
    for name in DISTRICTS:
        tiles = []
        for weather in _WEATHERS:
            for frame in _views(name, weather, _VIEWS_PER_WEATHER):
                tiles.append((weather, frame.image))
        yield f"street_{name}", page(f"district {name}", tiles, across=2, tile_px=_STREET_PX)


def _districts() -> Iterator[Page]:
    """One sheet of all districts, a street of each in fair weather and in one that is not."""
    tiles = [
        (f"{name}, {weather}", frame.image)
        for number, name in enumerate(DISTRICTS)
        for weather in ("clear_noon", _OTHER_WEATHERS[number % len(_OTHER_WEATHERS)])
        for frame in _views(name, weather, 1)
    ]
    yield "districts", page("districts", tiles, across=4, tile_px=_SMALL_PX)


def _lidars() -> Iterator[Page]:
    """What each LIDAR of the package sees of one street, from above."""
    policy = ResetPolicy.kitti().with_districts("main_road").with_weathers("cloudy_noon")
    tiles = []
    for name in LIDAR_PRESETS:
        rig = Rig.kitti().with_lidar(Lidar(name))
        frame = Scene.random(seed=_LIDAR_SEED, policy=policy, rig=rig).capture(sensors=())
        figure = bev_figure(replace(frame, labels=()), _LIDAR_PX, has_text=False)
        tiles.append((f"{name}, {len(frame.points_velo):,} returns", figure))
    yield "lidars", page("LIDARs in one street, from above", tiles, across=5, tile_px=(_LIDAR_PX, _LIDAR_PX))


def _scans() -> Iterator[Page]:
    """Scans of each district from above and in the image."""
    tiles = [
        (name, figure)
        for name in DISTRICTS
        for frame in _views(name, "clear_noon", _SCANS_PER_DISTRICT)
        for figure in _scan_figures(frame)
    ]
    yield "scans_generated", page("generated scans", tiles, across=4, tile_px=(620, 400))


def _dataset(root: Path) -> Dataset:
    dataset = Dataset(root)
    if len(dataset) == 0:
        raise CadetError(f"{root}: no frames")
    return dataset


def _real_scans(root: Path) -> Page:
    """Frames of a KITTI folder, drawn as the generated scans are."""
    dataset = _dataset(root)
    num = min(_REAL_SCANS, len(dataset))
    frames = [dataset[index * len(dataset) // num] for index in range(num)]
    tiles = [("", figure) for frame in frames for figure in _scan_figures(frame)]
    return "scans_real", page(f"scans of {root.name}", tiles, across=4, tile_px=(620, 400))


def _scan_figures(frame: Frame) -> tuple[style.Image, style.Image]:
    bare = replace(frame, labels=())
    return lidar_figure(bare), bev_figure(bare, 700, has_text=False)


def _views(district_name: str, weather: str, num: int) -> Iterator[Frame]:
    policy = ResetPolicy.kitti().with_districts(district_name).with_weathers(weather)
    # Streets of its own for each district, the same ones in every weather.
    first = num * list(DISTRICTS).index(district_name)
    for seed in range(first, first + num):
        yield Scene.random(seed=seed, policy=policy).capture(sensors=())


PAGES: Final[dict[str, Callable[[], Iterator[Page]]]] = {
    "vehicles": _vehicles,
    "people": _people,
    "districts": _districts,
    "streets": _streets,
    "lidars": _lidars,
    "scans": _scans,
}
"""The parts of the gallery by name; each yields its pages' names and pictures."""


def write_gallery(out: Path, parts: tuple[str, ...] = (), real: Path | None = None) -> Iterator[Path]:
    """Write the gallery's pages as JPEG files, one after the other.

    Args:
        out: the folder, made where it is not there.
        parts: names of `PAGES`; all of them if empty.
        real: a KITTI folder whose scans get a page beside the generated ones.

    Yields:
        Each file once it is written.

    Raises:
        CadetError: an unknown part, or a KITTI folder that can't be read.
        MissingFileError: a file stands where the folder should.
    """
    for part in parts:
        if part not in PAGES:
            raise CadetError(f"unknown part of the gallery {part!r}; known: {', '.join(PAGES)}")
    if out.exists() and not out.is_dir():
        raise MissingFileError(f"{out}: is not a folder")
    if real is not None:
        _dataset(real)
    out.mkdir(parents=True, exist_ok=True)
    for part in parts or PAGES:
        for name, picture in PAGES[part]():
            yield write_picture(out / f"{name}.jpg", picture)
    if real is not None:
        name, picture = _real_scans(real)
        yield write_picture(out / f"{name}.jpg", picture)
