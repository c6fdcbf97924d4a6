"""Programs that read our datasets, each tried on a small set: a table, and an error where one reads it otherwise.

python -m readers FOLDER [PYTHON ...]

FOLDER takes a set of each format. A program runs in a process of its own, of the first PYTHON that has it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import cadet
from cadet.formats.convert import convert
from cadet.generate import Settings, generate
from readers.programs import READERS, Counts, Reader

NUM_FRAMES, NUM_IN_SEQUENCES = 40, 10
SINGLE, SEQUENCES = ("kitti", "webdataset", "parquet"), ("kitti_tracking", "kitti_raw", "nuscenes", "mcap")
HEAD: Final = "| program | version | format | frames | boxes |\n|---|---|---|---|---|\n"


def make_sets(folder: Path) -> dict[str, tuple[int, int]]:
    """Make or mend a set of each format, and return its frames and objects as the simulation counts them."""
    truth = {}
    for name in (*SINGLE, *SEQUENCES):
        policy, num_frames = cadet.ResetPolicy.kitti(), NUM_FRAMES
        if name in SEQUENCES:
            policy, num_frames = policy.as_sequence(hz=2, length_s=2.5), NUM_IN_SEQUENCES
        rig = cadet.Rig.nuscenes() if name == "nuscenes" else None
        settings = Settings(num_frames=num_frames, policy=policy, rig=rig, format=name)
        labels = generate(folder / name, settings, resume=(folder / name).exists()).labels
        truth[name] = num_frames, labels.total() - labels["DontCare"]
    if not (folder / "coco").exists():
        convert(folder / "kitti", folder / "coco", "coco")
    return {**truth, "coco": truth["kitti"]}


def answer(reader: Reader, root: Path) -> tuple[str, Counts] | None:
    """Return a program's version and what it counts; None if it is not installed here."""
    try:
        version = metadata.version(reader.distribution) if reader.distribution else "their rules"
    except metadata.PackageNotFoundError:
        return None
    with TemporaryDirectory() as scratch, redirect_stdout(sys.stderr):
        return version, reader.read(root, Path(scratch))


def ask(reader: Reader, folder: Path, pythons: Sequence[str]) -> Any:
    """Return the answer of the first interpreter that has the program, as JSON has it; its last words if it fails."""
    for python in pythons:
        command = [python, "-m", "readers", "--only", reader.name, str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
        if done.stdout != "null":
            return json.loads(done.stdout)
    return None


def row(reader: Reader, found: Any, expected: tuple[int, int]) -> tuple[str, str | None]:
    """Return a program's row by its answer, and what is wrong with it, if anything is."""
    version, (frames, boxes) = ("not installed", (None, None)) if found is None else ("failed", (None, None))
    wrong = None
    if isinstance(found, str):
        wrong = f"{reader.name}: {found}"
    elif found is not None:
        version, (frames, boxes) = found
        if frames != expected[0] or boxes not in (expected[1], None):
            wrong = (
                f"{reader.name}: {frames} frames and {boxes} boxes, but generated were {expected[0]} and {expected[1]}"
            )
    counts = " | ".join("-" if count is None else str(count) for count in (frames, boxes))
    return f"| {reader.name} | {version} | `{reader.format}` | {counts} |\n", wrong


def main() -> int:
    """Write the table, or the answer of one program; return 1 if any is wrong."""
    parser = argparse.ArgumentParser(prog="python -m readers")
    parser.add_argument("folder", type=Path)
    parser.add_argument("python", nargs="*", default=[sys.executable])
    parser.add_argument("--only", choices=[reader.name for reader in READERS])
    asked = parser.parse_args()
    folder = asked.folder.absolute()
    if asked.only is not None:
        (reader,) = (reader for reader in READERS if reader.name == asked.only)
        sys.stdout.write(json.dumps(answer(reader, folder / reader.format)))
        return 0
    truth = make_sets(folder)
    sys.stdout.write(HEAD)
    errors = []
    for reader in READERS:
        line, wrong = row(reader, ask(reader, folder, asked.python), truth[reader.format])
        sys.stdout.write(line)
        sys.stdout.flush()
        errors += [f"error: {wrong}\n"] if wrong else []
    sys.stderr.writelines(errors)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
