"""Makes the golden frames and prints or renews their hashes.

    make golden                               # prints what differs and rewrites golden_frames.json of the package
    python tests/support/golden_frames.py     # prints the hashes

A hash that changes is a change of every dataset: renew them once for a change that is meant, and say so in
CHANGELOG.md.
"""

from __future__ import annotations

import json
import sys

from cadet.generate.golden_frames import CASES, FILE, digest, stored


def _digests() -> dict[str, str]:
    return {name: digest(case.capture()) for name, case in CASES.items()}


def _renew() -> None:
    before = stored() if FILE.is_file() else {}
    after = _digests()
    for name in sorted({*before, *after}):
        if before.get(name) != after.get(name):
            sys.stdout.write(f"{name}: {before.get(name)} -> {after.get(name)}\n")
    FILE.write_text(json.dumps(after, indent=2) + "\n")
    sys.stdout.write(f"wrote {FILE.name}: {sum(before.get(n) != d for n, d in after.items())} changed\n")


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        _renew()
    elif not sys.argv[1:]:
        sys.stdout.write(json.dumps(_digests(), indent=2) + "\n")
    else:
        sys.exit("expected --write or nothing")
