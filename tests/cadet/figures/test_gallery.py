"""The gallery: whole actors on its pages, and pages of the size that was asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from cadet import CadetError, Frame, Scene
from cadet.cli.tools import cadet as command
from cadet.figures.gallery import pages, tiles, write_gallery
from cadet.figures.gallery.studio import portrait, survey


@pytest.mark.parametrize("kind", ["car", "truck", "pedestrian", "cyclist"])
def test_portraits_show_all_of_an_actor(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    captured: list[Frame] = []
    original = Scene.capture

    def capture(self: Scene, **options: Any) -> Frame:
        frame = original(self, **options)
        captured.append(frame)
        return frame

    for sitter in survey(kind, range(3)):
        for number in range(4):
            with monkeypatch.context() as patch:
                patch.setattr(Scene, "capture", capture)
                picture = portrait(sitter, number)
            instance = captured[-1].instance
            assert instance is not None
            rows, columns = np.nonzero(instance > 0)
            height, width = instance.shape
            assert rows.min() > 0 and rows.max() < height - 1, "cut off above or below"
            assert columns.min() > 0 and columns.max() < width - 1, "cut off at a side"
            assert picture.shape[0] > np.ptp(rows) and picture.shape[1] > np.ptp(columns)


def test_portraits_are_exposed_for_the_actor_not_for_the_sky() -> None:
    for kind in ("pedestrian", "cyclist", "car"):
        lumas = [float(portrait(sitter, number).mean()) for number, sitter in enumerate(survey(kind, range(4)))]
        assert min(lumas) > 45.0, lumas


def test_a_family_is_the_part_of_the_name_that_seeds_share() -> None:
    sitters = list(survey("car", range(12)))
    assert [sitter.model_seed for sitter in sitters] == list(range(12))
    assert len({sitter.family for sitter in sitters}) < 12
    assert all("/" not in sitter.family and 2.0 < sitter.length_m < 6.0 for sitter in sitters)


def test_a_page_has_room_for_every_tile() -> None:
    red = np.full((30, 60, 3), (200, 0, 0), np.uint8)
    page = tiles.page("title", [("a", red)] * 5, across=3, tile_px=(90, 60))
    assert (page == (200, 0, 0)).all(axis=2).sum() == 5 * 90 * 45


def test_pages_are_written_as_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "_PER_FAMILY", 2)
    monkeypatch.setattr(pages, "_PEOPLE", {"pedestrian": 1.3})
    result = CliRunner().invoke(command, ["gallery", str(tmp_path / "sheets"), "--parts", "people"])
    assert result.exit_code == 0, result.output
    (path,) = (tmp_path / "sheets").iterdir()
    assert path.name == "people_pedestrian.jpg"
    assert cv2.imread(str(path)) is not None


def test_wrong_parts_and_files_in_the_way_are_refused(tmp_path: Path) -> None:
    with pytest.raises(CadetError, match="unknown part of the gallery 'cars'; known: vehicles, people"):
        list(write_gallery(tmp_path, ("cars",)))
    (tmp_path / "file").write_text("")
    with pytest.raises(CadetError, match="is not a folder"):
        list(write_gallery(tmp_path / "file"))
    with pytest.raises(CadetError, match="nothing"):
        list(write_gallery(tmp_path / "out", ("people",), real=tmp_path / "nothing"))
    assert not (tmp_path / "out").exists(), "refused before there is work"


def test_every_district_has_streets_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    class Street:
        def __init__(self, seed: int) -> None:
            self.seed = seed

        def capture(self, *, sensors: tuple[str, ...]) -> int:
            return self.seed

    monkeypatch.setattr(Scene, "random", lambda *, seed, policy: Street(seed))
    names = ("quiet", "parked_rows", "motorway")
    by_day = [set(pages._views(name, "clear_noon", 2)) for name in names]
    assert len(set.union(*by_day)) == 2 * len(names)
    assert [set(pages._views(name, "snow", 2)) for name in names] == by_day, "the same streets in every weather"


def test_the_sheets_of_districts_and_lidars_have_a_tile_for_each(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[list[str]] = []

    def page(title: str, shown: list[tuple[str, Any]], **_: object) -> str:
        drawn.append([caption for caption, _ in shown])
        return title

    monkeypatch.setattr(pages, "page", page)
    monkeypatch.setattr(pages, "DISTRICTS", ("quiet", "campus"))
    monkeypatch.setattr(pages, "LIDAR_PRESETS", ("vlp16", "livox_mid40"))
    assert [name for part in ("districts", "lidars") for name, _ in pages.PAGES[part]()] == ["districts", "lidars"]
    districts, lidars = drawn
    assert [caption.split(",")[0] for caption in districts] == ["quiet", "quiet", "campus", "campus"]
    assert len(set(districts)) == 4
    counts = [int(caption.split(", ", 1)[1].removesuffix(" returns").replace(",", "")) for caption in lidars]
    # 28,800 and 10,000 beams at 10 Hz; some meet nothing.
    assert 15_000 < counts[0] < 28_800 and 3_000 < counts[1] < 10_000
