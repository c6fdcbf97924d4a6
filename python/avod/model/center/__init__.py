"""A network that marks objects' centers in maps of the bird's-eye view: Yin et al., CVPR 2021."""
