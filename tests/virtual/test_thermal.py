"""Slow warming."""

import math

import pytest

from vegrip.virtual.fingertip import Warming
from vegrip.virtual.settings import ThermalSettings

ON = ThermalSettings(warming=True, start=20.0, rise=10.0, time=100.0, softening=0.01, quickening=0.05)


def test_temperature_rises_exponentially() -> None:
    warming = Warming(ON)
    assert warming.temperature(0.0) == 20.0
    assert warming.temperature(100.0) == pytest.approx(20.0 + 10.0 * (1.0 - math.exp(-1.0)))


def test_temperature_is_constant_when_off() -> None:
    assert Warming(ThermalSettings(start=20.0)).temperature(1e4) == 20.0


def test_material_changes_only_when_it_has_become_noticeably_warmer() -> None:
    warming = Warming(ON)
    assert warming.material(0.1) is None
    assert warming.material(1e6) == pytest.approx((math.exp(-0.1), math.exp(0.5)))
    assert warming.material(1e6) is None
