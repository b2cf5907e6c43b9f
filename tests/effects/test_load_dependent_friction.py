"""Friction that falls with load."""

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.estimator.layout import layout_of
from vegrip.model import paper_model, predict

T = np.arange(0.0, 0.2, 5e-3)
MODEL = paper_model(0.01).with_effect(effect("load_dependent_friction")).with_value("g_N", 0.2)


def slip_limit(model, depth):
    columns = {"t": T, "displacement": np.full_like(T, depth), "tangential_force_x": np.full_like(T, 0.1)}
    table = predict(model, columns, plain=True)
    return table["contact_force"][-1], table["tangential_force"][-1]


def test_slip_force_over_load_falls_as_a_power_of_the_load() -> None:
    loads, limits = np.array([slip_limit(MODEL, depth) for depth in (2e-4, 5e-4, 1e-3, 2e-3)]).T
    slope = np.diff(np.log(limits / loads)) / np.diff(np.log(loads))
    assert slope == pytest.approx(-0.2)


def test_at_the_reference_load_friction_is_mu() -> None:
    K = MODEL.values["K"].value
    columns = {"t": T, "displacement": np.full_like(T, 1e-3), "normal_force": np.full_like(T, K)}
    table = predict(MODEL, columns, plain=True)
    assert table["friction_coefficient"] == pytest.approx(np.full_like(T, 0.7))


def test_a_smooth_sphere_of_constant_shear_strength_has_the_exponent_one_third() -> None:
    """f = tau pi a^2 with Hertz' a^2 = (3 R N / 4 E)^(2/3)."""
    model = MODEL.with_value("g_N", 1.0 / 3.0)
    loads, limits = np.array([slip_limit(model, depth) for depth in (3e-4, 1e-3, 2e-3)]).T
    areas = np.pi * (3.0 * 0.01 * loads / (4.0 * 3e5)) ** (2.0 / 3.0)
    assert limits / areas == pytest.approx(np.full(3, limits[0] / areas[0]))


def test_friction_stays_finite_at_first_touch() -> None:
    load, limit = slip_limit(MODEL, 1e-9)
    assert 0.0 < limit / load < 4.0 * 0.7


def test_estimator_still_learns_mu_as_the_friction_coefficient() -> None:
    """And K, which friction now takes as its reference, from the force."""
    layout, symbols = layout_of(MODEL), list(MODEL.parameters)
    assert symbols[layout.mu] == "mu"
    assert symbols.index("K") in layout.learned
    assert symbols.index("g_N") in layout.considered
