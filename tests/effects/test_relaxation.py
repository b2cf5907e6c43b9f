"""Relaxation branches against the hereditary integral (20), summed term by term."""

import numpy as np
import pytest

from vegrip.effects.power_law_relaxation import RATIO, SLOWEST
from vegrip.effects.relaxation import branch

T = np.arange(0.0, 12.0, 0.01)


def hereditary(t, N_e, g):
    """``N(t) = sum_j g(t - s_j) dN_e(s_j)``, each rise in the middle of its step; O(n^2), no memory."""
    rises = np.diff(N_e, prepend=0.0)
    middles = np.concatenate([[t[0]], 0.5 * (t[1:] + t[:-1])])
    age = np.subtract.outer(t, middles)
    return np.sum(np.where(age >= 0.0, g(np.maximum(age, 0.0)), 0.0) * rises, axis=1)


def never_lifted(t):
    """A depth [m] that rises from 0 and stays in contact."""
    return 8e-4 * (1.2 - np.exp(-t)) * (1.0 + 0.15 * np.sin(1.1 * t)) * (1.0 - np.exp(-3.0 * t))


def power_law(model, delta):
    K, p = model.values["K"].value, model.values["p"].value
    return K * (delta / model.reference_depth) ** p


@pytest.mark.parametrize("h", [1e-14, 1e-10, 0.99e-9, 1.01e-9, 1e-5, 0.3, 40.0])
def test_a_step_of_a_branch_is_two_of_half_its_length_however_short_it_is(h) -> None:
    z, before, after = 0.2, 1.0, 1.6
    whole = branch(z, after, before, 3.0, h / 3.0)
    middle = branch(z, 0.5 * (before + after), before, 3.0, h / 6.0)
    halves = branch(middle, after, 0.5 * (before + after), 3.0, h / 6.0)
    slope = 1.1 if h < 1e-4 else np.nan  # mean of the force, less z, at the beginning
    assert whole - z == pytest.approx(halves - z, rel=1e-3, abs=1e-16)
    assert np.isnan(slope) or whole - z == pytest.approx(slope * h, rel=1e-3, abs=1e-16)
    assert branch(z, after, before, 3.0, 0.0) == z


@pytest.mark.parametrize("name", ["relaxation", "second_relaxation"])
def test_branches_are_the_hereditary_integral(name, model_with):
    model = model_with(name)
    c = [model.values[s].value for s in ("c1", "c2") if s in model.values]
    nu = [model.values[s].value for s in ("nu1", "nu2") if s in model.values]
    delta = never_lifted(T)
    direct = hereditary(
        T,
        power_law(model, delta),
        lambda t: 1.0 - sum(a * (1.0 - np.exp(-r * t)) for a, r in zip(c, nu, strict=True)),
    )
    assert np.abs(model.simulate(T, delta).normal_force - direct).max() < 2e-4 * direct.max()


@pytest.mark.parametrize(("amplitudes", "most"), [((0.05, 0.1, 0.02, 0.0, 0.1), 0.27), ((0.9,) * 5, 0.95)])
def test_a_spectrum_is_the_hereditary_integral_over_its_five_times(amplitudes, most, model_with):
    """Of a force that does not relax besides; a sum of more than 0.95 is scaled to that."""
    model = model_with("relaxation_spectrum").with_value("c1", 0.0)
    for i, c in enumerate(amplitudes, 1):
        model = model.with_value(f"c_s{i}", c)
    shares = most * np.array(amplitudes) / sum(amplitudes)
    rates = model.values["nu_s"].value * 10.0 ** np.arange(5)
    delta = never_lifted(T)
    direct = hereditary(
        T,
        power_law(model, delta),
        lambda t: 1.0 + np.tensordot(shares, np.expm1(-np.multiply.outer(rates, t)), 1),
    )
    assert np.abs(model.simulate(T, delta).normal_force - direct).max() < 2e-3 * direct.max()


@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.3])
def test_log_spaced_branches_are_a_continuous_spectrum(alpha, model_with):
    """``g = 1 - c_P int nu^alpha (1 - exp(-nu t)) dln(nu) / int nu^alpha dln(nu)``, over the same decades."""
    model = model_with("power_law_relaxation").with_value("alpha_P", alpha).with_value("c1", 0.0)
    c_P = model.values["c_P"].value
    edges = np.log([SLOWEST / RATIO**0.5, SLOWEST * RATIO**6.5])
    nu = np.exp(edges[0] + (np.arange(4000) + 0.5) / 4000 * (edges[1] - edges[0]))
    delta = never_lifted(T)
    direct = hereditary(T, power_law(model, delta), lambda t: 1.0 - c_P * relaxed(t, nu, nu**alpha))
    assert np.abs(model.simulate(T, delta).normal_force - direct).max() < 2e-3 * c_P * direct.max()


