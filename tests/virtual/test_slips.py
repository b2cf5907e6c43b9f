"""When is it one slip, and when two."""

import numpy as np

from vegrip.virtual.slips import SlipCounter, is_sliding

DT = 1e-3


def watch(counter: SlipCounter, pattern: list[tuple[float, list[bool]]], speed: float = 0.01) -> int:
    for duration, whole in pattern:
        for _ in range(round(duration / DT)):
            slip = np.column_stack([whole, np.where(whole, speed, 0.0)]).astype(float)
            counter.watch(slip, np.full(len(whole), 5e-3), DT)
    return counter.count


def test_a_long_slide_is_one_slip() -> None:
    assert watch(SlipCounter(2), [(1.0, [True, False])]) == 1


def test_fingers_that_slide_together_are_one_slip() -> None:
    assert watch(SlipCounter(2), [(0.1, [True, False]), (0.1, [True, True]), (0.1, [False, True])]) == 1


def test_a_rest_separates_two_slips_and_a_short_catch_does_not() -> None:
    slide, rest, catch = (0.1, [True]), (0.1, [False]), (0.02, [False])
    assert watch(SlipCounter(1), [slide, rest, slide]) == 2
    assert watch(SlipCounter(1), [slide, catch, slide]) == 1


def test_creeping_is_no_slip() -> None:
    assert watch(SlipCounter(1), [(1.0, [True])], speed=5e-5) == 0


def test_only_a_whole_and_moving_patch_slides() -> None:
    a = np.full(3, 5e-3)
    sliding, speed = np.array([1.0, 0.5, 1.0]), np.array([1e-3, 1e-3, 1e-7])
    assert is_sliding(sliding, speed, a).tolist() == [True, False, False]
    counter = SlipCounter(3)
    counter.watch(np.column_stack([sliding, speed]), a, DT)
    assert counter.sliding.tolist() == [1.0, 0.0, 0.0]
