//! Reads OpenDRIVE (crate `xodr`) into our network.
