"""Diagnosing AP: errors, conditions, confusion, thresholds, intervals, comparisons (`docs/evaluation.md`)."""

from cadet.evaluation.analysis.comparison import Comparison, Difference
from cadet.evaluation.analysis.result import Analysis
from cadet.evaluation.analysis.run import analyze

__all__ = ["Analysis", "Comparison", "Difference", "analyze"]
