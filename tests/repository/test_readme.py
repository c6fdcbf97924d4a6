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

ROOT = Path(__file__).parents[2]
FOR_FSSPEC = {"gcsfs", "s3fs"}
MODULES = {"rerun_sdk": "rerun"}
PAGES = sorted(str(page.relative_to(ROOT)) for folder in (ROOT, ROOT / "docs") for page in folder.glob("*.md"))


def test_every_page_is_linked_and_every_link_leads_somewhere() -> None:
    """The site's own first page, docs/index.md, stands in the README's place."""
    links = set(re.findall(r"\]\(([^)#]+)\)", (ROOT / "README.md").read_text()))
    assert {f"docs/{page.name}" for page in (ROOT / "docs").glob("*.md")} - {"docs/index.md"} <= links
    for link in links:
        assert re.match(r"https?://", link) or (ROOT / link).exists(), link


@pytest.mark.parametrize("page", PAGES)
def test_links_of_a_page_lead_somewhere(page: str) -> None:
    text = (ROOT / page).read_text()
    for link in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", text):
        assert re.match(r"https?://", link) or (ROOT / page).parent.joinpath(link).exists(), link


@pytest.mark.parametrize("page", PAGES)
def test_a_page_names_no_source_that_readers_lack(page: str) -> None:
    """A name such as `lidar/response.rs` may leave out the leading folders."""
    sources = [
        f"/{path.relative_to(ROOT)}"
        for folder in ("benches", "crates", "python", "tests")
        for path in (ROOT / folder).rglob("*")
        if path.suffix in (".py", ".rs")
    ]
    for name in re.findall(r"`([\w./]+\.(?:py|rs))`", (ROOT / page).read_text()):
        assert any(source.endswith(f"/{name}") for source in sources), name


def test_every_extra_is_used() -> None:
    """An extra installs what some file of the package imports, fsspec for a URL's protocol, or what makes the site."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    code = "\n".join(path.read_text() for path in (ROOT / "python").rglob("*.py"))
    for extra in set(extras) - {"dev", "docs"}:
        for requirement in extras[extra]:
            name = re.split(r"[^A-Za-z0-9_-]", requirement)[0].replace("-", "_")
            name = MODULES.get(name, name)
            used = rf'^ *(?:import|from) {name}\b|\bload_extra\("{name}"'
            assert name in FOR_FSSPEC or re.search(used, code, re.MULTILINE), f"{extra}: {requirement}"


@pytest.mark.parametrize(("run", "name"), [(run_cadet, "cadet"), (run_cadet_gen, "cadet-gen")])
def test_commands_say_their_version(
    run: Callable[[], None], name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [name, "--version"])
    with pytest.raises(SystemExit) as ended:
        run()
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"{name}, version {__version__}\n"
