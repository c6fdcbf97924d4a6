"""The columns of AVOD's logs."""

from __future__ import annotations

from avod.model.avod.network import AvodNetwork

TERMS = (*AvodNetwork.TERMS, "total")
COLUMNS = ("step", "learning_rate", *TERMS, "seconds_per_step")
