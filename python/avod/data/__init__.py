"""From KITTI folders to what the network takes; everything is made on the fly."""
