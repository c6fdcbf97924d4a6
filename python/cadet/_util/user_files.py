"""Files that users hand in and get: read without waiting for a pipe, and named in every error."""

from __future__ import annotations

import contextlib
import errno
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from cadet.errors import CadetError, FileFormatError, MissingFileError

MAX_SETTINGS_BYTES: Final = 1 << 24
"""Of a file of settings: 16 MiB. What is larger was meant for something else."""

_NO_FILE: Final = (errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG, errno.ELOOP)


def read_file(
    path: Path, *, name: str | None = None, missing: str | None = None, max_bytes: int | None = None
) -> bytes:
    """Return a file's bytes.

    Args:
        path: the file.
        name: its name for messages; None for the path.
        missing: what to say where there is no such file, or a folder or pipe; None for just that.
        max_bytes: refuse a larger one before it is read; None for any size.

    Raises:
        MissingFileError: there is no such file.
        FileFormatError: a folder, pipe or device, where `missing` is None, or a file larger than `max_bytes`.
        OSError: it can't be read.
    """
    name = str(path) if name is None else name
    try:
        found = path.stat()
        # Opening a pipe would wait for its writer.
        if not stat.S_ISREG(found.st_mode):
            if missing is not None:
                raise MissingFileError(f"{missing}, got {_kind(found.st_mode)}")
            raise FileFormatError(f"expected a regular file, got {_kind(found.st_mode)}", name)
        if max_bytes is not None and found.st_size > max_bytes:
            raise FileFormatError(f"{found.st_size} bytes, at most {max_bytes} are read", name)
        with names_file(path):
            return path.read_bytes()
    except (OSError, UnicodeEncodeError) as error:
        # No file has a name that is too long, or that the system can't spell.
        if isinstance(error, OSError) and error.errno not in _NO_FILE:
            raise
        raise MissingFileError(f"{name}: no such file" if missing is None else missing) from None


def read_settings(path: Path, *, name: str | None = None, missing: str | None = None) -> bytes:
    """Return the bytes of a file of settings, such as TOML: `read_file` of at most `MAX_SETTINGS_BYTES`."""
    return read_file(path, name=name, missing=missing, max_bytes=MAX_SETTINGS_BYTES)


def check_out_path(path: str | Path, suffixes: Iterable[str]) -> Path:
    """Return where a file is to be written, refused before there is anything to write.

    Raises:
        CadetError: a name that ends in none of the suffixes, or that is a folder's.
        MissingFileError: the folder is not there.
    """
    path = Path(path)
    if path.suffix.lower() not in suffixes:
        raise CadetError(f"{path}: expected a name that ends in {', '.join(suffixes)}")
    if path.is_dir():
        raise CadetError(f"{path}: is a folder")
    if not path.parent.is_dir():
        raise MissingFileError(f"{path}: no such folder: {path.parent}")
    return path


@contextlib.contextmanager
def names_file(path: Path) -> Iterator[None]:
    """Name a file in the system's errors meanwhile: those of reading and writing name none."""
    try:
        yield
    except OSError as error:
        if error.errno is None or error.filename is not None:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from None


def _kind(mode: int) -> str:
    kinds = ((stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))
    return next((kind for is_kind, kind in kinds if is_kind(mode)), "a device")
