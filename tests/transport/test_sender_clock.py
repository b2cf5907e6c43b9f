"""The clock of a sender, found from stamps and arrivals alone."""

import math

import numpy as np
import pytest

from vegrip.clock import NS
from vegrip.transport.sender_clock import SenderClock, _lower_hull

MS = 1_000_000
LEAST = 150_000  # [ns] on the way, at least


def stream(seconds, offset=0.0, drift=0.0, jitter=200e-6, seed=0, rate=200):
    """Yield sender's stamp, arrival and true time of sending on our clock [ns]."""
    random = np.random.default_rng(seed)
    for i in range(int(seconds * rate)):
        true = 5 * NS + i * NS // rate
        stamp = round((true - 5 * NS) * (1.0 + drift)) + 5 * NS - round(offset * NS)
        yield stamp, true + LEAST + round(random.exponential(jitter) * NS), true


@pytest.mark.parametrize("offset", [0.0, 1234.5, -20.0])
@pytest.mark.parametrize("drift", [0.0, 50e-6, -120e-6])
def test_offset_and_drift_are_found_whatever_the_jitter(offset, drift):
    clock = SenderClock()
    errors = []
    for stamp, arrival, true in stream(20.0, offset, drift):
        errors.append(clock.observe(stamp, arrival) - true - LEAST)
    found = clock.estimate()
    assert found.drift == pytest.approx(-drift / (1 + drift), abs=3e-6)
    assert max(abs(error) for error in errors[1000:]) < 60_000  # [ns] against 200 us of jitter
    assert found.offset == pytest.approx((arrival - stamp) / NS, abs=2e-3)


def test_jitter_is_what_messages_take_beyond_the_quickest():
    clock = SenderClock()
    for stamp, arrival, _ in stream(16.0, jitter=300e-6):
        clock.observe(stamp, arrival)
    found = clock.estimate()
    assert found.jitter == pytest.approx(300e-6 * math.sqrt(2.0), rel=0.1)  # rms of an exponential law
    assert found.worst >= 5 * 300e-6


def test_spacing_of_the_stamps_survives_the_jitter():
    """The reason for it all: a filter wants the times of the samples, not of their arrival."""
    clock = SenderClock()
    mapped, came = [], []
    for stamp, arrival, _ in stream(10.0, offset=3.0, drift=80e-6, jitter=1e-3):
        mapped.append(clock.observe(stamp, arrival))
        came.append(arrival)
    assert np.std(np.diff(mapped[400:])) < 0.05 * np.std(np.diff(came[400:]))


def test_a_clock_that_is_set_is_followed_at_once():
    clock = SenderClock()
    for stamp, arrival, _ in stream(5.0):
        clock.observe(stamp, arrival)
    true = mapped = 0
    for stamp, arrival, true in stream(5.0, offset=40.0, seed=1):  # noqa: B007
        mapped = clock.observe(stamp, arrival)
    assert clock.jumps == 1
    assert abs(mapped - true - LEAST) < 60_000


def test_nothing_comes_before_it_was_sent_or_after_it_arrived():
    clock = SenderClock()
    for stamp, arrival, _ in stream(5.0, drift=100e-6):
        assert clock.observe(stamp, arrival) <= arrival


def test_before_anything_has_come_nothing_is_known():
    assert math.isnan(SenderClock().estimate().offset)


def test_the_hull_lies_below_all_points_and_touches_its_corners():
    random = np.random.default_rng(3)
    points = [(i, int(y)) for i, y in enumerate(random.integers(0, 1000, 60))]
    hull = _lower_hull(points)
    below = np.interp([x for x, _ in points], [x for x, _ in hull], [y for _, y in hull])
    assert all(y >= b - 1e-9 for (_, y), b in zip(points, below, strict=True))
    assert set(hull) <= set(points)
