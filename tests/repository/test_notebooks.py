"""The notebooks of docs/notebooks: stored as Jupyter stores them, without outputs, and run from top to bottom."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "notebooks"
SHOWN = {
    "dataset": ["picture", "picture", "0 findings", "page"],
    "detector": ["picture", "picture", "Detector(", "KITTI AP|R40"],
    "evaluation": ["picture", "KITTI AP|R40", "A is better: AP 3D"],
    "own_sensor": ["picture", "picture", "picture", "with KITTI's rig", "behind: "],
}
"""How lines begin that a notebook prints, or what they contain, each once more for each time it is there."""


def test_each_is_known() -> None:
    assert sorted(SHOWN) == sorted(path.stem for path in FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("name", SHOWN)
def test_a_notebook_is_stored_without_outputs(name: str) -> None:
    text = (FOLDER / f"{name}.ipynb").read_text(encoding="utf-8")
    notebook = json.loads(text)
    assert text == json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", "as Jupyter writes it"
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    cells = notebook["cells"]
    assert [cell["cell_type"] for cell in cells] == ["markdown", "code"] * (len(cells) // 2) and 6 <= len(cells) <= 10
    assert len({cell["id"] for cell in cells}) == len(cells)
    for cell in cells:
        assert re.fullmatch(r"[\w-]{1,64}", cell["id"])
        keys = {"cell_type", "id", "metadata", "source"}
        assert set(cell) == keys | ({"execution_count", "outputs"} if cell["cell_type"] == "code" else set())
        assert not cell["metadata"] and not cell.get("outputs") and cell.get("execution_count") is None


@pytest.mark.parametrize("name", SHOWN)
def test_a_notebook_runs(name: str, tmp_path: Path) -> None:
    if name == "detector":
        pytest.importorskip("torch", reason="needs torch")
    done = subprocess.run(
        [sys.executable, "-W", "error", ROOT / "tests" / "support" / "run_notebook.py", FOLDER / f"{name}.ipynb"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT / "python")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    lines = done.stdout.splitlines()
    for shown in SHOWN[name]:
        assert sum(shown in line for line in lines) >= SHOWN[name].count(shown), f"{shown}: {done.stdout[-3000:]}"
