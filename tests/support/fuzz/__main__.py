"""Feeds every reader with damaged input and prints what was neither read nor refused.

python -m fuzz [COUNT [FIRST]]        inputs a reader, 100,000 by default
python -m fuzz --show NAME NUMBER     one input again, and what becomes of it
"""

from __future__ import annotations

import math
import random
import sys
import time

from fuzz.harness import fuzz, input_of, outcome
from fuzz.targets import TARGETS


def main() -> int:
    """Return 1 if anything failed."""
    if sys.argv[1:2] == ["--show"]:
        target = next(target for target in TARGETS if target.name == sys.argv[2])
        value = input_of(target, int(sys.argv[3]))
        sys.stdout.write(f"{value!r}\n{outcome(target, value) or 'read or refused'}\n")
        return 0
    wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    # Other inputs each time; a failure's number shows it again.
    first = int(sys.argv[2]) if len(sys.argv) > 2 else random.SystemRandom().randrange(1 << 40)
    num_failures = 0
    for target in TARGETS:
        begun_s = time.monotonic()
        count, failures = fuzz(target, math.inf, first=first, count=wanted)
        seconds = time.monotonic() - begun_s
        sys.stdout.write(f"{target.name}: {count} inputs, {seconds:.0f} s, {len(failures)} kinds of failure\n")
        sys.stdout.flush()
        for failure in failures:
            sys.stdout.write(f"  {failure.what}: python -m fuzz --show {target.name!r} {failure.number}\n")
        num_failures += len(failures)
    return 1 if num_failures else 0


if __name__ == "__main__":
    sys.exit(main())
