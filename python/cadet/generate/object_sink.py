"""Datasets in object stores, by way of fsspec: `s3://bucket/set`, `gs://bucket/set`."""

from __future__ import annotations

import contextlib
import errno
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

from cadet._util.checks import as_path, shown
from cadet._util.extras import load_extra
from cadet._util.sink import LocalSink, Sink
from cadet.errors import CadetError

STORES: Final = ("s3", "s3a", "gs", "gcs", "az", "abfs", "abfss")
"""Protocols whose stores show an object when all of it has arrived, and not before."""
_URL: Final = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*)://(.*)", re.DOTALL)
_Result = TypeVar("_Result")


def is_url(root: object) -> bool:
    """Tell whether text names a store rather than a folder."""
    return isinstance(root, str) and _URL.fullmatch(root) is not None


def open_sink(root: str | Path) -> Sink:
    """Return the sink of a dataset's folder or URL.

    Raises:
        CadetError: no path, no URL of a store that whole objects can be put into, or its library is not installed.
    """
    match = _URL.fullmatch(root) if isinstance(root, str) else None
    if match is None:
        return LocalSink(as_path("root", root))
    protocol, rest = match[1].lower(), match[2]
    if protocol == "file":
        if not rest.startswith("/"):
            raise CadetError(f"{shown(root)}: expected file:///FOLDER, from the topmost folder on")
        return LocalSink(as_path("root", rest))
    if not rest.strip("/"):
        raise CadetError(f"{shown(root)}: expected a bucket and a name in it, such as s3://bucket/set")
    if protocol not in STORES:
        raise CadetError(
            f"{shown(root)}: a write that is cut short could leave part of a file at {protocol}://; "
            f"expected a folder, or one of {', '.join(f'{name}://' for name in ('file', *STORES))}"
        )
    return ObjectSink(f"{protocol}://{rest}")


class ObjectSink:
    """The objects below a URL of a store that puts whole objects or nothing; see `Sink`.

    Credentials and endpoints are the libraries' own: environment variables, their files, and fsspec's configuration.

    Args:
        url: where to; names are appended after a slash.

    Raises:
        CadetError: the store's library is not installed.
    """

    def __init__(self, url: str) -> None:
        self.location = url.rstrip("/")
        fsspec = load_extra("fsspec", "remote", self.location)
        try:
            # Listings must show what others have put meanwhile.
            self._store, self._root = fsspec.core.url_to_fs(self.location, use_listings_cache=False)
        except ImportError as error:
            raise CadetError(f"{self.location}: {error}; s3 and gs come with 'cadet-sim[remote]'") from None

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Hold nothing: object stores have no locks.

        Writers with other settings are kept out by `put_new` of what a run begins with; those with the same settings
        put the same bytes.
        """
        yield

    def put(self, name: str, data: bytes | Iterable[bytes]) -> None:
        """Store an object; chunks are gathered in a temporary file first.

        Raises:
            OSError: it names the object, and nothing of it is left.
        """
        if isinstance(data, bytes):
            self._call(name, self._store.pipe_file, self._path(name), data)
            return
        with tempfile.NamedTemporaryFile() as file:
            for chunk in data:
                file.write(chunk)
            file.flush()
            self._call(name, self._store.put_file, file.name, self._path(name))

    def put_new(self, name: str, data: bytes) -> None:
        """Store an object that is not there yet; the store itself sees to it that only one of two writers can.

        Raises:
            FileExistsError: it is there.
            OSError: as for `put`.
        """
        self._call(name, self._store.pipe_file, self._path(name), data, mode="create")

    def put_all(self, objects: Mapping[str, bytes]) -> None:
        """Store several objects at the same time.

        Raises:
            OSError: as for `put`.
        """
        if objects:
            self._call(
                next(iter(objects)), self._store.pipe, {self._path(name): data for name, data in objects.items()}
            )

    def read(self, name: str) -> bytes:
        """Return an object's bytes.

        Raises:
            FileNotFoundError: there is none of that name.
        """
        return self.read_all([name])[0]

    def read_all(self, names: Sequence[str]) -> list[bytes]:
        """Return the bytes of several objects, read at the same time.

        Raises:
            FileNotFoundError: one is not there.
        """
        paths = {name: self._path(name) for name in names}
        if not paths:
            return []
        found: dict[str, bytes | Exception]
        found = self._call("", self._store.cat, list(paths.values()), recursive=False, on_error="return")
        return [self._bytes(name, found[path]) for name, path in paths.items()]

    def names(self, folder: str) -> list[str]:
        """Return the names of what lies in a folder, sorted; none if no object's name begins so."""
        path = self._path(folder) if folder else self._root
        try:
            found: list[str] = self._call(folder, self._store.ls, path, detail=False)
        except FileNotFoundError:
            return []
        return sorted({name.rstrip("/").rpartition("/")[2] for name in found if name.rstrip("/") != path.rstrip("/")})

    def make_folder(self, name: str) -> None:
        """Do nothing: there are no folders."""

    def remove_partial(self) -> None:
        """Do nothing: what was not put to its end never shows, and stores can be told to drop it after a time."""

    def _path(self, name: str) -> str:
        return f"{self._root}/{name}"

    def _bytes(self, name: str, data: bytes | Exception) -> bytes:
        if isinstance(data, Exception):
            raise self._named(name, data)
        return data

    def _call(self, name: str, function: Callable[..., _Result], *arguments: Any, **options: Any) -> _Result:
        """Call the store's library and name the object in its errors."""
        try:
            return function(*arguments, **options)
        except Exception as error:  # noqa: BLE001 - every store's library has errors of its own
            raise self._named(name, error) from None

    def _named(self, name: str, error: Exception) -> OSError:
        where = f"{self.location}/{name}".rstrip("/")
        if isinstance(error, FileNotFoundError):
            return FileNotFoundError(errno.ENOENT, _reason(error), where)
        if isinstance(error, FileExistsError):
            return FileExistsError(errno.EEXIST, "is there already", where)
        if isinstance(error, PermissionError):
            return PermissionError(errno.EACCES, _reason(error), where)
        return OSError(errno.EIO, _reason(error), where)


def _reason(error: Exception) -> str:
    text = " ".join(str(error).split()) or "no reason given"
    return f"{type(error).__name__}: {text}"[:500]
