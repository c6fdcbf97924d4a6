"""Makes `python/cadet/datasets/report/kitti_statistics.json` of KITTI's label files: counts alone, no label's text.

    python benches/kitti_statistics.py labels_7481.tar.xz labels_200

The first argument is a tar file of the 7,481 files `label_2/ID.txt`, the second a folder with `label_2/ID.txt` of some
frames and `num_points.json`: by id, the number of returns in the box of each line.
"""

from __future__ import annotations

import json
import re
import sys
import tarfile
from pathlib import Path

from cadet.datasets.report.quantities import POINTS
from cadet.datasets.report.statistics import KITTI_FILE, Statistics
from cadet.formats.kitti import labels_from_text


def of_labels(archive: Path) -> Statistics:
    """Count every label file of an archive."""
    statistics = Statistics()
    with tarfile.open(archive) as tar:
        for member in tar:
            file = tar.extractfile(member)
            if file is not None and re.fullmatch(r"(.*/)?label_2/\d{6}\.txt", member.name):
                statistics.add(labels_from_text(file.read().decode("ascii"), member.name))
    return statistics


def of_points(folder: Path) -> Statistics:
    """Count the returns in boxes."""
    statistics = Statistics()
    for frame_id, numbers in json.loads((folder / "num_points.json").read_text()).items():
        name = f"label_2/{frame_id}.txt"
        labels = labels_from_text((folder / name).read_text(), name)
        kept = [number for label, number in zip(labels, numbers, strict=True) if not label.is_dont_care]
        statistics.add(labels, kept)
    return statistics


def main(archive: Path, folder: Path) -> None:
    """Write the file."""
    statistics = of_labels(archive)
    statistics.histograms[POINTS.name] = of_points(folder).histograms[POINTS.name]
    KITTI_FILE.write_text(statistics.to_text())
    print(f"{statistics.num_frames} frames, {statistics.labels.total()} labels: {KITTI_FILE}")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
