"""The three controllers of common practice."""

import math

import pytest

from tests.grip.stages import Policy
from vegrip.contact.limit_surface.fast import gauge
from vegrip.grip.policies.baselines import ElasticSettings
from vegrip.grip.policies.demand import Demand
from vegrip.messages import Reason


def test_the_constant_grip_ignores_the_load() -> None:
    grip = Policy("constant", policy_settings={"force": 4.0})
    assert grip.wanted(1.0, Demand(tangential_force=99.0), 0.01) == (4.0, Reason.RAISE)
    assert grip.wanted(4.0, Demand(), 0.01) == (4.0, Reason.HOLD)


def test_the_cone_keeps_its_safety_at_every_load() -> None:
    cone = Policy("cone", policy_settings={"friction": 0.5, "safety": 0.25})
    for load in (0.0, 0.3, 7.0):
        force, _ = cone.wanted(1.0, Demand(tangential_force=load), 0.01)
        assert load == pytest.approx(0.5 * force / 1.25)


def test_the_cone_holds_when_the_load_is_not_measured() -> None:
    assert Policy("cone").wanted(2.0, Demand(), 0.01) == (2.0, Reason.UNTRUSTED)


def test_the_elastic_surface_is_a_tenth_above_its_limit_at_every_load() -> None:
    settings = ElasticSettings(friction=0.6)
    assert (settings.power, settings.exponent) == (1.0 / 3.0, 4.0)  # Hertz, and its pressure
    for load, torque in ((0.5, 0.0), (1.5, 2e-3), (0.2, 8e-3)):
        demand = Demand(tangential_force=load, torque=torque)
        force, _ = Policy("elastic", policy_settings={"friction": 0.6}).wanted(1.0, demand, 0.01)
        N = force / 1.1
        a = settings.radius * N**settings.power
        used = gauge(settings.exponent, load / (0.6 * N), torque / (0.6 * N * a))
        assert used == pytest.approx(1.0, rel=1e-6)


def test_the_elastic_surface_takes_a_torque_that_is_not_measured_for_none() -> None:
    grip = Policy("elastic", policy_settings={"friction": 0.5, "safety": 0.0})
    force, _ = grip.wanted(1.0, Demand(tangential_force=1.0), 0.01)
    assert force == pytest.approx(2.0)


def test_the_elastic_surface_holds_when_the_load_is_not_measured() -> None:
    demand = Demand(torque=1e-3)
    assert math.isnan(demand.tangential_force)
    assert Policy("elastic").wanted(2.0, demand, 0.01) == (2.0, Reason.UNTRUSTED)
