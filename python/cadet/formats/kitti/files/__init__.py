"""KITTI's files, parsed and written: a module for each kind."""
