"""Recorded data as a whole: pages of figures, banks of objects, fitted LIDARs."""
