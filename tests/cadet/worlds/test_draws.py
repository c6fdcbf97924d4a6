from __future__ import annotations

from collections import Counter

from cadet.worlds.draws import Draws


def test_a_golden_draw_keeps_old_datasets_reproducible() -> None:
    draws = Draws(7, 3, 1, "weather")
    assert [draws.unit() for _ in range(3)] == [0.8966806553470117, 0.035418428468720564, 0.43023727538383894]


def test_streams_differ_by_every_part_of_their_name() -> None:
    first = Draws(1, 2, 0, "map").unit()
    assert Draws(1, 2, 0, "map").unit() == first
    others = [Draws(2, 2, 0, "map"), Draws(1, 3, 0, "map"), Draws(1, 2, 1, "map"), Draws(1, 2, 0, "weather")]
    assert first not in [other.unit() for other in others]


def test_draws_stay_in_their_ranges_and_reach_both_ends() -> None:
    draws = Draws(0, 0, 0, "ranges")
    counts = [draws.count(3, 5) for _ in range(500)]
    assert set(counts) == {3, 4, 5}
    numbers = [draws.between(-1.0, 2.0) for _ in range(2000)]
    assert -1.0 <= min(numbers) < -0.98
    assert 1.98 < max(numbers) <= 2.0
    assert draws.count(4, 4) == 4


def test_weights_are_kept_and_weight_zero_is_never_drawn() -> None:
    draws = Draws(0, 0, 0, "weights")
    num = 20_000
    seen = Counter(draws.weighted([("a", 3.0), ("never", 0.0), ("b", 1.0)]) for _ in range(num))
    assert set(seen) == {"a", "b"}
    # Four standard deviations of a binomial share.
    assert abs(seen["a"] / num - 0.75) < 4 * (0.75 * 0.25 / num) ** 0.5
