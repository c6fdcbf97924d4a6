"""Programs of this repository that are not part of what users install."""
