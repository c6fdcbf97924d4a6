"""Who may depend on whom, as ARCHITECTURE.md draws it, read from the sources."""

from __future__ import annotations

import ast
import graphlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from repository.architecture_rooms import CORE_ROOMS, TOWN_ROOMS
from repository.rust_modules import Modules

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python" / "cadet"
DETECTOR = ROOT / "python" / "avod"
CORE = ROOT / "crates" / "cadet_core" / "src"

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


def rust_code(path: Path) -> str:
    """Return a Rust file without comments and unit tests."""
    code = re.sub(r"//[^\n]*", "", path.read_text())
    return re.split(r"#\[cfg\(test\)\]\s*(?:#\[[^\n]*\]\s*)*(?:pub\S* )?mod \w+ \{", code)[0]


def core_files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*.rs") if "tests" not in (path.stem, path.parent.name))


def uses(path: Path) -> set[str]:
    """Return the first names after `crate::` in a Rust file."""
    code = rust_code(path)
    found = set(re.findall(r"\bcrate::(\w+)", code))
    for group in re.findall(r"\buse crate::\{(.*?)\};", code, re.DOTALL):
        found |= set(re.findall(r"(?:^|,)\s*(\w+)", re.sub(r"\{[^{}]*\}", "", group)))
    return found


def test_the_table_names_every_room_of_the_core() -> None:
    assert set(CORE_ROOMS) == {path.stem for path in CORE.iterdir()} - {"lib"}


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


def test_files_of_the_core_use_each_other_in_one_direction() -> None:
    assert circle(core_uses(Modules(CORE))) == []


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


@pytest.mark.parametrize("room", CORE_ROOMS)
def test_a_core_room_uses_only_its_neighbors(room: str) -> None:
    files = [path for path in (*core_files(CORE / room), CORE / f"{room}.rs") if path.is_file()]
    for path in files:
        known = {name for name in uses(path) if (CORE / name).is_dir() or (CORE / f"{name}.rs").is_file()}
        assert known <= CORE_ROOMS[room] | {room}, f"{path.relative_to(ROOT)} uses {sorted(known - CORE_ROOMS[room])}"


def test_a_room_of_the_town_uses_only_its_neighbors() -> None:
    modules = Modules(CORE)
    used: dict[str, set[str]] = {}
    for module in modules.files:
        if len(module) > 1 and module[0] == "town":
            others = {other[1] for other in modules.uses(module) if len(other) > 1 and other[0] == "town"}
            used.setdefault(module[1], set()).update(others - {module[1]})
    assert set(used) == set(TOWN_ROOMS)
    assert not {room: rooms - TOWN_ROOMS[room] for room, rooms in used.items() if rooms - TOWN_ROOMS[room]}


def test_the_core_knows_no_python_and_prints_nothing() -> None:
    manifest = (ROOT / "crates" / "cadet_core" / "Cargo.toml").read_text()
    assert not re.search(r"^(pyo3|numpy)\b", manifest, re.MULTILINE)
    for path in core_files(CORE):
        found = re.findall(r"\b(?:pyo3|println!|eprintln!|std::time)", rust_code(path))
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
