//! The LIDAR: sensor specifications, beams and returns.
