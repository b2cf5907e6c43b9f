"""The compiled model against the paper, direct integrals and itself uncompiled."""

import numpy as np
import pytest
from scipy.integrate import quad

from vegrip.contact.coupling import exponent_from_coefficient
from vegrip.contact.pressure import coefficient
from vegrip.effects import effect
from vegrip.effects.pressure_coupling import excess_of, exponent_of
from vegrip.model import ContactModel, paper_model

R = 8e-3


@pytest.fixture(scope="module")
def model() -> ContactModel:
    return paper_model(R)


def test_ramp_agrees_with_the_hereditary_integral(model: ContactModel) -> None:
    t = np.linspace(0.0, 2.0, 4001)
    speed = 5e-4
    N = model.simulate(t, speed * t).normal_force
    K, p = model.values["K"].value, model.values["p"].value
    c, nu = model.values["c1"].value, model.values["nu1"].value

    def slope(s: float) -> float:
        return K * p * (speed * s / model.reference_depth) ** (p - 1.0) * speed / model.reference_depth

    for i in (500, 1700, 4000):
        wanted = quad(lambda s, i=i: (1.0 - c + c * np.exp(-nu * (t[i] - s))) * slope(s), 0.0, t[i])[0]
        assert N[i] == pytest.approx(wanted, rel=2e-6)


def test_golden_ramp_of_a_linear_contact(model: ContactModel) -> None:
    """m = v = t = 1, c1 = 0.3, nu1 = 3.1: N = 0.7924145933, any number of steps."""
    linear = paper_model(1.0).with_value("p", 1.0).with_value("K", 1.0, high=1e9)
    for steps in (1, 7, 100):
        t = np.linspace(0.0, 1.0, steps + 1)
        depth = linear.reference_depth * t  # K of force
        assert linear.simulate(t, depth).normal_force[-1] == pytest.approx(0.7924145933, abs=1e-10)


def test_uneven_steps_change_nothing_in_a_hold(model: ContactModel) -> None:
    rng = np.random.default_rng(3)
    coarse = np.array([0.0, 1e-9, 5.0])
    fine = np.concatenate([[0.0, 1e-9], np.sort(rng.uniform(1e-8, 5.0, 300)), [5.0]])
    held = model.simulate(coarse, np.array([0.0, 1e-3, 1e-3])).normal_force[-1]
    delta = np.full(fine.size, 1e-3)
    delta[0] = 0.0
    assert model.simulate(fine, delta).normal_force[-1] == pytest.approx(held, rel=1e-12)


def test_force_is_continuous_when_contact_is_made_and_broken(model: ContactModel) -> None:
    t = np.linspace(0.0, 4.0, 40001)
    delta = 5e-4 * np.sin(2.0 * np.pi * 1.3 * t)
    N = model.simulate(t, delta).normal_force
    assert N.min() == 0.0
    assert np.abs(np.diff(N)).max() < 3e-3 * N.max()


def test_surface_recovers_and_contact_returns_late(model: ContactModel) -> None:
    """After a long hold a withdrawn tip meets the object again only where the surface has come back to."""
    t = np.concatenate(
        [np.linspace(0, 5, 5001), 5 + np.linspace(1e-3, 0.1, 100), 5.1 + np.linspace(1e-3, 1, 1000)]
    )
    delta = np.interp(t, [0.0, 0.1, 5.0, 5.001, 5.1, 6.1], [0.0, 1e-3, 1e-3, 0.0, 0.0, 1e-3])
    N = model.simulate(t, delta).normal_force
    first_contact = delta[(t > 5.1) & (N > 0.0)][0]
    assert 1e-5 < first_contact < 4e-4


def test_compiled_and_plain_runs_are_identical(model: ContactModel) -> None:
    rng = np.random.default_rng(0)
    t = np.cumsum(rng.uniform(1e-4, 5e-3, 800))
    delta = 8e-4 * np.sin(9.0 * t) + 2e-5 * rng.standard_normal(t.size)
    more = model.with_effect(effect("second_relaxation"))
    for one in (model, more):
        for fast, slow in zip(one.simulate(t, delta), one.simulate(t, delta, plain=True), strict=True):
            np.testing.assert_allclose(fast, slow, rtol=1e-12, atol=1e-15)


def test_exponent_stays_in_a_held_indentation_and_creeps_under_load(model: ContactModel) -> None:
    t = np.linspace(0.0, 6.0, 12001)
    held = model.simulate(t, np.interp(t, [0.0, 1e-3, 6.0], [0.0, 1e-3, 1e-3])).pressure_exponent
    assert held[3:] == pytest.approx(held[3], rel=1e-9)
    conventional = np.interp(t, [0.0, 0.05, 6.0], [0.0, 1e-3, 1.3e-3])  # creeps on
    assert np.all(np.diff(model.simulate(t, conventional).pressure_exponent[200:]) > 0.0)


def test_exponent_is_the_inverse_of_the_pressure_coefficient() -> None:
    excess = np.geomspace(1e-4, 2.0, 200)
    ours = np.array([exponent_of(float(e)) for e in excess])
    np.testing.assert_allclose(ours, exponent_from_coefficient(1.0 + excess), rtol=3e-6)
    assert exponent_of(float(coefficient(2.0)) - 1.0) == pytest.approx(2.0, rel=1e-6)


def test_the_quick_pressure_coefficient_is_that_of_the_gamma_functions() -> None:
    k = np.linspace(1.0, 20.0, 200)
    ours = np.array([excess_of(float(one)) for one in k])
    np.testing.assert_allclose(ours, [float(coefficient(one)) - 1.0 for one in k], rtol=3e-7)
    assert excess_of(0.5) == excess_of(0.0) == excess_of(-1.0) == excess_of(1.0)  # held


def test_conventional_parameters_give_the_papers_law(model: ContactModel) -> None:
    K, p = model.values["K"].value, model.values["p"].value
    m, b = K * p / model.reference_depth**p, p - 1.0
    x = 7e-4
    N = model.simulate([0.0, 1e-12], [0.0, x]).elastic_force[-1]
    assert m * x ** (b + 1.0) / (b + 1.0) == pytest.approx(N, rel=1e-12)


def test_a_simulation_is_shown_in_a_line_without_its_arrays(model: ContactModel) -> None:
    t = np.linspace(0.0, 1.0, 50)
    shown = repr(model.simulate(t, 1e-3 * t))
    assert shown.startswith("<Simulation: 50 rows, indentation to 0.001 m, normal force to ")
    assert "array" not in shown
    assert "\n" not in shown
