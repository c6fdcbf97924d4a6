"""What is drawn how finely follows from the sizes of pixels and beams, never from the number of triangles."""

from __future__ import annotations

from dataclasses import replace

import cadet


def count_triangles(seed: int, rig: cadet.Rig | None = None) -> int:
    """Count a suburb's triangles as a rig's sensors see them."""
    return cadet.Scene.random(seed=seed, rig=rig, weather="clear_noon").num_triangles


def test_finer_pixels_see_finer_scenes_and_coarser_ones_no_finer_than_the_beams_ask_for() -> None:
    kitti = cadet.Rig.kitti()
    width, height = kitti.camera.width, kitti.camera.height
    fine = replace(kitti, camera=kitti.camera.resized(2 * width, 2 * height))
    coarse = replace(kitti, camera=kitti.camera.resized(width // 4, height // 4))
    tiny = replace(kitti, camera=kitti.camera.resized(width // 8, height // 8))
    counts = [count_triangles(1, rig) for rig in (fine, kitti, coarse, tiny)]
    # Beams are 3.0 mrad apart, pixels 1.4: where pixels are coarser than beams, these decide.
    assert counts[0] > 1.2 * counts[1] > 1.2 * counts[2], counts
    assert counts[2] == counts[3] > 0.35 * counts[1], counts
