"""Who may depend on whom, as ARCHITECTURE.md draws it, read from the sources."""

from __future__ import annotations

import ast
import graphlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from repository.architecture_rooms import CRATES, ROOMS
from repository.rust_modules import Modules, code_of

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python" / "cadet"
DETECTOR = ROOT / "python" / "avod"
CORE = {crate: ROOT / "crates" / f"cadet_{crate}" for crate in CRATES}

# What a package, a folder, and a file may import; tomli is the standard library's tomllib for Python 3.10.
NEEDED = {
    "cadet": {"cadet", "cv2", "numpy", "tomli"},
    "cadet/cli": {"click", "rich"},
    "cadet/figures/recording.py": {"rerun"},
    "cadet/simulation/gym.py": {"gymnasium"},
    "avod": {"avod", "cadet", "click", "cv2", "numpy", "rich", "safetensors", "torch"},
}
# What nothing but the commands imports, as it needs more.
OPTIONAL = ("cadet.figures.recording", "cadet.simulation.gym")

# No source file is longer; the stub of the compiled module, which cannot be split, is none.
MOST_LINES = 400


def imports(path: Path) -> Iterator[str]:
    """Yield the dotted names that a file imports, those for type checkers too."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            assert node.module is not None
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("package", [PACKAGE, DETECTOR])
def test_a_package_imports_what_it_may_need_alone(package: Path) -> None:
    for path in package.rglob("*.py"):
        names = set(imports(path))
        place = path.relative_to(package.parent)
        allowed = set(sys.stdlib_module_names).union(*(NEEDED[at] for at in NEEDED if place.is_relative_to(at)))
        tops = {name.partition(".")[0] for name in names}
        assert tops <= allowed, f"{place} imports {sorted(tops - allowed)}"
        if not place.is_relative_to("cadet/cli"):
            assert not any(f"{name}.".startswith(f"{module}.") for name in names for module in OPTIONAL), place


def circle(uses: dict[str, set[str]]) -> list[str]:
    """Return modules each of which is used by the next, from one of them back to it; empty if there are none."""
    try:
        graphlib.TopologicalSorter(uses).prepare()
    except graphlib.CycleError as error:
        return list(error.args[1])
    return []


def core_uses(modules: Modules) -> dict[str, set[str]]:
    return {"::".join(module): {"::".join(used) for used in modules.uses(module)} for module in modules.files}


@pytest.mark.parametrize("crate", CRATES)
def test_files_of_the_core_use_each_other_in_one_direction(crate: str) -> None:
    assert circle(core_uses(Modules(CORE[crate] / "src"))) == []


@pytest.mark.parametrize("package", [PACKAGE, DETECTOR])
def test_files_of_a_package_use_each_other_in_one_direction(package: Path) -> None:
    paths = {path.relative_to(package.parent).with_suffix(""): path for path in package.rglob("*.py")}
    files = {".".join(module.parts).removesuffix(".__init__"): path for module, path in paths.items()}
    uses: dict[str, set[str]] = {module: set() for module in files}
    for module, path in files.items():
        for name in imports(path):
            while name not in files and name != f"{package.name}._cadet" and "." in name:
                name = name.rpartition(".")[0]
            uses[module] |= {name} - {module}
    assert circle(uses) == []


def test_a_circle_is_found_through_what_a_parent_passes_on(tmp_path: Path) -> None:
    for name, code in {
        "lib.rs": "mod a; mod b; mod c;",
        "a/mod.rs": "mod inner; pub use inner::One; use crate::b::Two;",
        "a/inner.rs": "pub struct One; // use crate::c::Three;",
        "b.rs": "use crate::{a::One, c::{Three as T}}; pub struct Two;",
        "c.rs": "pub struct Three; fn f() { crate::b::Two; }",
    }.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(code.replace("; ", ";\n"))
    modules = Modules(tmp_path)
    assert modules.uses(("b",)) == {("a", "inner"), ("c",)}
    assert circle(core_uses(modules)) in (["b", "c", "b"], ["c", "b", "c"])


@pytest.mark.parametrize("crate", CRATES)
def test_a_crate_depends_only_on_its_neighbors_and_knows_no_python(crate: str) -> None:
    manifest = tomllib.loads((CORE[crate] / "Cargo.toml").read_text())
    needed = set(manifest["dependencies"])
    assert {name.removeprefix("cadet_") for name in needed if name.startswith("cadet_")} == CRATES[crate]
    assert not needed & {"pyo3", "numpy"}


@pytest.mark.parametrize("crate", ROOMS)
def test_a_room_uses_only_its_neighbors(crate: str) -> None:
    name, *path = crate.split("/")
    inside, depth = tuple(path), len(path)
    modules = Modules(CORE[name] / "src")
    used: dict[str, set[str]] = {}
    for module in modules.files:
        if module[:depth] == inside and len(module) > depth:
            uses = {other[depth] for other in modules.uses(module) if other[:depth] == inside and len(other) > depth}
            used.setdefault(module[depth], set()).update(uses - {module[depth]})
    assert set(used) == set(ROOMS[crate])
    assert not {room: rooms - ROOMS[crate][room] for room, rooms in used.items() if rooms - ROOMS[crate][room]}


def test_the_core_prints_nothing_and_has_no_clock() -> None:
    for folder in CORE.values():
        for path in Modules(folder / "src").files.values():
            found = re.findall(r"\b(?:println!|eprintln!|std::time)", code_of(path))
            assert not found, f"{path.relative_to(ROOT)}: {found}"


def test_no_source_file_is_long() -> None:
    folders = (ROOT / name for name in ("benches", "crates", "python", "tests", "tools"))
    files = [path for folder in folders for path in folder.rglob("*") if path.suffix in (".rs", ".py")]
    assert len(files) > 400
    lengths = {str(path.relative_to(ROOT)): len(path.read_text().splitlines()) for path in files}
    assert not {name: length for name, length in lengths.items() if length > MOST_LINES}


def test_docs_of_code_begin_with_what_the_thing_is() -> None:
    begins = re.compile(r'^\s*(?:///|//!|""") ?(?:Who|The same|So far|So much|So many|What is)\b.*', re.MULTILINE)
    files = [*(ROOT / "crates").rglob("*.rs"), *(ROOT / "python").rglob("*.py"), *(ROOT / "tools").rglob("*.py")]
    wrong = {path.relative_to(ROOT).as_posix(): begins.findall(path.read_text()) for path in sorted(files)}
    assert not {path: lines for path, lines in wrong.items() if lines}
