"""Datasets' formats, read and written."""
