"""Writes datasets: `cadet-gen` as a function."""

from cadet.generate.pool import WorkerError
from cadet.generate.run import Summary, generate
from cadet.generate.settings import EXPORTERS, EXTRAS, Settings

__all__ = ["EXPORTERS", "EXTRAS", "Settings", "Summary", "WorkerError", "generate"]
