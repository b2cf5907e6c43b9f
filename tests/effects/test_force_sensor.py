"""What the force sensor makes of the force; against filters, clips and derivatives of other packages."""

import numpy as np
import pytest
from scipy import signal

DEPTH = 0.0008
AIR = -5.0 * DEPTH


def test_a_lag_is_the_first_order_filter(model_with):
    """Against scipy's linear simulation, which is exact for piecewise linear input too."""
    model = model_with("sensor_lag").with_value("tau", 0.02)
    t = np.arange(0.0, 3.0, 0.004)
    felt = model.simulate(t, DEPTH * np.sin(5.0 * t))
    _, shown, _ = signal.lsim(signal.TransferFunction([1.0], [0.02, 1.0]), felt.normal_force, t)
    np.testing.assert_allclose(felt.sensed_force, shown, atol=1e-12)


@pytest.mark.parametrize("hertz", [1.0, 8.0, 20.0])
def test_a_lag_trails_by_its_angle_and_amplitude(hertz, model_with):
    """``1 / (1 + i w tau)`` for a small sine on a deep, elastic hold."""
    model = model_with("sensor_lag").with_value("c1", 0.0)
    w, tau = 2.0 * np.pi * hertz, model.values["tau"].value
    t = np.arange(0.0, 4.0, 2e-4)
    found = model.simulate(t, DEPTH * (1.0 + 1e-3 * np.sin(w * t)))
    late = t >= 1.0
    turn = np.exp(-1j * w * t[late])
    shown, felt = (
        np.mean((f[late] - f[late].mean()) * turn) for f in (found.sensed_force, found.normal_force)
    )
    assert shown / felt == pytest.approx(1.0 / (1.0 + 1j * w * tau), rel=2e-3)


def test_a_sample_more_or_less_changes_no_lag(model_with):
    """Irregular steps give the same sensor, to the error of the hold."""
    model = model_with("sensor_lag")
    rng = np.random.default_rng(2)
    t = np.sort(np.concatenate([np.linspace(0.0, 1.0, 501), rng.uniform(0.0, 1.0, 300)]))
    both = [
        model.simulate(s, DEPTH * (1.0 - np.cos(6.0 * s))).sensed_force
        for s in (t, np.linspace(0.0, 1.0, 501))
    ]
    at = np.searchsorted(t, np.linspace(0.0, 1.0, 501))
    np.testing.assert_allclose(both[0][at], both[1], atol=2e-5 * both[1].max())


@pytest.mark.parametrize("late", [4e-3, 0.03])
def test_a_delay_shows_what_was(late, model_with):
    """Presses and sines up to a third of a turn of 1 / T, at uneven steps; jerks ring by little."""
    model = model_with("sensor_delay").with_value("T_y", late)
    t = np.cumsum(np.random.default_rng(3).uniform(0.5, 1.5, 3000)) * 2e-3
    wave = np.sin(2.0 * np.pi * np.minimum(0.25 / late, 10.0) * t)
    depth = np.interp(
        t % 2.0, [0.0, 0.3, 0.4, 1.4, 1.5, 2.0], DEPTH * np.array([-0.2, -0.2, 1.0, 1.0, -0.2, -0.2])
    )
    found = model.simulate(t, depth + 0.02 * DEPTH * wave)
    error = found.sensed_force - np.interp(t - late, t, found.normal_force)
    assert np.abs(error[t > 0.1]).max() < 0.04 * found.normal_force.max()
    assert np.sqrt(np.mean(error[t > 0.1] ** 2)) < 0.01 * found.normal_force.max()


def test_a_lag_of_the_displacement_leads_by_its_time_and_touches_earlier(model_with):
    model = model_with("displacement_lag").with_value("tau_d", 0.01)
    t = np.arange(0.0, 1.0, 1e-3)
    depth = DEPTH * (2.0 * t - 1.0)
    ahead = model.with_value("tau_d", 0.0).simulate(t, depth + 0.02 * DEPTH).normal_force
    np.testing.assert_allclose(model.simulate(t, depth).normal_force[1:], ahead[1:], atol=1e-9)


