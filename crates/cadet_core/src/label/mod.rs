//! Labels: boxes, truncation, occlusion.
