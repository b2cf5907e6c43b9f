"""The prediction of all channels of a recording."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.contact.limit_surface import reference
from vegrip.effects import effect
from vegrip.errors import ModelError
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import Predictor, paper_model, predict
from vegrip.model.channels import QUANTITIES
from vegrip.virtual.bench.protocol import slip
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import FingertipSettings, SensorSettings

R = 0.01
MODEL = paper_model(R)
T = np.arange(0.0, 1.5, 5e-3)
DEPTH = 1e-3 * np.clip(5.0 * T, 0.0, 1.0)


def said(columns, model=MODEL, **options):
    return predict(model, {"t": T, "displacement": DEPTH, **columns}, plain=True, **options)


def test_normal_channel_is_the_simulation() -> None:
    simulated, table = MODEL.simulate(T, DEPTH, plain=True), said({})
    assert np.array_equal(table["normal_force"], simulated.sensed_force)
    assert np.array_equal(table["contact_radius"][1:], simulated.contact_radius[1:])
    assert np.array_equal(table["pressure_exponent"], simulated.pressure_exponent)
    assert set(table) == set(QUANTITIES)


def test_compiled_equals_plain() -> None:
    columns = {"t": T, "displacement": DEPTH, "tangential_force_x": 0.1 + T, "torque_z": -1e-3 * T}
    compiled, plain = predict(MODEL, columns), predict(MODEL, columns, plain=True)
    for name in QUANTITIES:
        assert compiled[name] == pytest.approx(plain[name], rel=1e-12, nan_ok=True), name


def test_pure_pull_slips_at_coulomb_force_and_pure_twist_at_the_torsion_limit() -> None:
    pulled = said({"tangential_force_x": np.full_like(T, 0.3), "tangential_force_y": np.full_like(T, 0.4)})
    assert pulled["tangential_force"][1:] == pytest.approx(0.7 * pulled["contact_force"][1:])
    assert pulled["utilisation"][1:] == pytest.approx(0.5 / (0.7 * pulled["contact_force"][1:]))
    twisted = said({"torque_z": np.full_like(T, -1e-3)})
    exact = [reference.torsion_limit(k) for k in twisted["pressure_exponent"][1:]]
    limit = 0.7 * twisted["contact_force"][1:] * twisted["contact_radius"][1:] * exact
    assert -twisted["torque_z"][1:] == pytest.approx(limit, rel=1e-4)
    assert twisted["limit_torque"][1:] == pytest.approx(limit, rel=1e-4)


def test_load_at_slip_lies_on_the_exact_limit_surface_along_the_measured_load() -> None:
    table = said({"tangential_force_x": np.full_like(T, 0.2), "torque_z": np.full_like(T, 4e-4)})
    N, a, k = (table[name][-1] for name in ("contact_force", "contact_radius", "pressure_exponent"))
    f, m = table["tangential_force"][-1], table["torque_z"][-1]
    assert f / m == pytest.approx(0.2 / 4e-4)
    psi = math.atan2(m / a, f)
    distance = math.hypot(f, m / a)
    assert distance / (0.7 * N) == pytest.approx(reference.radius(k, psi), rel=1e-4)
    assert table["limit_radius"][-1] == pytest.approx(distance)
    assert table["utilisation"][-1] == pytest.approx(0.2 / f)


def test_force_drives_to_the_displacement_that_gave_it() -> None:
    depth = 1e-3 * np.sin(2.0 * T) ** 2 + 1e-4
    forward = predict(MODEL, {"t": T, "displacement": depth}, plain=True)
    back = predict(MODEL, {"t": T, "normal_force": forward["normal_force"]}, drive="normal_force", plain=True)
    touching = forward["normal_force"] > 0.0
    assert touching.sum() > 200
    assert back["displacement"][touching] == pytest.approx(depth[touching], rel=1e-9)


def test_every_episode_starts_recovered() -> None:
    twice = {
        "t": np.r_[T, T + 2.0],
        "displacement": np.r_[DEPTH, DEPTH],
        "episode": np.repeat([0, 1], T.size),
    }
    force = predict(MODEL, twice, plain=True)["normal_force"]
    assert force[: T.size] == pytest.approx(force[T.size :], rel=1e-12)


def test_what_lasts_outlives_an_episode() -> None:
    model = MODEL.with_effect(effect("mullins_softening"))
    twice = {
        "t": np.r_[T, T + 2.0],
        "displacement": np.r_[DEPTH, DEPTH],
        "episode": np.repeat([0, 1], T.size),
    }
    force = predict(model, twice, plain=True)["normal_force"]
    assert np.all(force[T.size + 5 : T.size + 35] < 0.99 * force[5:35])


def test_friction_channels_use_the_measured_load_unless_told_otherwise() -> None:
    model_force = said({})["normal_force"]
    pull = {"tangential_force_x": np.full_like(T, 0.3), "normal_force": 1.1 * model_force}
    assert said(pull)["tangential_force"][1:] == pytest.approx(0.7 * 1.1 * model_force[1:])
    assert said(pull, load="model")["tangential_force"][1:] == pytest.approx(0.7 * model_force[1:])
    gap = {**pull, "normal_force": np.where(T > 0.5, np.nan, pull["normal_force"])}
    assert said(gap)["limit_force"][-1] == pytest.approx(0.7 * model_force[-1])


def test_out_of_contact_nothing_slips() -> None:
    table = said({"tangential_force_x": np.full_like(T, 0.3), "displacement": np.full_like(T, -1e-4)})
    assert np.all(table["contact_radius"] == 0.0)
    assert np.all(table["limit_force"] == 0.0)
    assert np.all(np.isnan(table["utilisation"]))


def test_missing_displacements_are_bridged_and_a_missing_drive_is_refused() -> None:
    holes = DEPTH.copy()
    holes[5:12] = np.nan  # on the ramp, which is linear
    bridged = predict(MODEL, {"t": T, "displacement": holes}, plain=True)["normal_force"]
    assert bridged == pytest.approx(said({})["normal_force"], rel=1e-9)
    with pytest.raises(ModelError, match="no displacement"):
        predict(MODEL, {"t": T, "normal_force": DEPTH})


def test_speed_where_no_slip_is_felt_is_noise() -> None:
    model = MODEL.with_effect(effect("rate_dependent_friction"))
    pull = {"tangential_force_x": np.full_like(T, 0.3), "slip_speed": np.full_like(T, 1e-3)}
    mu = {
        slip: said({**pull, "slip": np.full_like(T, slip)}, model)["friction_coefficient"] for slip in (0, 1)
    }
    assert np.all(mu[0] == 0.7)
    assert np.all(mu[1] != 0.7)


def test_a_recording_and_its_columns_say_the_same() -> None:
    columns = {"displacement": DEPTH, "tangential_force_x": T}
    recording = SimpleNamespace(t=T, episode=np.zeros(T.size, dtype=np.int64), columns=columns)
    first, second = Predictor(MODEL, recording, plain=True), Predictor(MODEL, {"t": T, **columns}, plain=True)
    assert np.array_equal(first(MODEL.vector), second(MODEL.vector), equal_nan=True)


def test_scale_does_not_matter() -> None:
    small = paper_model(1e-6)
    scale = (small.values["K"].value / MODEL.values["K"].value, 1e-6 / R)
    pull = {"tangential_force_x": np.full_like(T, 0.3), "torque_z": np.full_like(T, 5e-4)}
    large = said(pull)
    tiny = predict(
        small,
        {
            "t": T,
            "displacement": scale[1] * DEPTH,
            "tangential_force_x": scale[0] * pull["tangential_force_x"],
            "torque_z": scale[0] * scale[1] * pull["torque_z"],
        },
        plain=True,
    )
    assert tiny["utilisation"] == pytest.approx(large["utilisation"], rel=1e-9, nan_ok=True)


def test_channels_agree_with_a_simulation_that_shares_no_physics() -> None:
    """Elements of the patch and summed histories against the model, at the same parameters."""
    tip = FingertipSettings(radius=R, amplitudes=(0.3,), rates=(3.1,), bristle_stiffness=1e10)
    quiet = SensorSettings(
        rate=200.0, normal_force=0.0, tangential_force=0.0, torque_z=0.0, displacement=0.0, slip_speed=0.0,
        force_bias=0.0, displacement_bias=0.0, force_step=0.0, displacement_step=0.0, torque_step=0.0,
        contact_radius=0.0, radius_sensor=True,
    )  # fmt: skip
    protocol = (
        slip(1.0, 0.5, pull=2e-3, duration=0.5),
        slip(1.0, 0.5, pull=2e-3, spin=0.8, duration=0.5),
        slip(1.5, 0.5, spin=0.8, duration=0.5),
    )
    trial = run_trial(tip, protocol, quiet, rings=40, spokes=64)
    model = MODEL.with_value("K", 1.8).with_value("mu", 0.8)
    table, truth = predict(model, trial.columns), trial.truth
    touching = truth["normal_force"] > 0.1
    assert table["normal_force"] == pytest.approx(truth["normal_force"], abs=0.01)
    assert table["contact_radius"][touching] == pytest.approx(truth["contact_radius"][touching], rel=1e-3)
    assert table["pressure_exponent"][touching] == pytest.approx(
        truth["pressure_exponent"][touching], rel=0.02
    )
    sliding = trial.columns["slip"] == 1.0
    assert sliding.sum() > 100
    assert table["utilisation"][sliding] == pytest.approx(truth["utilisation"][sliding], rel=5e-3)
    for channel, measured in (
        ("tangential_force", truth["tangential_force"]),
        ("torque_z", truth["torque_z"]),
    ):
        assert table[channel][sliding] == pytest.approx(measured[sliding], rel=2e-2, abs=1e-5)


@pytest.mark.slow
def test_estimator_that_knows_the_parameters_finds_the_same_limits() -> None:
    """The forecast and the margin rest on the same compiled hooks."""
    model = MODEL.with_effect(effect("load_dependent_friction"))
    for symbol, value in model.values.items():
        model = model.with_value(symbol, value.value, std=1e-9)
    fine = SensorNoise(normal_force=1e-5, displacement=1e-8, tangential_force=1e-5, torque_z=1e-8)
    still = EstimatorSettings(regrasp=0.0, friction_drift=0.0, friction_scatter=1e-3, offset=1e-7)
    estimator = ContactEstimator(model, fine, still)
    f, m = 0.2, 4e-4
    pull = {"tangential_force_x": np.full_like(T, f), "torque_z": np.full_like(T, m)}
    depth = 1e-3 * np.sin(0.5 * np.pi * np.minimum(T / 1.4, 1.0)) - 1e-4  # comes to rest without a jerk
    table = said({**pull, "displacement": depth}, model)
    for i, (t, x, N) in enumerate(zip(T, depth, table["normal_force"], strict=True)):
        state = FingertipState(round(t * 1e9), "index", i, N, f * (x > 0.0), 0.0, m * (x > 0.0), x)
        estimate = estimator.update(state)
    assert estimate.limit_radius.value == pytest.approx(table["limit_radius"][-1], rel=1e-3)
    assert estimate.limit_torque.value == pytest.approx(table["limit_torque"][-1], rel=1e-3)
    assert estimate.friction_coefficient.value == pytest.approx(table["friction_coefficient"][-1], rel=1e-3)
    assert estimator.slip_margin().margin.value == pytest.approx(1.0 - table["utilisation"][-1], abs=1e-3)
