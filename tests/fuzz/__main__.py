"""Feeds every reader with damaged input and prints what was neither read nor refused.

python -m fuzz [SECONDS]              seconds a reader, 60 by default
python -m fuzz --show NAME NUMBER     one input again, and what becomes of it
"""

from __future__ import annotations

import random
import sys

from fuzz.harness import fuzz, input_of, outcome
from fuzz.targets import TARGETS


def main() -> int:
    """Return 1 if anything failed."""
    if sys.argv[1:2] == ["--show"]:
        target = next(target for target in TARGETS if target.name == sys.argv[2])
        value = input_of(target, int(sys.argv[3]))
        sys.stdout.write(f"{value!r}\n{outcome(target, value) or 'read or refused'}\n")
        return 0
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    # Other inputs each time; a failure's number shows it again.
    first = random.SystemRandom().randrange(1 << 40)
    num_failures = 0
    for target in TARGETS:
        count, failures = fuzz(target, seconds, first=first)
        sys.stdout.write(f"{target.name}: {count} inputs, {len(failures)} kinds of failure\n")
        for failure in failures:
            sys.stdout.write(f"  {failure.what}: python -m fuzz --show {target.name!r} {failure.number}\n")
        num_failures += len(failures)
    return 1 if num_failures else 0


if __name__ == "__main__":
    sys.exit(main())
