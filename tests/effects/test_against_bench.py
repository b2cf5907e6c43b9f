"""Effects against the virtual bench, which has them hidden: other code, summed history, a patch of elements.

At the same physical parameters the model with the effect says what the bench measured, and the model without
it does not.
"""

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.model import paper_model, predict
from vegrip.virtual.bench.protocol import AIR_SEGMENT, Segment, hold, slip, triangles
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import FingertipSettings, SensorSettings

pytestmark = pytest.mark.slow

R, K, MU = 0.01, 1.8, 0.8  # so that x_ref is the 1 mm at which the bench's fingertip has its 1.8 N
TIP = FingertipSettings(
    radius=R, reference_force=K, amplitudes=(0.3,), rates=(3.1,), friction=MU, bristle_stiffness=1e10
)
QUIET = SensorSettings(
    rate=1000.0, normal_force=0.0, tangential_force=0.0, torque_z=0.0, displacement=0.0, temperature=0.0,
    slip_speed=0.0, force_bias=0.0, displacement_bias=0.0, force_step=0.0, displacement_step=0.0,
    torque_step=0.0, contact_radius=0.0, radius_sensor=True,
)  # fmt: skip
PROTOCOL = (
    hold(1e-3, 0.5),
    triangles(1.3e-3, 1e-2, 2),
    (AIR_SEGMENT, *(Segment(0.2, depth=depth) for depth in (5e-4, 8e-4, 6e-4, 0.0))),
    slip(0.6, 0.2, pull=2e-3, spin=0.3, duration=0.2),
    slip(1.5, 0.8, pull=5e-4, duration=0.4),
    slip(1.5, 0.1, spin=0.8, duration=0.2),
)  # fmt: skip

NORMAL = {
    "second_relaxation": ({"amplitude": 0.1, "rate": 0.5}, {"c2": 0.1, "nu2": 0.5}),
    "relaxation_spectrum": (
        {"amplitude": 0.08, "slow": 0.1, "fast": 10.0},
        {"nu_s": 0.01, "c_s1": 0.0, "c_s2": 0.08, "c_s3": 0.0, "c_s4": 0.08, "c_s5": 0.0},
    ),
    "series_compliance": ({"compliance": 5e-5}, {"s_C": 5e-5 * K / 1e-3}),
    "displacement_backlash": ({"width": 4e-5}, {"play": 0.04}),
    "permanent_set": ({"share": 0.05, "threshold": 3e-4}, {"alpha_p": 0.05, "x_y": 0.3, "r_p": 0.0}),
    "mullins_softening": ({"loss": 0.12, "width": 4e-4}, {"r_m": 0.12, "w_m": 0.4, "l_m": 0.0}),
    "healing_softening": (
        {"loss": 0.12, "width": 4e-4, "rate": 0.03},
        {"r_h": 0.12, "w_h": 0.4, "l_h": 0.0, "nu_h": 0.03},
    ),
    "exponential_stiffness": ({"length": 1.5e-3}, {"b_x": 1.0 / 1.5}),
    "jkr_adhesion": (
        {"work": 1.0, "tip_radius": R, "force": K, "depth": 1e-3, "exponent": 1.5},
        {"w_J": 1.5 * np.pi * R * 1.0 / K, "g_J": 0.0},
    ),
    "second_contact": (
        {"force": 0.3, "reach": 5e-4, "gap": 8e-4, "exponent": 1.0},
        {"K_2": 0.6 / K, "x_2": 0.8, "p_2": 1.0},
    ),
    "sensor_lag": ({"time": 5e-3}, {"tau": 5e-3}),
    "cross_talk": ({"share": 0.02}, {"c_f": 0.02}),
    "force_drift": ({"rate": 1e-3}, {"r_F": 1e-3 / K}),
    "approach_tilt": ({"stiffness": 30.0}, {"b_h": 30.0 * 1e-3 / K}),
}
PATCH = {
    "load_dependent_friction": ({"exponent": 0.2, "at": 1.0}, {"g_N": 0.2, "mu": MU * K**-0.2}),
    "rate_dependent_friction": (
        {"kinetic": 0.8, "stribeck": 1e-3, "growth": 0.04, "slow": 1e-4},
        {"r_mu": 0.8, "v_s": 1.0, "beta_v": 0.04, "v_0": 0.1},
    ),
    "friction_ageing": (
        {"growth": 0.05, "time": 0.1, "distance": 1e-4},
        {"beta_t": 0.05, "t_0": 0.1, "D_c": 0.1},
    ),
    "wet_contact": ({"loss": 0.3, "time": 0.5}, {"s_w": 0.3, "tau_f": 0.5}),
    "contact_radius_law": ({"kappa": 1.4}, {"kappa": 1.4}),
    "pressure_profile": ({"k": 5.0}, {"s_k": 1.0, "k_inf": 5.0, "tau_k": 1e-4}),
}


def model_with(name, values):
    model = paper_model(R).with_value("K", K).with_value("mu", MU).with_effect(effect(name))
    for symbol, value in values.items():
        model = model.with_value(symbol, value)
    return model


def on_bench(hidden, rings):
    return run_trial(TIP, PROTOCOL, QUIET, hidden=hidden, rings=rings, spokes=2 * rings, truth=False).columns


def without(model):
    """The same model, the effect at its null value and friction back where it was."""
    for symbol, (_, parameter) in model.parameters.items():
        if parameter.null is not None:
            model = model.with_value(symbol, parameter.null)
    return model.with_value("mu", MU)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.long) if name == "jkr_adhesion" else name for name in NORMAL],
)
def test_normal_force_is_that_of_the_bench(name) -> None:
    hidden, values = NORMAL[name]
    measured = on_bench({name: hidden}, 6)
    model = model_with(name, values)
    right, wrong = (
        rms(predict(one, measured)["normal_force"] - measured["normal_force"])
        for one in (model, without(model))
    )
    assert right < 1e-3 * K
    assert right < 0.05 * wrong


@pytest.mark.parametrize("name", PATCH)
def test_load_at_slip_is_that_of_the_bench(name) -> None:
    hidden, values = PATCH[name]
    measured = on_bench({name: hidden}, 24)
    model = model_with(name, values)
    sliding = measured["slip"] == 1.0
    assert sliding.sum() > 200
    right, wrong = (
        rms(np.log(predict(one, measured)["utilisation"][sliding])) for one in (model, without(model))
    )
    assert right < 0.01
    assert right < 0.2 * wrong


def rms(error):
    return np.sqrt(np.mean(error**2))
