"""A folder that another version began is not gone on with: the same settings may mean other bytes there."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cadet import CadetError, __version__
from cadet.generate import Settings
from cadet.generate.folder import open_folder
from cadet.generate.golden_frames import generator
from cadet.generate.settings import FORMAT_VERSION


@pytest.mark.parametrize(
    ("change", "old"),
    [
        ({"cadet": "0.0.9"}, f"cadet 0.0.9, format {FORMAT_VERSION}, generator {generator()}"),
        ({"format": FORMAT_VERSION - 1}, f"cadet {__version__}, format {FORMAT_VERSION - 1}, generator {generator()}"),
        ({"cadet": None}, f"cadet None, format {FORMAT_VERSION}, generator {generator()}"),
        ({"generator": "0123456789ab"}, f"cadet {__version__}, format {FORMAT_VERSION}, generator 0123456789ab"),
    ],
)
def test_a_run_of_another_version_is_not_gone_on_with(tmp_path: Path, change: dict[str, object], old: str) -> None:
    out = tmp_path / "out"
    settings = Settings(policy="kitti", num_frames=2)  # type: ignore[arg-type]
    with open_folder(out, settings, resume=False):
        pass
    begun = json.loads((out / "run.json").read_bytes())
    (out / "run.json").write_text(json.dumps({**begun, **change, "seed": 5}))
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    with pytest.raises(CadetError) as caught, open_folder(out, settings, resume=True):
        pass
    new = f"cadet {__version__}, format {FORMAT_VERSION}, generator {generator()}"
    assert str(caught.value).startswith(f"{out} was begun by another version ({old}), this is {new}: go on with")
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
