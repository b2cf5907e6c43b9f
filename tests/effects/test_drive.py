"""What lies between the measured displacement and the tip, against independent solutions."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vegrip.effects import effect

DEPTH = 0.0008


def test_a_linear_contact_on_a_compliant_mount_is_two_springs_in_series(model_with):
    model = model_with("series_compliance").with_value("p", 1.0).with_value("c1", 0.0)
    k = model.values["K"].value / DEPTH
    C = model.values["s_C"].value / k
    delta = np.linspace(0.0, 2.0 * DEPTH, 9)
    force = model.simulate(np.arange(9.0), delta).normal_force
    np.testing.assert_allclose(force, delta / (1.0 / k + C), rtol=1e-12)


def test_a_compliant_mount_gives_way_by_the_force_it_carries(model_with):
    """A relaxing contact: x from a root finder at every instant, the branch by fine quadrature of its ODE."""
    model = model_with("series_compliance")
    K, p, c, nu = (model.values[s].value for s in ("K", "p", "c1", "nu1"))
    C = model.values["s_C"].value * DEPTH / K

    def elastic(x):
        return K * (max(x, 0.0) / DEPTH) ** p

    def depth(t):
        return 1.5 * DEPTH * (1.0 - np.exp(-2.0 * t))

    def carried(t, z):
        return brentq(lambda x: x + C * (elastic(x) - c * z) - depth(t), 0.0, 2.0 * DEPTH, xtol=1e-16)

    t = np.linspace(0.0, 3.0, 3001)
    z = solve_ivp(
        lambda s, z: nu * (elastic(carried(s, z[0])) - z), (0.0, 3.0), [0.0], t_eval=t, rtol=1e-8
    ).y[0]
    x = np.array([carried(s, m) for s, m in zip(t, z, strict=True)])
    found = model.simulate(t, depth(t))
    assert np.abs(found.indentation - x).max() < 1e-5 * DEPTH
    assert np.abs(found.normal_force - (depth(t) - x) / C)[1:].max() < 1e-4 * K


def test_relaxation_deepens_a_contact_held_by_a_compliant_mount(model_with):
    model = model_with("series_compliance")
    held = model.simulate([0.0, 0.01, 5.0], [0.0, DEPTH, DEPTH])
    assert held.indentation[2] > held.indentation[1]
    assert held.normal_force[2] < held.normal_force[1]


def test_play_follows_only_across_its_gap(model_with):
    """Loading runs half a gap behind, unloading half a gap ahead, and between them the tip rests."""
    model = model_with("displacement_backlash").with_value("play", 0.2)
    delta = DEPTH * np.array([0.0, 0.5, 1.0, 0.95, 0.85, 0.8, 0.5, 0.55, 0.65, 0.7, 0.9])
    expected = DEPTH * np.array([0.0, 0.4, 0.9, 0.9, 0.9, 0.9, 0.6, 0.6, 0.6, 0.6, 0.8])
    np.testing.assert_allclose(model.simulate(np.arange(11.0), delta).indentation, expected, atol=1e-18)


def test_play_does_not_know_time(model_with):
    model = model_with("displacement_backlash")
    delta = DEPTH * np.sin(np.linspace(0.0, 20.0, 300))
    slow, fast = (model.simulate(np.arange(300) * dt, delta).indentation for dt in (1.0, 1e-4))
    np.testing.assert_array_equal(slow, fast)


def test_set_follows_the_deepest_point_beyond_the_yield_depth(model_with):
    model = model_with("permanent_set").with_value("r_p", 0.0)
    alpha, at = model.values["alpha_p"].value, model.values["x_y"].value * DEPTH
    delta = DEPTH * np.cumsum(np.random.default_rng(5).normal(0.0, 0.3, 200))
    deepest = np.array([max(delta[: i + 1].max(), 0.0) for i in range(delta.size)])
    expected = delta - alpha * np.maximum(deepest - at, 0.0)
    np.testing.assert_allclose(model.simulate(np.arange(200.0), delta).indentation, expected, atol=1e-18)


def test_set_creeps_in_contact_as_its_differential_equation(model_with):
    """``d d_c / dt = r (delta - d_c)`` while that is positive, by an adaptive integrator."""
    model = model_with("permanent_set").with_value("alpha_p", 0.0).with_value("r_p", 0.1)

    def depth(t):
        return DEPTH * np.sin(0.7 * t)

    t = np.linspace(0.0, 20.0, 20001)
    crept = solve_ivp(
        lambda s, d: 0.1 * np.maximum(depth(s) - d, 0.0), (0.0, 20.0), [0.0], t_eval=t, max_step=0.01
    ).y[0]
    np.testing.assert_allclose(model.simulate(t, depth(t)).indentation, depth(t) - crept, atol=1e-3 * DEPTH)


@pytest.mark.parametrize("steps", [1, 7])
def test_a_set_creeps_towards_the_depth_that_yielding_has_left(steps: int) -> None:
    """``d d_c / dt = r (delta - d_y - d_c)``: after t it is ``(delta - d_y)(1 - exp(-r t))`` in any steps."""
    depth, yields, rate, time = 1e-3, 0.2 * (1e-3 - 0.3 * 0.8e-3), 0.4, 3.0
    crept = 0.0
    for _ in range(steps):
        left, _, crept = (
            effect("permanent_set")
            .hooks[0]
            .function(depth, time / steps, 0.8e-3, 0.2, 0.3, rate, depth, crept)
        )
    expected = (depth - yields) * -math.expm1(-rate * time)
    assert crept == pytest.approx(expected, rel=1e-12)
    assert left == pytest.approx(depth - yields - expected, rel=1e-12)


@pytest.mark.parametrize("name", ["permanent_set", "mullins_softening"])
def test_wear_outlasts_the_contact_that_made_it(name, model_with):
    """The same light touch is weaker after a deep press and a day of rest."""
    model, hour = model_with(name), 3600.0
    t = np.array([0.0, 1.0, 2.0, hour, hour + 1.0, hour + 2.0, 25 * hour, 25 * hour + 1.0])
    force = model.simulate(t, DEPTH * np.array([0.0, 0.5, 0.0, 0.0, 2.0, 0.0, 0.0, 0.5])).normal_force
    assert force[-1] < 0.999 * force[1]
