"""Writes datasets: `cadet-gen` as a function."""

from cadet.errors import WorkerError
from cadet.generate.run import ENGINES, Summary, generate
from cadet.generate.settings import EXPORTERS, EXTRAS, Settings

__all__ = ["ENGINES", "EXPORTERS", "EXTRAS", "Settings", "Summary", "WorkerError", "generate"]
