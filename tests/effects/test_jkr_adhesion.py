"""JKR adhesion against the equations of Johnson, Kendall and Roberts (1971), solved here for the radius."""

import numpy as np
import pytest
from scipy.optimize import brentq

from vegrip.effects import effect

R, DEPTH = 0.008, 0.0008


@pytest.fixture
def model(model_with):
    """A sphere without relaxation, whose radius is Hertz's."""
    model = model_with("jkr_adhesion").with_effect(effect("contact_radius_law"))
    for symbol, value in {"g_J": 0.0, "c1": 0.0, "p": 1.5, "kappa": 1.0, "chi": 0.0}.items():
        model = model.with_value(symbol, value)
    return model


@pytest.fixture
def sphere(model):
    """w [J/m^2] and K* [Pa], as the effect's text gives them."""
    K = model.values["K"].value
    return model.values["w_J"].value * K / (1.5 * np.pi * R), K / (np.sqrt(R) * DEPTH**1.5)


def jkr(w, modulus, x):
    """Radius and force at a displacement, by their equations in N and a: the branch of the wide contact."""

    def depth(a):
        return a * a / R - 2.0 / 3.0 * np.sqrt(6.0 * np.pi * w * a / modulus)

    a = brentq(lambda a: depth(a) - x, (np.pi * w * R * R / (6.0 * modulus)) ** (1.0 / 3.0), R, xtol=1e-15)
    return a, modulus * a**3 / R - np.sqrt(6.0 * np.pi * w * modulus * a**3)


def test_force_and_radius_are_those_of_the_theory(model, sphere):
    delta = DEPTH * np.concatenate([np.linspace(0.0, 2.0, 41), np.linspace(2.0, -0.09, 60)])
    found = model.simulate(np.arange(float(delta.size)), delta)
    a, force = np.array([jkr(*sphere, x) for x in delta]).T
    np.testing.assert_allclose(found.contact_radius, a, rtol=1e-9)
    np.testing.assert_allclose(found.sensed_force, force, atol=1e-4 * np.abs(force).max())


def test_it_jumps_in_with_less_than_it_pulls_off_with_and_lets_go_later(model, sphere):
    w, modulus = sphere
    pull_off = 1.5 * np.pi * w * R
    parting = 3.0 * (np.pi * w * np.sqrt(R) / (6.0 * modulus)) ** (2.0 / 3.0)
    at = np.array([-0.01 * parting, 0.0, DEPTH, 0.0, -0.99 * parting, -1.01 * parting, -0.5 * parting])
    force = model.simulate(np.arange(7.0), at).sensed_force
    assert force[0] == 0.0
    assert force[[1, 3]] == pytest.approx(-8.0 / 9.0 * pull_off, rel=1e-4)
    assert -pull_off < force[4] < 0.0
    np.testing.assert_array_equal(force[5:], 0.0)
    way = np.concatenate([[0.5 * DEPTH], np.linspace(0.3 * DEPTH, -parting, 4000)])
    least = model.simulate(np.arange(4001.0), way).sensed_force.min()
    assert least == pytest.approx(-pull_off, rel=1e-4)


def test_the_contact_at_no_load_has_the_radius_of_the_theory(model, sphere):
    w, modulus = sphere
    a = (6.0 * np.pi * w * R * R / modulus) ** (1.0 / 3.0)
    x = a * a / R - 2.0 / 3.0 * np.sqrt(6.0 * np.pi * w * a / modulus)
    found = model.simulate([0.0, 1.0], [0.0, x])
    assert found.contact_radius[-1] == pytest.approx(a, rel=1e-9)
    assert found.sensed_force[-1] == pytest.approx(0.0, abs=1e-5 * model.values["K"].value)


def test_work_grows_by_a_power_of_the_speed_of_retraction(model):
    """The jump at x = 0 is -8/9 of F on the way in, and of the grown F on the way out."""
    model = model.with_value("g_J", 0.3)
    jump = []
    for speed in (0.01, 1.0):
        t = np.array([0.0, 1.0, 1.0 + 0.5 / speed])
        jump.append(model.simulate(t, DEPTH * np.array([0.0, 0.5, 0.0])).sensed_force[[0, -1]])
    (slow_in, slow), (_, fast) = jump
    assert [slow / slow_in - 1.0, fast / slow_in - 1.0] == pytest.approx([0.03, 0.3], rel=1e-3)
