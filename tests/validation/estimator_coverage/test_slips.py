"""Grips held until they slip: the truth is what it says, and the forecast is honest about it."""

import math

import numpy as np
import pytest

from validation.estimator_coverage import slip_table
from validation.estimator_coverage.slips import (
    FIRST_SLIP_S,
    HELD_FROM_S,
    LOOKS,
    SCENARIOS,
    Forecast,
    Life,
    Scenario,
    forecasts,
    lived,
    sample,
)
from vegrip.virtual.settings import random_fingertip

POSITION, GIVES_WAY, GROWS = SCENARIOS


def life_of(scenario: Scenario, seed: int) -> Life:
    rng = np.random.default_rng(seed)
    return lived(scenario, random_fingertip(rng), rng)


def test_a_held_position_stays_and_its_force_falls() -> None:
    life = life_of(POSITION, 3)
    held = sample(HELD_FROM_S)
    contact = life.contact
    assert np.all(contact.indentation[held:] == contact.indentation[held])
    assert np.all(np.diff(contact.normal_force[held:]) <= 1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_a_drive_that_gives_way_obeys_its_equation(seed: int) -> None:
    life = life_of(GIVES_WAY, seed)
    N, delta = life.contact.normal_force, life.contact.indentation
    held = sample(HELD_FROM_S)
    left = (N + life.drive * delta)[held + 1 :]
    assert left == pytest.approx(N[held] + life.drive * delta[held], rel=1e-9)
    assert N[-1] < N[held]
    assert delta[-1] > delta[held]


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_it_slips_when_the_load_reaches_the_limit_and_not_before(scenario: Scenario) -> None:
    held = sample(HELD_FROM_S)
    slipped = 0
    for seed in range(8):
        life = life_of(scenario, seed)
        if life.used(held, held) >= 1.0:
            continue
        when = life.slips_after(held, load_stays=False)
        if when == math.inf:
            assert life.used(life.t.size - 1, life.t.size - 1) < 1.0
            continue
        slipped += 1
        at = held + round(when / (life.t[1] - life.t[0]))
        assert life.used(at, at) >= 1.0
        assert life.used(at - 1, at - 1) < 1.0
    assert slipped > 0


def test_the_first_slip_is_on_the_limit_and_a_load_that_stays_slips_later() -> None:
    life = life_of(GROWS, 1)
    assert life.used(sample(FIRST_SLIP_S), sample(FIRST_SLIP_S)) == pytest.approx(1.0, rel=1e-9)
    at = sample(HELD_FROM_S + 1.0)
    assert life.slips_after(at, load_stays=True) >= life.slips_after(at, load_stays=False)


def test_the_bound_is_not_grossly_late() -> None:
    """Three slips can only refuse a bound that is wrong in more than every fourth look."""
    found = [forecast for _, forecast in forecasts(POSITION, 3, seed=11, branches=1)]
    (row,) = slip_table.rows(POSITION, LOOKS[0], found)
    assert row.looks == len(found) >= 3
    assert row.before_bound < 0.25


def test_a_forecast_is_judged_by_when_it_slipped() -> None:
    found = [
        Forecast(estimate=2.0, earliest=1.0, slip=0.5, slip_if_held=3.0),
        Forecast(estimate=2.0, earliest=1.0, slip=1.5, slip_if_held=math.inf),
        Forecast(estimate=math.inf, earliest=4.0, slip=5.0, slip_if_held=math.inf),
        Forecast(estimate=math.inf, earliest=math.inf, slip=math.inf, slip_if_held=math.inf),
    ]
    held, grown = slip_table.rows(GROWS, 0.1, found)
    assert (grown.before_bound, grown.by_estimate, grown.though_never) == (0.25, 1.0, 0.5)
    assert (held.before_bound, held.by_estimate, held.though_never) == (0.0, 0.0, 0.0)
    assert (grown.looks, grown.estimates, grown.nevers) == (4, 2, 2)
    assert (grown.before_time, grown.bounds, grown.though_none) == (1 / 3, 3, 0.0)
    assert len(slip_table.header()) == len(str(grown))
