"""The two controllers of common practice."""

import pytest

from vegrip.control.baselines import ConeSettings, ConstantGrip, ConstantSettings, FrictionCone
from vegrip.control.demand import Demand
from vegrip.messages import Reason


def test_the_constant_grip_ignores_the_load() -> None:
    grip = ConstantGrip(ConstantSettings(force=4.0))
    assert grip.wanted(1.0, Demand(tangential_force=99.0), 0.01) == (4.0, Reason.RAISE)
    assert grip.wanted(4.0, Demand(), 0.01) == (4.0, Reason.HOLD)


def test_the_cone_keeps_its_safety_at_every_load() -> None:
    cone = FrictionCone(ConeSettings(friction=0.5, safety=0.25))
    for load in (0.0, 0.3, 7.0):
        force, _ = cone.wanted(1.0, Demand(tangential_force=load), 0.01)
        assert load == pytest.approx(0.5 * force / 1.25)


def test_the_cone_holds_when_the_load_is_not_measured() -> None:
    assert FrictionCone(ConeSettings()).wanted(2.0, Demand(), 0.01) == (2.0, Reason.UNTRUSTED)
