"""Diagnosing AP: errors, conditions, confusion, thresholds, intervals, comparisons (`docs/evaluation.md`)."""

from cadet.analysis.comparison import Comparison, Difference
from cadet.analysis.result import Analysis
from cadet.analysis.run import analyze

__all__ = ["Analysis", "Comparison", "Difference", "analyze"]
