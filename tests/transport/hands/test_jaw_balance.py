"""Two opposed fingers feel one force: what one feels beyond the other is said, and noise is not."""

import random

import pytest

from vegrip.clock import NS
from vegrip.transport.hands.jaw_balance import JawBalance

PERIOD = NS // 200


def course(left, right, noise=0.05, seconds=4.0, seed=1):
    """Return whether they differed at each time."""
    rng = random.Random(seed)  # noqa: S311
    balance, found = JawBalance("left", "right"), []
    for number in range(1, round(seconds * 200)):
        for finger, force in (("left", left), ("right", right)):
            found.append(balance.note(finger, force + rng.gauss(0.0, noise), number * PERIOD))
    return found


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("noise", [0.01, 0.3, 1.0])
def test_noise_and_gains_of_five_percent_are_no_difference(noise, seed):
    assert not any(course(20.0, 21.8, noise, seed=seed))
    assert not any(course(0.0, 0.3, noise, seed=seed))


def test_a_jaw_that_also_presses_on_something_else_is_seen_after_a_second_and_not_before():
    found = course(20.0, 14.0)
    assert found[-1]
    assert not any(found[: 2 * 190])


def test_the_noisier_the_sensors_the_more_must_differ():
    assert course(5.0, 6.5, 0.05)[-1]
    assert not course(5.0, 6.5, 0.5)[-1]


def test_a_short_difference_and_a_value_that_is_missing_are_not_seen():
    balance = JawBalance("left", "right")
    assert not any(
        balance.note(finger, 5.0 + 3.0 * (finger == "left" and 100 < number < 140), number * PERIOD)
        for number in range(1, 400)
        for finger in ("left", "right")
    )
    assert not balance.note("left", float("nan"), 401 * PERIOD)
    assert not balance.note("third", 5.0, 402 * PERIOD)


def test_a_jaw_that_is_silent_is_not_compared_with_what_it_felt_before():
    balance = JawBalance("left", "right")
    for number in range(1, 200):
        assert not balance.note("left", 20.0, number * PERIOD)
        assert not balance.note("right", 20.0, number * PERIOD)
    assert not any(balance.note("left", 30.0, number * PERIOD) for number in range(200, 2000))