def test_drift_is_seen_in_air(model_with):
    model = model_with("force_drift")
    t = np.array([0.0, 10.0, 1000.0])
    rate = model.values["r_F"].value * model.values["K"].value
    np.testing.assert_allclose(model.simulate(t, AIR + 0.0 * t).sensed_force, rate * t, rtol=1e-12)


def test_guide_friction_has_the_sign_of_the_motion_in_air(model_with):
    model = model_with("guide_friction")
    F, v_0 = model.values["F_g"].value * model.values["K"].value, model.values["v_g"].value * DEPTH
    speed = np.array([20.0, -20.0, 0.5, -0.5, 0.0]) * v_0
    shown = model.simulate(np.arange(6.0), AIR + np.concatenate([[0.0], np.cumsum(speed)])).sensed_force[1:]
    np.testing.assert_allclose(shown, F * np.array([1.0, -1.0, 0.46211716, -0.46211716, 0.0]), rtol=1e-8)


def test_cross_talk_follows_the_tangential_force(model_with):
    model = model_with("cross_talk")
    load = np.array([0.0, 0.1, 0.4])
    found = model.simulate([0.0, 1.0, 2.0], [DEPTH] * 3, tangential_force=load)
    np.testing.assert_allclose(
        found.sensed_force - found.normal_force, model.values["c_f"].value * load, atol=1e-16
    )


def test_inertia_is_mass_times_acceleration_at_any_spacing(model_with):
    """A constant acceleration in air, with jittered steps."""
    model = model_with("inertia")
    mass = model.values["M_K"].value * model.values["K"].value / DEPTH
    t = np.cumsum(np.random.default_rng(4).uniform(1e-3, 5e-3, 200))
    shown = model.simulate(t, AIR - 0.5 * 3.0 * t**2).sensed_force[3:]
    np.testing.assert_allclose(shown, -3.0 * mass, rtol=1e-6)


def test_inertia_of_a_sine_in_air_is_the_square_of_its_frequency(model_with):
    model = model_with("inertia")
    mass = model.values["M_K"].value * model.values["K"].value / DEPTH
    t = np.arange(0.0, 1.0, 1e-4)
    shown = model.simulate(t, AIR + DEPTH * np.sin(60.0 * t)).sensed_force[2:]
    np.testing.assert_allclose(
        shown, -mass * 60.0**2 * DEPTH * np.sin(60.0 * t[1:-1]), atol=1e-4 * mass * 2.9
    )


def test_a_tilted_approach_shows_a_line_in_air(model_with):
    model = model_with("approach_tilt").with_value("b_h", 0.1)
    height = DEPTH * np.linspace(-4.0, -1.0, 31)
    shown = model.simulate(np.arange(31.0), height).sensed_force
    np.testing.assert_allclose(shown, 0.1 * model.values["K"].value * height / DEPTH, rtol=1e-12)


def test_the_force_of_the_contact_does_not_know_its_sensor(model_with, rich):
    """Lag, drift, cross-talk, guide, inertia and saturation change what is shown only."""
    felt = rich.through(model_with("relaxation")).normal_force
    names = (
        "sensor_lag",
        "force_drift",
        "cross_talk",
        "guide_friction",
        "approach_tilt",
        "inertia",
        "saturation",
    )
    for name in names:
        np.testing.assert_array_equal(rich.through(model_with(name)).normal_force, felt, err_msg=name)


def test_full_scale_is_a_clip(model_with, rich):
    model = model_with("saturation")
    found = rich.through(model)
    end = model.values["K"].value / model.values["s_F"].value
    np.testing.assert_array_equal(found.sensed_force, np.clip(found.normal_force, -end, end))
    assert (found.sensed_force == end).any()
