"""Elastic laws and their modifications against formulas written out here; without relaxation (c_1 = 0)."""

import numpy as np
import pytest

R, DEPTH = 0.008, 0.0008


def force_of(model, delta):
    """Normal force along a path of displacements [m], a second apart."""
    return model.with_value("c1", 0.0).simulate(np.arange(len(delta)), delta).normal_force


def test_with_a_linear_power_law_it_is_the_exponential_law_of_the_paper(model_with):
    """Eq. (13), ``(m / b) (e^(b delta) - 1)``."""
    model = model_with("exponential_stiffness").with_value("p", 1.0)
    m, b = model.values["K"].value / DEPTH, model.values["b_x"].value / DEPTH
    delta = np.linspace(0.0, 2.5 * DEPTH, 40)
    np.testing.assert_allclose(force_of(model, delta), m / b * (np.exp(b * delta) - 1.0), rtol=1e-12)


def test_a_thin_layer_follows_the_polynomial_of_its_thickness(model_with):
    """Hertz times the factor of Dimitriadis et al. (2002), coefficients as printed there."""
    model = model_with("layer_over_core").with_value("K_c", 0.0)
    H = R / model.values["R_H"].value
    delta = np.linspace(0.0, 2.0 * DEPTH, 30)
    factor = np.polyval([0.0975, 0.769, 1.283, 1.133, 1.0], np.sqrt(R * delta) / H)
    hertz = model.values["K"].value * (delta / DEPTH) ** 1.5
    np.testing.assert_allclose(force_of(model, delta), hertz * factor, rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "stiffness", "depth", "fixed", "exponent"),
    [
        ("layer_over_core", "K_c", "x_c", {"R_H": 0.0}, 1.5),
        ("second_contact", "K_2", "x_2", {"p_2": 1.0}, 1.0),
        ("second_contact", "K_2", "x_2", {"p_2": 1.5}, 1.5),
    ],
)
def test_what_is_touched_at_a_depth_adds_its_own_law_from_there_on(
    name, stiffness, depth, fixed, exponent, model_with
):
    model = model_with(name)
    for symbol, value in fixed.items():
        model = model.with_value(symbol, value)
    K, at = model.values["K"].value, model.values[depth].value * DEPTH
    delta = np.linspace(0.0, 3.0 * DEPTH, 60)
    soft = K * (delta / DEPTH) ** 1.5
    second = np.zeros(60)
    second[delta > at] = model.values[stiffness].value * K * ((delta[delta > at] - at) / DEPTH) ** exponent
    np.testing.assert_allclose(force_of(model, delta), soft + second, rtol=1e-12)


