"""Who may depend on whom, as ARCHITECTURE.md draws it, read from the sources."""

from __future__ import annotations

import ast
import graphlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from repository.architecture_rooms import AVOD_ROOMS, CORE_ROOMS, PYTHON_ROOMS, TOWN_ROOMS
from repository.rust_modules import Modules

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python" / "cadet"
DETECTOR = ROOT / "python" / "avod"
CORE = ROOT / "crates" / "cadet_core" / "src"

# Nothing but these may be needed to import the package; click and rich serve cadet.cli alone.
# tomli is the standard library's tomllib for Python 3.10.
NEEDED = {"cadet", "cv2", "numpy", "tomli"}
# What a module of its own needs besides, which nothing else imports.
OPTIONAL = {"simulation/gym.py": {"gymnasium"}, "figures/recording.py": {"rerun"}}


# No source file is longer; the stub of the compiled module, which cannot be split, is none.
MOST_LINES = 400


def python_files(room: str, package: Path = PACKAGE) -> list[Path]:
    folder = package / room
    return sorted(folder.rglob("*.py")) if folder.is_dir() else [package / f"{room}.py"]


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


@pytest.mark.parametrize(("package", "rooms"), [(PACKAGE, PYTHON_ROOMS), (DETECTOR, AVOD_ROOMS)])
def test_the_table_names_every_room(package: Path, rooms: dict[str, set[str]]) -> None:
    entries = {path.stem for path in package.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()}
    assert set(rooms) == entries - {"__init__"}


def test_the_table_names_every_room_of_the_core() -> None:
    assert set(CORE_ROOMS) == {path.stem for path in CORE.iterdir()} - {"lib"}


@pytest.mark.parametrize(
    ("package", "rooms", "room"),
    [(PACKAGE, PYTHON_ROOMS, room) for room in PYTHON_ROOMS] + [(DETECTOR, AVOD_ROOMS, room) for room in AVOD_ROOMS],
)
def test_a_python_room_uses_only_its_neighbors(package: Path, rooms: dict[str, set[str]], room: str) -> None:
    for path in python_files(room, package):
        for name in imports(path):
            top, _, rest = name.partition(".")
            if top == package.name:
                used = rest.split(".")[0]
                assert used in rooms[room] | {room}, f"{path.relative_to(ROOT)} imports {name}"


def test_importing_the_package_needs_numpy_and_opencv_alone() -> None:
    standard = set(sys.stdlib_module_names)
    for path in PACKAGE.rglob("*.py"):
        if path.is_relative_to(PACKAGE / "cli"):
            continue
        tops = {name.partition(".")[0] for name in imports(path)}
        allowed = standard | NEEDED | OPTIONAL.get(path.relative_to(PACKAGE).as_posix(), set())
        assert tops <= allowed, f"{path.relative_to(ROOT)} imports {sorted(tops - allowed)}"
        modules = ["cadet." + name.removesuffix(".py").replace("/", ".") for name in OPTIONAL]
        assert not any(f"{name}.".startswith(f"{module}.") for name in imports(path) for module in modules), path


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


def entries_use(folder: Path, package: Path) -> dict[str, set[str]]:
    """Return which modules and packages of a folder use which others of it."""
    prefix = ".".join(folder.relative_to(package.parent).parts) + "."
    uses: dict[str, set[str]] = {path.stem: set() for path in folder.iterdir() if path.stem != "__init__"}
    for path in folder.rglob("*.py"):
        entry = path.relative_to(folder).parts[0].removesuffix(".py")
        used = {name.removeprefix(prefix).split(".")[0] for name in imports(path) if name.startswith(prefix)}
        if entry != "__init__":
            uses[entry] |= used & set(uses) - {entry}
    return uses


@pytest.mark.parametrize("package", [PACKAGE, DETECTOR])
def test_what_stands_in_a_folder_uses_each_other_in_one_direction(package: Path) -> None:
    folders = sorted(path.parent for path in package.rglob("__init__.py"))
    circles = {
        folder.relative_to(package.parent).as_posix(): circle(entries_use(folder, package)) for folder in folders
    }
    assert not {folder: found for folder, found in circles.items() if found}


def test_a_circle_of_packages_is_found_where_no_files_form_one(tmp_path: Path) -> None:
    for name, code in {
        "p/__init__.py": "",
        "p/a/__init__.py": "",
        "p/a/low.py": "",
        "p/a/high.py": "def f():\n    from p.b import X",
        "p/b.py": "from p.a.low import X",
    }.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(code)
    assert circle(entries_use(tmp_path / "p", tmp_path / "p")) in (["a", "b", "a"], ["b", "a", "b"])
    assert entries_use(tmp_path / "p" / "a", tmp_path / "p") == {"low": set(), "high": set()}


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


def test_no_package_imports_a_tool() -> None:
    for path in (ROOT / "python").rglob("*.py"):
        assert not any(name.partition(".")[0] == "tools" for name in imports(path)), f"{path.relative_to(ROOT)}"


def test_nothing_imports_torch_or_the_detector() -> None:
    for path in PACKAGE.rglob("*.py"):
        tops = {name.partition(".")[0] for name in imports(path)}
        assert not tops & {"torch", "avod"}, f"{path.relative_to(ROOT)}"


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
