"""Helpers of all rooms: checks, arrays, text, files, processes, and atomic writes."""
