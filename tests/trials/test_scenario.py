"""A scenario is a function of its seed and world alone."""

from dataclasses import replace

import numpy as np
import pytest

from vegrip.trials.closed_loop import FRICTION_RANGE, Scenario
from vegrip.trials.published_friction import PUBLISHED, draw_friction
from vegrip.virtual.disturbance import Wetting


def test_the_same_seed_gives_the_same_object_and_fate() -> None:
    assert Scenario(3, 20.0).settings == Scenario(3, 20.0).settings
    assert Scenario(3, 20.0).events == Scenario(3, 20.0).events


def test_another_seed_gives_another_object_and_fate() -> None:
    assert Scenario(3, 20.0).settings != Scenario(4, 20.0).settings
    assert Scenario(3, 20.0).events != Scenario(4, 20.0).events


def test_the_faces_get_wet_once_in_the_second_half() -> None:
    for seed in range(20):
        wet = [event for event in Scenario(seed, 20.0).events if isinstance(event, Wetting)]
        assert len(wet) == 1
        assert 10.0 <= wet[0].start <= 14.0
        assert wet[0].start + wet[0].duration < 20.0
        assert FRICTION_RANGE[0] <= Scenario(seed, 20.0).settings.tip.friction <= FRICTION_RANGE[1]


def test_worlds_differ_in_friction_and_gain_and_in_nothing_else() -> None:
    for seed in range(20):
        old, other = Scenario(seed, 20.0), Scenario(seed, 20.0, world="published")
        assert other.events == old.events
        hand, usual = other.settings, old.settings
        assert usual.tip.friction_exponent == 0.0
        assert usual.sensor.tangential_gain == 1.0
        tip = replace(hand.tip, friction=usual.tip.friction, friction_exponent=0.0)
        assert replace(hand, tip=tip, sensor=replace(hand.sensor, tangential_gain=1.0)) == usual


def test_the_published_world_has_slippery_and_sticky_objects_steep_and_flat_ones_and_low_gains() -> None:
    hands = [Scenario(seed, 5.0, world="published").settings for seed in range(300)]
    for values, low, high in (
        ([hand.tip.friction for hand in hands], 0.2, 1.1),
        ([hand.tip.friction_exponent for hand in hands], 0.0, 1.0 / 3.0),
        ([hand.sensor.tangential_gain for hand in hands], 0.8, 1.05),
    ):
        assert low <= min(values) < low + 0.1 * (high - low)
        assert high - 0.05 * (high - low) < max(values) <= high


def test_published_rows_say_what_their_sources_say() -> None:
    rows = {row.name: row for row in PUBLISHED}
    for name in ("finger pad on aluminium", "finger pad on rubber hose"):
        assert 20.0 ** -rows[name].exponent == pytest.approx(1.0 - 0.46, abs=0.01)  # from 1 to 20 N
    sandpaper = rows["fingertip on sandpaper"]
    assert sandpaper.mu * (4.0 / 5.0) ** -sandpaper.exponent == pytest.approx(0.96, abs=0.005)
    wood = rows["silicone pillars on wood"]
    held, failed = (9.41, 0.26), (7.23, 0.34)  # [N], tangential over normal force, of 0.5 kg
    assert wood.mu * (held[0] / 5.0) ** -wood.exponent > held[1]
    assert wood.mu * (failed[0] / 5.0) ** -wood.exponent < failed[1]


def test_every_row_is_drawn_as_often_as_another_with_its_own_mean_and_spread() -> None:
    drawn = [draw_friction(np.random.default_rng(seed)) for seed in range(3000)]
    for row in PUBLISHED:
        logarithms = np.log([mu for one, mu, _ in drawn if one is row])
        assert len(logarithms) == pytest.approx(3000 / len(PUBLISHED), rel=0.15)
        assert np.median(logarithms) == pytest.approx(np.log(row.mu), abs=0.05)
        if row.mu * np.exp(3.0 * row.spread) < 1.1 and row.mu * np.exp(-3.0 * row.spread) > 0.2:
            assert logarithms.std() == pytest.approx(row.spread, rel=0.15)
