"""Laws of mapping driver time stamps to the monotonic clock."""

import numpy as np
import pytest

from vegrip.clock import NS
from vegrip.transport.sender_clock import OLDEST, StampMap

WALL = 1_760_000_000 * NS  # seconds since 1970 at monotonic time zero


class Clocks:
    def __init__(self):
        self.monotonic, self.offset = 5 * NS, WALL

    def map(self):
        return StampMap(lambda: self.monotonic, lambda: self.monotonic + self.offset)


def test_wall_clock_stamps_keep_their_delay():
    clocks = Clocks()
    stamps = clocks.map()
    for _ in range(100):
        clocks.monotonic += 10_000_000
        true = clocks.monotonic - 150_000
        assert stamps.to_monotonic((true + WALL) / NS) == pytest.approx(true, abs=500)  # float64 of a date


def test_a_wall_clock_that_is_set_is_followed_within_a_second():
    clocks = Clocks()
    stamps = clocks.map()
    stamps.to_monotonic((clocks.monotonic + WALL) / NS)
    clocks.offset += 600 * NS
    clocks.monotonic += 500_000_000
    assert stamps.to_monotonic((clocks.monotonic + clocks.offset) / NS) == clocks.monotonic
    clocks.monotonic += 600_000_000
    true = clocks.monotonic - 1_000_000
    assert stamps.to_monotonic((true + clocks.offset) / NS) == pytest.approx(true, abs=500)


def test_a_free_running_clock_is_mapped_to_within_the_smallest_delay():
    clocks = Clocks()
    stamps = clocks.map()
    random = np.random.default_rng(4)
    errors = []
    for i in range(5000):
        true = 5 * NS + i * 1_000_000
        device = (true - 3 * NS) * (1 + 50e-6) / NS  # starts at its own zero, 50 ppm fast
        clocks.monotonic = true + 20_000 + int(random.exponential(200_000))
        errors.append(stamps.to_monotonic(device) - true)
    assert np.std(errors[500:]) < 30_000  # [ns] against 200 us of jitter in the arrival
    assert abs(np.mean(errors[500:])) < 100_000


@pytest.mark.parametrize("stamp", [0.0, float("nan"), float("inf"), -1.0])
def test_without_a_stamp_the_arrival_counts(stamp):
    clocks = Clocks()
    assert clocks.map().to_monotonic(stamp) == clocks.monotonic


@pytest.mark.parametrize("delay", [-1_000_000, OLDEST + 1_000_000])
def test_no_stamp_lies_in_the_future_or_in_the_far_past(delay):
    clocks = Clocks()
    assert clocks.map().to_monotonic((clocks.monotonic - delay + WALL) / NS) == clocks.monotonic
