"""A small tar archive of each kind of header, and damage to it whose checksums are right."""

from __future__ import annotations

import io
import random
import tarfile

from fuzz.mutations import damage_bytes

_BLOCK = 512
_CHECKSUM = slice(148, 156)


def tar_archive() -> bytes:
    """Return an archive of frames' files, with a long name and a time that take headers of their own."""
    file = io.BytesIO()
    for number, format in enumerate((tarfile.USTAR_FORMAT, tarfile.GNU_FORMAT, tarfile.PAX_FORMAT)):
        with tarfile.open(fileobj=io.BytesIO(), mode="w:", format=format) as tar:
            for name in (f"00000{number}.calib.txt", f"00000{number}/{'x' * 60}/{'y' * 60}"):
                item = tarfile.TarInfo(name)
                item.size, item.mtime = 20, 1.5
                tar.addfile(item, io.BytesIO(b"P0: 1 2 3 4 5 6 7 8\n"))
            assert isinstance(tar.fileobj, io.BytesIO)
            file.write(tar.fileobj.getvalue())
    return file.getvalue() + bytes(2 * _BLOCK)


def damage_archive(rng: random.Random, data: bytes) -> bytes:
    """Return an archive with one to four pieces of damage; half of them are no damage to checksums."""
    damaged = damage_bytes(rng, data)
    if rng.random() < 0.5:
        return damaged
    blocks = [damaged[at : at + _BLOCK] for at in range(0, len(damaged), _BLOCK)]
    return b"".join(
        _summed(block) if block[257:262] == b"ustar" and len(block) == _BLOCK else block for block in blocks
    )


def _summed(header: bytes) -> bytes:
    block = bytearray(header)
    block[_CHECKSUM] = b" " * 8
    block[_CHECKSUM] = b"%06o\0 " % sum(block)
    return bytes(block)
