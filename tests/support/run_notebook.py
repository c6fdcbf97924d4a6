"""Runs a notebook's code from top to bottom, and shows what a cell's last line gives, without Jupyter.

`python run_notebook.py FILE` prints a line for each thing that is shown: `picture`, `page`, or its `repr`.
"""

from __future__ import annotations

import ast
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any


class Image:
    """Stands in for IPython's: a picture of a file, or of a file's bytes."""

    def __init__(self, data: bytes | None = None, *, filename: str = "") -> None:
        self._png = Path(filename).read_bytes() if data is None else data

    def _repr_png_(self) -> bytes:
        return self._png


class IFrame:
    """Stands in for IPython's: a page of a file."""

    def __init__(self, src: str | Path, width: str | int, height: str | int) -> None:
        self.page = Path(src).read_text(encoding="utf-8")


def display(*values: object) -> None:
    """Show values, as the kernel would."""
    for value in values:
        if hasattr(value, "_repr_png_"):
            assert value._repr_png_().startswith(b"\x89PNG")
            sys.stdout.write("picture\n")
        else:
            sys.stdout.write("page\n" if isinstance(value, IFrame) else f"{value!r}\n")


def run(path: Path) -> None:
    """Run the cells of a notebook, which share their names."""
    kernel = ModuleType("IPython.display")
    kernel.__dict__.update(Image=Image, IFrame=IFrame, display=display)
    sys.modules |= {"IPython": ModuleType("IPython"), "IPython.display": kernel}
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(json.loads(path.read_text(encoding="utf-8"))["cells"]):
        if cell["cell_type"] != "code":
            continue
        file = f"{path.name}, cell {number}"
        code = ast.parse("".join(cell["source"]), file)
        last = code.body.pop() if isinstance(code.body[-1], ast.Expr) else None
        exec(compile(code, file, "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), file, "eval"), names)
            if value is not None:
                display(value)


if __name__ == "__main__":
    run(Path(sys.argv[1]))
