"""What a training was made with: versions, and the commit of a working copy."""

from __future__ import annotations

import subprocess
from functools import lru_cache
from pathlib import Path

import torch

from cadet import __version__

_PACKAGE = Path(__file__).parents[1]


def made_with() -> dict[str, str | None]:
    """Return the versions of the package and of PyTorch, and the commit if the package lies in its own working copy."""
    return {"cadet": __version__, "torch": torch.__version__, "commit": commit(_PACKAGE)}


@lru_cache(maxsize=4)
def commit(folder: Path) -> str | None:
    """Return the git commit of a folder, with "+changes" if files there differ from it.

    None where git is missing or does not track the folder's files: an installed package inside somebody else's
    repository is not of that repository's commit.
    """
    if _git(folder, "ls-files", "--error-unmatch", "__init__.py") is None:
        return None
    head = _git(folder, "rev-parse", "HEAD")
    if not head:
        return None
    return head if _git(folder, "status", "--porcelain", "--untracked-files=no", ".") == "" else f"{head}+changes"


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        done = subprocess.run(
            ["git", "-C", str(folder), *arguments], capture_output=True, text=True, timeout=10, check=False
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() if done.returncode == 0 else None
