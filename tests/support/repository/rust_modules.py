"""The files of the core and which uses which, read from the sources without a compiler."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

_WORD = r"[A-Za-z_][A-Za-z0-9_]*"
# `use` declarations and paths in code that begin with a module: crate::a::b, super::c, self::d.
_USE = re.compile(r"(?m)^\s*((?:pub(?:\([^)]*\))?\s+)?)use\s+([^;]+);")
_PATH = re.compile(rf"\b((?:crate|super|self)(?:::{_WORD})+)")
_UNIT_TESTS = re.compile(r"#\[cfg\(test\)\]\s*(?:#\[[^\n]*\]\s*)*(?:pub\S* )?mod \w+ \{")


def code_of(path: Path) -> str:
    """Return a Rust file without comments, strings, unit tests, and how far its items are visible."""
    code = re.sub(r"//[^\n]*", "", path.read_text())
    code = re.sub(r"\bpub\([^)]*\)", "pub", code)
    return _UNIT_TESTS.split(re.sub(r'"(?:[^"\\]|\\.)*"', '""', code))[0]


def _expanded(tree: str) -> Iterator[tuple[str, ...]]:
    """Yield the paths of a use tree: `a::{b, c::{d, e as f}}` to a::b, a::c::d, a::c::e."""
    tree = tree.strip()
    head, brace, rest = tree.partition("{")
    prefix = tuple(part for part in head.strip().split("::") if part)
    if not brace:
        yield tuple(part.split(" as ")[0].strip() for part in prefix)
        return
    depth, start = 0, 0
    inner = rest[: rest.rindex("}")]
    for i, letter in enumerate([*inner, ","]):
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            if inner[start:i].strip():
                for path in _expanded(inner[start:i]):
                    yield (*prefix, *path)
            start = i + 1


class Modules:
    """The module tree of a crate: each module by its path, () for the root.

    Args:
        src: the crate's `src` folder.
    """

    def __init__(self, src: Path) -> None:
        self.files: dict[tuple[str, ...], Path] = {}
        for path in sorted(src.rglob("*.rs")):
            parts = path.relative_to(src).with_suffix("").parts
            if "tests" in parts or path.stem.endswith("_tests") or path.stem == "testing":
                continue
            name: tuple[str, ...] = parts[:-1] if parts[-1] == "mod" else parts
            self.files[() if name == ("lib",) else name] = path
        self._code = {module: code_of(path) for module, path in self.files.items()}
        self._re_exports: dict[tuple[str, ...], dict[str, tuple[str, ...]]] = {m: {} for m in self.files}
        for module, code in self._code.items():
            for _, tree in _USE.findall(code):
                for names in _expanded(tree):
                    self._re_exports[module][names[-1]] = names

    def uses(self, module: tuple[str, ...]) -> set[tuple[str, ...]]:
        """Return the modules whose items a module uses; what a parent only passes on from a child counts for the child.

        A parent's `pub use` of its own descendants is none.
        """
        found = set()
        code = self._code[module]
        paths: list[tuple[str, ...]] = []
        for public, tree in _USE.findall(code):
            for path in _expanded(tree):
                home = self._resolved(module, path)
                if not (public and home is not None and home[: len(module)] == module):
                    paths.append(path)
        rest = _USE.sub("", code)
        paths += [tuple(path.split("::")) for path in _PATH.findall(rest)]
        for path in paths:
            home = self._resolved(module, path)
            if home is not None and home != module:
                found.add(home)
        return found

    def _resolved(self, module: tuple[str, ...], path: tuple[str, ...], depth: int = 0) -> tuple[str, ...] | None:
        """Return the module in which the last name of a path is defined; None outside of the crate."""
        first, here, rest = path[0], module, path[1:]
        if first == "crate":
            here = ()
        elif first == "super":
            here = module[:-1]
            while rest and rest[0] == "super":
                here, rest = here[:-1], rest[1:]
        elif first != "self":
            if (*module, first) not in self.files:
                return None
            here = (*module, first)
        while rest and (*here, rest[0]) in self.files:
            here, rest = (*here, rest[0]), rest[1:]
        if rest and depth < 8 and rest[0] in self._re_exports.get(here, {}):
            return self._resolved(here, self._re_exports[here][rest[0]], depth + 1) or here
        return here
