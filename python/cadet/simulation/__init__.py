"""Episodes, driven: scenes, environments, and endless streams of frames."""
