"""AVOD-FPN: two feature pyramids, the region proposal network, the second stage."""
