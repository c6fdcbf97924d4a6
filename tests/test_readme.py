"""The README leads to every page, and every command says its version."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from cadet import __version__
from cadet.cli import run_cadet, run_cadet_gen

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]


def test_every_page_is_linked_and_every_link_leads_somewhere() -> None:
    links = set(re.findall(r"\]\(([^)#]+)\)", (ROOT / "README.md").read_text()))
    assert {f"docs/{page.name}" for page in (ROOT / "docs").glob("*.md")} <= links
    for link in links:
        assert re.match(r"https?://", link) or (ROOT / link).exists(), link


def test_every_extra_is_used() -> None:
    """An extra for users installs what some file of the package imports."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    code = "\n".join(path.read_text() for path in (ROOT / "python").rglob("*.py"))
    for extra in set(extras) - {"dev"}:
        for requirement in extras[extra]:
            name = re.split(r"[^A-Za-z0-9_-]", requirement)[0].replace("-", "_")
            assert re.search(rf"^ *(?:import|from) {name}\b", code, re.MULTILINE), f"{extra}: {requirement}"


@pytest.mark.parametrize(("run", "name"), [(run_cadet, "cadet"), (run_cadet_gen, "cadet-gen")])
def test_commands_say_their_version(
    run: Callable[[], None], name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [name, "--version"])
    with pytest.raises(SystemExit) as ended:
        run()
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"{name}, version {__version__}\n"
