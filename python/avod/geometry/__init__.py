"""Anchors on the ground plane, their projections, and the encodings of boxes.

Everything is in the rectified frame of camera 0: x right, y down, z ahead, meters.
`anchors` are (N, 6) [x, y, z, dx, dy, dz], axis-aligned, y the bottom and dy the height.
`boxes_cam` are (N, 7) [x, y, z, l, w, h, rotation_y], y the bottom as well.
`boxes_4c` are (N, 10) [x1..x4, z1..z4, h1, h2]: corners seen from above, heights of bottom and top over the ground.
"""
