"""From KITTI folders to the network's inputs, all computed on the fly."""
