"""Bumpless transfer: what is held bounds what ignorance asks for, and nothing else."""

import math
from dataclasses import replace
from itertools import product

import pytest

from tests.grip.stages import KERNELS, Closing, Takeover
from vegrip.clock import NS
from vegrip.grip.policies.demand import Demand
from vegrip.grip.safety import FailSafeSettings

RAMP = FailSafeSettings(force=5.0, ramp_rate=10.0)
LOAD = Demand(least_force=11.0, tangential_force=1.0, torque=0.0, in_contact=True, trusted=True)
BEGIN = 7 * NS


def bound(after: float = 0.0, force: float = 3.0, least: float = 11.0, **changes: float | bool) -> float:
    """Bound ``after`` [s] when ``force`` [N] was met holding 1 N and no torque, at an arm of 4 mm."""
    takeover = Takeover(RAMP)
    takeover.begin(force, LOAD, 4e-3, BEGIN)
    return takeover.bounded(least, replace(LOAD, **changes), BEGIN + round(after * NS))


def test_the_first_command_is_the_force_that_is_there() -> None:
    assert bound() == 3.0
    assert bound(least=math.inf) == 3.0


def test_a_lasting_need_is_met_by_the_ramp_up_to_the_fail_safe_grip() -> None:
    assert bound(0.1) == pytest.approx(4.0)
    assert bound(0.29) == 5.0
    assert bound(0.29, force=8.0) == 8.0


def test_less_than_is_held_is_asked_for_as_it_is() -> None:
    assert bound(least=2.0) == 2.0
    assert math.isnan(bound(least=math.nan))


def test_after_its_duration_the_estimate_rules() -> None:
    assert bound(KERNELS.TRANSFER_TIME) == 11.0


def test_slip_ends_it_for_good() -> None:
    takeover = Takeover(RAMP)
    takeover.begin(3.0, LOAD, 4e-3, BEGIN)
    assert takeover.bounded(11.0, replace(LOAD, slipping=True), BEGIN) == 11.0
    assert takeover.bounded(11.0, LOAD, BEGIN) == 11.0


def test_a_load_that_grows_needs_more_than_in_proportion() -> None:
    """For a friction coefficient that falls with the root of the normal force."""
    assert bound(tangential_force=1.5) == pytest.approx(3.0 * 1.5**2)
    assert bound(torque=4e-3) == pytest.approx(3.0 * 2.0)  # 1 N at 4 mm, across the other
    assert bound(tangential_force=0.5) == 3.0
    takeover = Takeover(RAMP)
    takeover.begin(3.0, LOAD, 0.0, BEGIN)  # without an arm a torque is no force
    assert takeover.bounded(11.0, replace(LOAD, torque=4e-3), BEGIN) == 3.0


def test_what_held_no_load_shows_nothing() -> None:
    takeover = Takeover(RAMP)
    takeover.begin(3.0, replace(LOAD, tangential_force=0.0), math.nan, BEGIN)
    assert takeover.bounded(11.0, LOAD, BEGIN) == 11.0


@pytest.mark.parametrize("force", [0.0, 3.0])
def test_no_load_breaks_it(force: float) -> None:
    nan, inf = math.nan, math.inf
    for first, then in product((5e-324, 1e-200, nan, inf, 1e300), (0.0, 60.0, nan, inf)):
        takeover = Takeover(RAMP)
        takeover.begin(force, replace(LOAD, tangential_force=first), 5e-324, BEGIN)
        found = takeover.bounded(11.0, replace(LOAD, tangential_force=then, torque=2.0), BEGIN)
        assert 0.0 <= found <= 11.0, (first, then)


def test_before_it_began_nothing_is_bounded() -> None:
    assert Takeover(RAMP).bounded(11.0, LOAD, BEGIN) == 11.0


@pytest.mark.parametrize(("force", "load"), [(2.5, 0.0), (3.0, 1.0)])
def test_the_force_of_a_close_is_taken_over_once_when_it_falls_or_a_load_comes(
    force: float, load: float
) -> None:
    closing = Closing()
    assert [closing.kept(one) for one in (0.0, 1.0, 3.0, 2.95)] == [0.5] * 4
    assert closing.kept(force, load) == 3.0
    assert closing.kept(4.0, load, held=3.0) == (0.0 if load else 3.0)
    assert closing.kept(2.0, load, held=3.0) == (0.0 if load else 3.0)


def test_a_force_that_is_held_already_is_not_taken_over() -> None:
    closing = Closing()
    closing.kept(3.0, held=3.0)
    assert closing.kept(2.5, held=3.0) == 3.0
    assert closing.kept(5.0, 1.0, held=3.0) == 0.0


def test_in_the_air_nothing_is_kept_and_the_next_object_stands_again() -> None:
    closing = Closing()
    assert closing.kept(3.0, 1.0) == 0.0
    assert closing.kept(0.0, touches=False) == 0.0
    assert closing.kept(1.0, held=1.2) == 1.2
