"""Parquet files of KITTI's frames as an exporter's."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from cadet.formats.exporter import Place, Split
from cadet.formats.parquet.parquet_format import ParquetFormat
from cadet.formats.parquet.rows import COLUMNS, schema
from cadet.formats.webdataset.dataset_card import SPLITS
from cadet.formats.webdataset.exporter import WebdatasetExporter

_EXAMPLE: Final = (
    "```python",
    "import numpy as np",
    "from datasets import load_dataset",
    "",
    'frame = load_dataset("FOLDER")["train"][0]  # or its name on the hub',
    'points_velo = np.frombuffer(frame["points_velo"], "<f4").reshape(-1, 4)',
    'types = [label["type"] for label in frame["labels"]]',
    "```",
    "",
)


@dataclass
class ParquetExporter(WebdatasetExporter):
    """Shards for each split with a row for each sample; see `cadet.formats.exporter.Exporter`."""

    name: str = "parquet"
    extras: tuple[str, ...] = ()

    def shard(self, place: Place) -> str:
        """Return the shard of a sample."""
        return f"data/{SPLITS[place.split]}-{place.rank // self.shard_size:05d}.parquet"

    def shards(self, split: Split) -> str:
        """Return a pattern of the shards of a split."""
        return f"data/{SPLITS[split]}-*.parquet"

    def columns(self, kinds: Iterable[str]) -> str:
        """Return what a row holds, for the dataset's card."""
        return "\n".join(
            [*_EXAMPLE, "| column | |", "|---|---|", *(f"| `{name}` | {what} |" for name, what in COLUMNS.items())]
        )

    def archives(self) -> ParquetFormat:
        """Return what shards are written by.

        Raises:
            CadetError: pyarrow is not installed.
        """
        schema()
        return ParquetFormat()
