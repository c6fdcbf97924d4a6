"""Samples as rows of Parquet files, as Hugging Face's `datasets` loads them."""

from cadet.formats.parquet.exporter import ParquetExporter

__all__ = ["ParquetExporter"]
