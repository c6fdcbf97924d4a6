"""Cameras, LIDARs, how they are mounted on the car, and what they capture."""
