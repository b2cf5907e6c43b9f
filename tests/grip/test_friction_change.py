"""What is stated of friction holds that it may have fallen, or come back, since it was felt."""

import math

import pytest
from scipy.optimize import brentq
from scipy.stats import norm

from vegrip.grip.friction_belief import begin_belief, expect_finger
from vegrip.grip.friction_change import (
    CHANGED,
    FALL,
    FALL_SPREAD,
    INSIDE,
    begin_changes,
    follow_level,
    stated_friction,
)
from vegrip.grip.grasp_friction import GraspFriction
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.messages import ContactEstimate, Estimate

UNKNOWN = 0.2


def belief(mean: float, std: float) -> GraspMemory:
    g = GraspMemory()
    begin_belief(g, 1, 0.03, 0.08)
    expect_finger(g, 0, mean, std, 0.08)
    begin_changes(g)
    g.probe.unknown = UNKNOWN
    return g


@pytest.mark.parametrize("std", [0.02, 0.1, 0.19])
@pytest.mark.parametrize(("rise", "spread"), [(0.0, 0.1), (0.02, 0.3), (0.4, 0.05), (0.4, 0.4)])
def test_the_stated_interval_is_that_of_the_mixture(std, rise, spread):
    mean = -0.3
    parts = [
        (1.0 - 2.0 * CHANGED, norm(mean, std)),
        (CHANGED, norm(mean - FALL, math.hypot(std, FALL_SPREAD))),
        (CHANGED, norm(mean + rise, spread) if rise > 0.0 else norm(mean, std)),
    ]
    middle, told = stated_friction(mean, std, mean + rise, spread, UNKNOWN)

    def share(x):
        return sum(weight * part.cdf(x) for weight, part in parts)

    for chance, end in ((0.025, middle - INSIDE * told), (0.975, middle + INSIDE * told)):
        assert end == pytest.approx(brentq(lambda x, c=chance: share(x) - c, -5.0, 5.0), abs=1e-5)


def test_what_is_stated_of_a_known_friction_and_of_one_that_fell():
    """It may have fallen by a quarter, give or take a tenth, or be back: at a chance of 8 % each."""
    assert stated_friction(-0.3, 0.1, 0.1, 0.05, UNKNOWN) == pytest.approx((-0.248692, 0.190385), abs=1e-6)
    assert stated_friction(-0.3, 0.05, -0.3, 0.05, UNKNOWN) == pytest.approx((-0.404188, 0.102277), abs=1e-6)


def test_of_an_object_that_is_unknown_the_belief_itself_is_stated():
    assert stated_friction(-0.4, 0.4, 0.3, 0.1, UNKNOWN) == (-0.4, 0.4)
    assert stated_friction(-0.4, math.inf, 0.3, 0.1, UNKNOWN) == (-0.4, math.inf)


def test_friction_that_has_not_fallen_may_only_be_less_than_is_believed():
    middle, std = stated_friction(-0.3, 0.1, -0.3, 0.1, UNKNOWN)
    believed = INSIDE * 0.1
    assert middle - INSIDE * std < -0.3 - 1.3 * believed
    assert -0.3 + 0.9 * believed < middle + INSIDE * std <= -0.3 + believed


def test_after_a_fall_the_interval_holds_the_friction_of_before():
    middle, std = stated_friction(-0.6, 0.1, -0.2, 0.1, UNKNOWN)
    assert middle - INSIDE * std < -0.6 < -0.2 < middle + INSIDE * std


def test_the_level_follows_a_rise_at_once_and_a_fall_slowly():
    g = belief(-0.5, 0.1)
    follow_level(g, 0, 0.002)
    assert (g.change.level[0], g.change.spread[0]) == (-0.5, pytest.approx(0.1))
    g.belief.mean[0], g.belief.p[0] = -0.2, 0.05**2
    follow_level(g, 0, 0.002)
    assert (g.change.level[0], g.change.spread[0]) == (-0.2, pytest.approx(0.05))
    g.belief.mean[0] = -0.6
    for _ in range(500):
        follow_level(g, 0, 0.002)
    assert g.change.level[0] == pytest.approx(-0.6 + 0.4 * math.exp(-1.0 / 20.0), abs=1e-6)
    assert g.change.spread[0] == pytest.approx(0.05)


def test_an_object_that_is_unknown_again_has_no_level():
    g = belief(-0.2, 0.1)
    follow_level(g, 0, 0.002)
    g.belief.mean[0], g.belief.p[0] = -0.5, 0.3**2
    follow_level(g, 0, 0.002)
    assert g.change.level[0] == -math.inf


def test_the_first_slip_of_an_object_is_no_fall_from_what_is_usual():
    g = belief(-0.35, 0.4)
    follow_level(g, 0, 0.002)
    g.belief.mean[0], g.belief.p[0] = -1.1, 0.1**2
    follow_level(g, 0, 0.002)
    assert (g.change.level[0], g.change.spread[0]) == (-1.1, pytest.approx(0.1))


def test_a_grasp_that_does_not_share_states_what_is_believed():
    alone = GraspFriction.__new__(GraspFriction)
    alone.active = False
    contact = ContactEstimate(0, "thumb", 0, friction_coefficient=Estimate(0.7, 0.05, valid=True, age=0.0))
    assert alone.state_friction(contact) is contact
