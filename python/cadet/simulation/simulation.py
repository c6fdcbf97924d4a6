"""What a stream of frames is made from, as a TOML file: the policy's name and what differs from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cadet._util.checks import as_seed
from cadet._util.plain_tables import check_keys
from cadet._util.toml_file import TomlFile
from cadet.simulation.streaming import FrameStream, stream
from cadet.worlds.policy import ResetPolicy


@dataclass(frozen=True)
class Simulation(TomlFile):
    """A seed and a policy: all that frames follow from.

    A file has `seed` and the keys of a policy's, as docs/reference/settings.md lists them.

    Attributes:
        policy: how worlds are drawn.
        seed: names every random draw.
    """

    policy: ResetPolicy
    seed: int = 0

    @classmethod
    def _of_table(cls, table: Mapping[str, Any], folder: Path, place: str = "") -> Simulation:
        check_keys(table, ("seed", *ResetPolicy._keys()))
        changes = {key: value for key, value in table.items() if key != "seed"}
        return cls(ResetPolicy._of_table(changes, folder), as_seed(table.get("seed", 0)))

    def _table(self) -> dict[str, Any]:
        return {"seed": self.seed, **self.policy._table()}

    def identity(self) -> dict[str, Any]:
        """Return all that frames follow from, in plain values."""
        return {
            "seed": self.seed,
            "policy": self.policy.to_dict(),
            "rigs": {rig.name: rig.sha256() for rig, _ in self.policy.rigs},
        }

    def stream(self, *, workers: int | None = None, first: int = 0, shard: tuple[int, int] = (0, 1)) -> FrameStream:
        """Yield an endless stream of its frames: see `cadet.stream`."""
        return stream(self.policy, seed=self.seed, workers=workers, first=first, shard=shard)
