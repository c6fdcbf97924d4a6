"""Sheets of a frame's figures, real or generated, contact sheets, and episodes for Rerun."""