@pytest.mark.parametrize("linear", [0.0, 0.4, 1.0])
def test_softening_depends_on_the_deepest_point_of_the_whole_history(linear, model_with):
    """Mullins against the running maximum of a random walk."""
    model = model_with("mullins_softening").with_value("l_m", linear)
    r, w = model.values["r_m"].value, model.values["w_m"].value * DEPTH
    delta = DEPTH * np.abs(np.cumsum(np.random.default_rng(3).normal(0.0, 0.3, 200)))
    deepest = np.array([delta[: i + 1].max() for i in range(delta.size)])
    factor = 1.0 - r * ((1.0 - linear) * np.tanh((deepest - delta) / w) + linear * (1.0 - delta / deepest))
    virgin = model.values["K"].value * (delta / DEPTH) ** 1.5
    np.testing.assert_allclose(force_of(model, delta), virgin * factor, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("pause", [1.0, 100.0])
def test_a_pause_heals_the_deepest_point_exponentially(pause, model_with):
    """After it the force is that of Mullins softening whose deepest point is ``exp(-nu t)`` as deep."""
    healing, lasting = model_with("healing_softening"), model_with("mullins_softening")
    kept = np.exp(-healing.values["nu_h"].value * pause)
    t = np.array([0.0, 1e-9, 2e-9, 2e-9 + 0.5 * pause, 2e-9 + pause, 3e-9 + pause])
    t[-1] += 1e-6
    found = healing.simulate(t, DEPTH * np.array([0.0, 2.0, -0.1, -0.1, -0.1, 0.3])).elastic_force[-1]
    t = np.array([0.0, 1.0, 2.0, 3.0])
    expected = lasting.simulate(t, DEPTH * np.array([0.0, 2.0 * kept, -0.1, 0.3])).elastic_force[-1]
    assert found == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("speed", [1e-5, 1e-4, 1e-3])
def test_loading_stiffens_by_the_same_factor_per_decade_and_unloading_does_not(speed, model_with):
    """``1 + r log10(1 + v / v_0)`` over the ramp without the effect."""
    model = model_with("rate_stiffening")
    r, v_0 = model.values["r_v"].value, model.values["v_r"].value * DEPTH
    t = np.array([0.0, 0.5, 1.0, 1.5]) * DEPTH / speed
    delta = np.array([0.0, 0.5, 1.0, 0.5]) * DEPTH
    ratio = (
        model.simulate(t, delta).normal_force[1:]
        / model_with("relaxation").simulate(t, delta).normal_force[1:]
    )
    factor = 1.0 + r * np.log10(1.0 + speed / v_0)
    np.testing.assert_allclose(ratio, [factor, factor, 1.0], rtol=1e-9)


def test_damping_is_the_stiffness_times_the_speed(model_with):
    """``eta K(x) v`` with ``K(x) = p N_e / x``."""
    model, speed = model_with("fast_damping").with_value("c1", 0.0), 2e-3
    K, p = model.values["K"].value, model.values["p"].value
    t = np.linspace(0.0, DEPTH / speed, 50)[1:]
    N_e = K * (speed * t / DEPTH) ** p
    damping = model.values["eta"].value * p * N_e / (speed * t) * speed
    found = model.simulate(np.concatenate([[0.0], t]), speed * np.concatenate([[0.0], t])).normal_force[1:]
    np.testing.assert_allclose(found, N_e + damping, rtol=1e-4)  # the model differentiates numerically


def test_arrhenius_is_the_shift_with_the_reference_temperature(model_with):
    """``nu / nu_ref = exp[E / R_g (1 / T_ref - 1 / T)]``, read off a hold; ``E = s R_g T_ref^2 ln 10``."""
    gas, T_ref, energy = 8.314462618, 273.15 + 23.0, 5e4
    model = model_with("temperature_shift").with_value("alpha_T", 0.0).with_value("C_2", T_ref)
    model = model.with_value("s_T", energy / (gas * T_ref**2 * np.log(10.0)))
    K, c = model.values["K"].value, model.values["c1"].value
    for celsius in (5.0, 23.0, 40.0):
        t = np.array([0.0, 1e-9, 0.05, 0.15])
        force = model.simulate(t, np.where(t > 0.0, DEPTH, 0.0), temperature=celsius).normal_force
        rest = force[2:] - (1.0 - c) * K
        expected = np.exp(energy / gas * (1.0 / T_ref - 1.0 / (celsius + 273.15)))
        assert np.log(rest[0] / rest[1]) / 0.1 == pytest.approx(
            model.values["nu1"].value * expected, rel=1e-6
        )


def test_the_shift_is_that_of_williams_landel_and_ferry(model_with):
    """``log10 a_T = -C_1 dT / (C_2 + dT)`` with the universal constants 17.44 and 51.6 K."""
    C_1, C_2, dT = 17.44, 51.6, 6.0
    model = model_with("temperature_shift").with_value("C_2", C_2).with_value("s_T", C_1 / C_2)
    K, c = model.values["K"].value, model.values["c1"].value
    t = np.array([0.0, 1e-9, 1e-3, 3e-3])
    force = model.simulate(t, np.where(t > 0.0, DEPTH, 0.0), temperature=23.0 + dT).normal_force
    N_e = K * (1.0 - model.values["alpha_T"].value * dT)
    rest = force[2:] - (1.0 - c) * N_e
    rate = model.values["nu1"].value * 10.0 ** (C_1 * dT / (C_2 + dT))
    assert np.log(rest[0] / rest[1]) / 2e-3 == pytest.approx(rate, rel=1e-4)
