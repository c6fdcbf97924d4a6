"""Writes datasets: `cadet-gen` as a function."""

from cadet.errors import WorkerError
from cadet.generate.again import Comparison, compare, generate_frame
from cadet.generate.recipe import RECIPE, Recipe
from cadet.generate.run import ENGINES, Summary, generate
from cadet.generate.settings import EXPORTERS, EXTRAS, Settings

__all__ = [
    "ENGINES",
    "EXPORTERS",
    "EXTRAS",
    "RECIPE",
    "Comparison",
    "Recipe",
    "Settings",
    "Summary",
    "WorkerError",
    "compare",
    "generate",
    "generate_frame",
]
