"""When is it one slip, and when two."""

import numpy as np

from tests.virtual.build import body_of, tips_of
from vegrip.virtual import kernels

DT = 1e-3


def watch(pattern: list[tuple[float, list[bool]]], speed: float = 0.01) -> tuple[float, float]:
    """Return how many slips there were, and the largest slide [m] that was too short to be one."""
    body, tips = body_of(step=DT), tips_of(len(pattern[0][1]), a=5e-3)
    for duration, whole in pattern:
        tips["sliding_share"], tips["slip_speed"] = whole, np.where(whole, speed, 0.0)
        for _ in range(round(duration / DT)):
            kernels.watch_slips(body[0], tips)
    kernels.end_event(body[0], tips)
    return float(body["slips"][0]), float(body["largest_micro_slip"][0])


def test_a_long_slide_is_one_slip() -> None:
    assert watch([(1.0, [True, False])]) == (1.0, 0.0)


def test_fingers_that_slide_together_are_one_slip() -> None:
    assert watch([(0.1, [True, False]), (0.1, [True, True]), (0.1, [False, True])])[0] == 1.0


def test_a_rest_separates_two_slips_and_a_short_catch_does_not() -> None:
    slide, rest, catch = (0.1, [True]), (0.1, [False]), (0.02, [False])
    assert watch([slide, rest, slide])[0] == 2.0
    assert watch([slide, catch, slide])[0] == 1.0


def test_creeping_is_no_slip() -> None:
    assert watch([(1.0, [True])], speed=5e-5)[0] == 0.0
    assert watch([(1.0, [True])], speed=4e-6) == (0.0, 0.0)


def test_a_slide_that_is_too_short_to_be_a_slip_is_a_micro_slip_of_its_length() -> None:
    short, longer, rest = (0.003, [True, False]), (0.006, [False, True]), (0.1, [False, False])
    slips, largest = watch([short, rest, longer, rest, short])
    assert slips == 0.0
    assert largest == 0.006 * 0.01


def test_only_a_whole_and_moving_patch_slides() -> None:
    tips = tips_of(3, a=5e-3, sliding_share=[1.0, 0.5, 1.0], slip_speed=[1e-3, 1e-3, 1e-7])
    kernels.watch_slips(body_of(step=DT)[0], tips)
    assert tips["slides"].tolist() == [1.0, 0.0, 0.0]