def relaxed(age, nu, weight):
    """Share of the spectrum that has relaxed at each age; ages repeat, so each is worked out once."""
    ages, back = np.unique(np.round(age, 9), return_inverse=True)
    share = np.array([weight @ -np.expm1(-nu * t) for t in ages]) / weight.sum()
    return share[back].reshape(age.shape)


def test_without_an_exponent_every_decade_relaxes_as_much(model_with):
    model = model_with("power_law_relaxation").with_value("alpha_P", 0.0).with_value("c1", 0.0)
    t = np.concatenate([[0.0, 1e-6], np.logspace(-1, 1, 5)])
    force = model.simulate(t, np.where(t > 0.0, 8e-4, 0.0)).normal_force[2:] / model.values["K"].value
    drops = -np.diff(force)
    np.testing.assert_allclose(drops, drops.mean(), rtol=0.02)
    np.testing.assert_allclose(drops.mean(), model.values["c_P"].value / 7.0 * 1.5 / 2.0, rtol=0.01)


def test_deeper_holds_relax_by_another_fraction(model_with):
    """After a long hold ``N / N_e = 1 - c_1 [1 + beta (x / x_ref - 1)]``."""
    model = model_with("nonseparable_relaxation")
    c, beta = model.values["c1"].value, model.values["beta_x"].value
    for depth in (0.5, 1.0, 2.0):
        delta = depth * model.reference_depth
        force = model.simulate([0.0, 1e-3, 100.0], [0.0, delta, delta]).normal_force[-1]
        left = force / power_law(model, delta)
        assert left == pytest.approx(1.0 - c * (1.0 + beta * (depth - 1.0)), rel=1e-9)


@pytest.mark.parametrize("share", [0.4, 1.0])
def test_depth_at_loading_weighs_the_hereditary_integral(model_with, share):
    """``N = N_e - c int nu e^{-nu (t - s)} [1 + beta ((1 - h) s(t) + h s(s))] N_e(s) ds``, by quadrature."""
    model = model_with("nonseparable_relaxation").with_value("h_x", share)
    c, nu, beta = (model.values[symbol].value for symbol in ("c1", "nu1", "beta_x"))
    t = np.linspace(0.0, 1.5, 6001)
    delta = model.reference_depth * (0.9 + 0.5 * np.sin(5.0 * t) - 0.9 * np.exp(-20.0 * t))
    elastic, deeper = power_law(model, delta), delta / model.reference_depth - 1.0
    kernel = nu * np.exp(-nu * (t[-1] - t))
    weight = 1.0 + beta * ((1.0 - share) * deeper[-1] + share * deeper)
    expected = elastic[-1] - c * np.trapezoid(kernel * weight * elastic, t)
    assert model.simulate(t, delta).normal_force[-1] == pytest.approx(expected, rel=1e-6)


def test_a_smaller_contact_drains_faster_by_the_square_of_its_radius(model_with):
    """``nu = D / a^2``; the rate is read off two instants of a hold."""
    model = model_with("poroelastic_drainage")
    nu, c = model.values["nu1"].value, model.values["c1"].value
    t = np.array([0.0, 1e-6, 0.1, 0.3])
    for depth in (0.25, 1.0, 2.0):
        delta = depth * model.reference_depth
        contact = model.simulate(t, np.where(t > 0.0, delta, 0.0))
        rest = contact.normal_force[2:] - (1.0 - c) * power_law(model, delta)
        at_reference = 2.0 * model.tip_radius * model.reference_depth
        rate = np.log(rest[0] / rest[1]) / 0.2
        assert rate == pytest.approx(nu * at_reference / contact.contact_radius[-1] ** 2, rel=1e-6)


def test_below_a_hundredth_of_the_reference_depth_a_contact_drains_no_faster(model_with):
    model = model_with("poroelastic_drainage")
    nu, c = model.values["nu1"].value, model.values["c1"].value
    for depth, felt in ((0.015, 0.015), (0.0099, 0.01), (0.002, 0.01)):
        t = np.array([0.0, 1e-9, 1e-3, 3e-3])
        contact = model.simulate(t, np.where(t > 0.0, depth * model.reference_depth, 0.0))
        rest = contact.normal_force[2:] - (1.0 - c) * power_law(model, depth * model.reference_depth)
        assert np.log(rest[0] / rest[1]) / 2e-3 == pytest.approx(nu / felt, rel=1e-4)
