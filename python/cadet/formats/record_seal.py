"""The hash that a sample's record carries of itself: one changed byte, and the record is known to be damaged."""

from __future__ import annotations

import re
from hashlib import sha256
from typing import Final

SEAL: Final = "record"
"""The key, beside those of the sample's files under `sha256`."""
BLANK: Final = "0" * 64
"""What stands in the hash's place while it is taken, and what `sealed` replaces: the last of its kind in the record."""


def sealed(blank: bytes) -> bytes:
    """Return a record with its hash in the place of `BLANK`."""
    head, _, tail = blank.rpartition(BLANK.encode("ascii"))
    return head + sha256(blank).hexdigest().encode("ascii") + tail


def is_intact(record: bytes, digest: object) -> bool:
    """Tell whether a record is as it was sealed.

    Args:
        record: its bytes.
        digest: what it carries under `SEAL`.
    """
    if not isinstance(digest, str) or not re.fullmatch(r"[0-9a-f]{64}", digest):
        return False
    head, _, tail = record.rpartition(digest.encode("ascii"))
    return sha256(head + BLANK.encode("ascii") + tail).hexdigest() == digest
