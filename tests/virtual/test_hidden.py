"""Hidden effects: each changes what it should, by as much as it should, and nothing else."""

import math

import numpy as np
import pytest

from vegrip.errors import ConfigError
from vegrip.virtual.bench.protocol import AIR_SEGMENT, Segment, creep, hold, slip, triangles
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.fingertip import Fingertips
from vegrip.virtual.hidden import HIDDEN, Hidden
from vegrip.virtual.profile import share_within
from vegrip.virtual.settings import FingertipSettings, SensorSettings
from vegrip.virtual.specimen import Specimen

TIP = FingertipSettings(bristle_stiffness=1e10)
MU = TIP.friction
QUIET = SensorSettings(
    rate=1000.0, normal_force=0.0, tangential_force=0.0, torque_z=0.0, displacement=0.0, temperature=0.0,
    slip_speed=0.0, force_bias=0.0, displacement_bias=0.0, force_step=0.0, displacement_step=0.0,
    torque_step=0.0, contact_radius=0.0, radius_sensor=True,
)  # fmt: skip
FRICTIONAL = {"load_dependent_friction", "rate_dependent_friction", "friction_ageing", "wet_contact"}


def run(*protocol, **hidden):
    trial = run_trial(TIP, protocol, QUIET, hidden=hidden, rings=12, spokes=24)
    return {**{f"true_{name}": values for name, values in trial.truth.items()}, **trial.columns}


def sliding(trial, channel="tangential_force_x"):
    return np.abs(trial[channel][trial["slip"] == 1.0])


def test_nothing_hidden_changes_nothing_bit_for_bit() -> None:
    plain = run_trial(TIP, [slip(1.0, 0.1, pull=2e-3, duration=0.1)], SensorSettings(), 3)
    nothing = run_trial(TIP, [slip(1.0, 0.1, pull=2e-3, duration=0.1)], SensorSettings(), 3, hidden={})
    for name, values in plain.columns.items():
        assert np.array_equal(values, nothing.columns[name])


def test_a_hidden_effect_that_does_nothing_gives_the_plain_fingertip() -> None:
    plain, specimen = Fingertips([TIP], 1e-3), Specimen(TIP, 1e-3, [Hidden()])
    for depth in 1e-3 * np.sin(np.linspace(0.0, 3.0, 300)):
        assert specimen.press(np.array([depth])) == pytest.approx(plain.press(np.array([depth])), rel=1e-12)
        assert specimen.pressure_exponent == pytest.approx(plain.pressure_exponent, rel=1e-12)
        assert specimen.contact_radius == pytest.approx(plain.contact_radius, rel=1e-12)
    for force in np.linspace(0.1, 2.0, 50):
        assert specimen.load(np.array([force])) == pytest.approx(plain.load(np.array([force])), rel=1e-9)


@pytest.mark.parametrize("name", HIDDEN)
def test_every_hidden_effect_leaves_the_other_channels_alone(name) -> None:
    """Those of patch and friction do not touch the normal direction; those of the sensor nothing true."""
    protocol = slip(1.0, 0.3, pull=2e-3, spin=0.5, duration=0.2)
    plain, other = run(protocol), run(protocol, **{name: {}})
    changed = {
        channel
        for channel, values in plain.items()
        if not np.allclose(values, other[channel], rtol=0.0, atol=1e-9 * np.abs(values).max() + 1e-12)
    }
    assert changed
    if name in FRICTIONAL | {"contact_radius_law", "pressure_profile"}:
        assert not changed & {"normal_force", "displacement", "true_indentation", "true_normal_force"}
    if name in {"sensor_lag", "sensor_delay", "cross_talk", "force_drift"}:
        assert changed == {"normal_force"}
    if name not in FRICTIONAL:
        assert "true_friction_coefficient" not in changed


@pytest.mark.parametrize("name", HIDDEN)
def test_every_hidden_effect_stays_finite_through_every_motion(name) -> None:
    trial = run(hold(1e-3, 0.3), creep(1.0, 0.3), triangles(1e-3, 1e-2, 1), **{name: {}})
    assert all(np.all(np.isfinite(values)) for values in trial.values())


def test_adhesion_pulls_on_the_way_out_only() -> None:
    trial = run(triangles(5e-4, 2e-3, 1), adhesion={"force": 0.03, "stretch": 1e-4})
    t, force, depth = trial["t"], trial["normal_force"], trial["displacement"]
    before = t < 0.2
    assert np.all(force[before] == 0.0)
    away = (*triangles(5e-4, 2e-3, 1)[:-1], Segment(0.2, depth=-3e-4))
    trial = run(away, adhesion={"force": 0.03, "stretch": 1e-4})
    force, depth = trial["normal_force"], trial["displacement"]
    assert force.min() == pytest.approx(-0.03, rel=0.02)
    neck = (depth < -0.2e-4) & (depth > -0.8e-4)
    assert force[neck] == pytest.approx(-0.03 * (1.0 + depth[neck] / 1e-4), rel=1e-6)
    assert np.all(force[depth < -1.05e-4] == 0.0)


def test_adhesion_adds_its_pull_to_an_imposed_force() -> None:
    """The material carries N plus the pull; a heavier load without adhesion is the same indentation."""
    sticky = run(creep(1.0, 0.3), adhesion={"force": 0.2})["true_indentation"][400]
    heavy = run(creep(1.2, 0.3))["true_indentation"][400]
    assert sticky == pytest.approx(heavy, rel=0.02)


def test_second_relaxation_loses_its_share_of_the_elastic_force() -> None:
    press = hold(1e-3, 2.0, rise=2e-3)
    lost = (
        run(press)["normal_force"]
        - run(press, second_relaxation={"amplitude": 0.1, "rate": 2.0})["normal_force"]
    )
    at = 0.2 + 1e-3 + np.array([0.5, 1.0, 1.8])
    expected = 0.1 * 1.8 * (1.0 - np.exp(-2.0 * (at - 0.201)))
    assert lost[np.rint(at * 1000).astype(int)] == pytest.approx(expected, rel=0.01)


def test_power_law_relaxation_loses_its_share() -> None:
    press = hold(1e-3, 1.0, rise=2e-3)
    given = {"amplitude": 0.3, "time": 0.01, "exponent": 0.2}
    lost = run(press)["normal_force"] - run(press, power_law_relaxation=given)["normal_force"]
    assert lost[1000] == pytest.approx(0.3 * 1.8 * (1.0 - (1.0 + 0.8 / 0.01) ** -0.2), rel=0.01)


def test_mount_gives_way_by_compliance_times_force() -> None:
    for protocol in (hold(1e-3, 0.3), creep(1.0, 0.3)):
        trial = run(protocol, series_compliance={"compliance": 1e-4})
        touching = trial["normal_force"] > 0.0
        given = (trial["displacement"] - trial["true_indentation"])[touching]
        assert given == pytest.approx(1e-4 * trial["true_normal_force"][touching], abs=1e-12)


def test_play_stands_still_after_a_reversal() -> None:
    trial = run(triangles(1e-3, 2e-3, 1), displacement_backlash={"width": 1e-4})
    drive, mount = trial["displacement"], trial["true_indentation"]
    top = int(np.argmax(drive))
    assert mount[top] == pytest.approx(drive[top] - 0.5e-4, rel=1e-6)
    still = (drive[top:] < drive[top]) & (drive[top:] > drive[top] - 1e-4)
    assert np.ptp(mount[top:][still]) == 0.0
    back = (drive[top:] < drive[top] - 1.1e-4) & (drive[top:] > 1e-4)
    assert mount[top:][back] == pytest.approx(drive[top:][back] + 0.5e-4)


def test_play_under_imposed_force_shows_in_the_drive() -> None:
    trial = run(
        (AIR_SEGMENT, Segment(0.2, force=1.0), Segment(0.2, force=0.2)), displacement_backlash={"width": 1e-4}
    )
    difference = trial["displacement"] - trial["true_indentation"]
    assert difference[350] == pytest.approx(0.5e-4)
    assert difference[550] == pytest.approx(-0.5e-4)


def test_second_touch_of_a_dented_surface_is_deeper_by_the_dent() -> None:
    trial = run(
        triangles(1e-3, 5e-3, 1), triangles(1e-3, 5e-3, 1), permanent_set={"share": 0.1, "threshold": 2e-4}
    )
    onset = [
        trial["displacement"][(trial["episode"] == e) & (trial["normal_force"] > 0.0)].min() for e in (0, 1)
    ]
    assert onset[1] - onset[0] == pytest.approx(0.1 * 0.8e-3, abs=1e-5)


def test_softened_rubber_follows_the_virgin_curve_only_once() -> None:
    trial = run(
        triangles(1e-3, 1.0, 1), triangles(1e-3, 1.0, 1), mullins_softening={"loss": 0.2, "width": 2e-4}
    )
    plain = run(triangles(1e-3, 1.0, 1))
    first, second = (trial["normal_force"][trial["episode"] == e] for e in (0, 1))
    loading = slice(200, 201)
    depth = plain["displacement"][loading]
    assert first[loading] == pytest.approx(plain["normal_force"][loading])
    ratio = second[loading] / first[loading]
    assert ratio == pytest.approx(1.0 - 0.2 * np.tanh((1e-3 - depth) / 2e-4), rel=1e-6)


@pytest.mark.parametrize(
    ("name", "given", "factor"),
    [
        ("exponential_stiffness", {"length": 1e-3}, math.expm1(0.8) / 0.8),
        ("layer_over_core", {"thickness": 8e-3, "tip_radius": 9e-3}, 1.61342),
    ],
)
def test_stiffer_laws_multiply_the_elastic_force(name, given, factor) -> None:
    soft = Specimen(TIP, 1e-3, [HIDDEN[name](**given)])
    plain = Fingertips([TIP], 1e-3)
    depth = np.array([0.8e-3])
    assert soft.elastic_force(depth) == pytest.approx(factor * plain.elastic_force(depth), rel=1e-4)
    assert soft.elastic_indentation(soft.elastic_force(depth)) == pytest.approx(depth, rel=1e-12)


@pytest.mark.parametrize("name", ["sensor_lag", "sensor_delay"])
def test_sensor_shows_a_ramp_late_by_its_time_constant(name) -> None:
    trial = run((AIR_SEGMENT, Segment(0.5, force=2.0)), **{name: {"time": 0.02}})
    t = trial["t"]
    late = np.interp(t - 0.02, t, trial["true_normal_force"])
    ramp = (t > 0.4) & (t < 0.7)
    assert trial["normal_force"][ramp] == pytest.approx(late[ramp], abs=1e-3)


def test_sensor_talks_across_and_drifts_through_the_pause() -> None:
    pull = slip(1.0, 0.1, pull=2e-3, duration=0.1)
    trial = run(pull, cross_talk={"share": 0.05})
    extra = trial["normal_force"] - trial["true_normal_force"]
    assert extra == pytest.approx(0.05 * trial["true_tangential_force"], abs=1e-12)
    trial = run(pull, pull, force_drift={"rate": 1e-3})
    extra = trial["normal_force"] - trial["true_normal_force"]
    assert extra == pytest.approx(1e-3 * trial["t"], abs=1e-9)


def test_slip_force_over_load_falls_as_a_power() -> None:
    given = {"exponent": 0.2, "at": 1.0}
    for load in (0.5, 1.0, 2.0):
        force = sliding(run(slip(load, 0.1, pull=4e-3, duration=0.1), load_dependent_friction=given))[-1]
        assert force / load == pytest.approx(MU * load**-0.2, rel=1e-3)


def test_sliding_force_follows_the_speed() -> None:
    given = {"kinetic": 0.7, "stribeck": 1e-3, "growth": 0.05, "slow": 1e-4}
    for speed in (5e-4, 4e-3):
        trial = run(slip(1.0, 0.1, pull=speed, duration=0.4), rate_dependent_friction=given)
        expected = 0.7 + 0.3 * math.exp(-((speed / 1e-3) ** 2)) + 0.05 * math.log(1.0 + speed / 1e-4)
        assert sliding(trial)[-1] == pytest.approx(MU * expected, rel=5e-3)


def test_slip_limit_grows_with_the_hold_and_is_renewed_by_sliding() -> None:
    given = {"growth": 0.05, "time": 0.1, "distance": 1e-4}
    for wait in (0.2, 2.0):
        trial = run(slip(1.0, wait, pull=2e-3, duration=0.5), friction_ageing=given)
        age = wait + 0.1  # the rise counts
        assert trial["tangential_force_x"].max() == pytest.approx(
            MU * (1.0 + 0.05 * math.log(1.0 + age / 0.1)), rel=5e-3
        )
        steady = MU * (1.0 + 0.05 * math.log(1.0 + (1e-4 / 2e-3) / 0.1))
        assert sliding(trial)[-1] == pytest.approx(steady, rel=5e-3)


def test_film_makes_early_slips_easier() -> None:
    given = {"loss": 0.4, "time": 0.5}
    for wait in (0.2, 2.0):
        trial = run(slip(1.0, wait, pull=5e-3, duration=0.02), wet_contact=given)
        dwell = wait + 0.1 + 0.02
        assert sliding(trial)[-1] == pytest.approx(MU * (1.0 - 0.4 * math.exp(-dwell / 0.5)), rel=0.01)


def test_a_smaller_patch_has_a_smaller_slip_torque_and_the_same_slip_force() -> None:
    twist = slip(1.0, 0.1, spin=1.0, duration=0.2)
    plain, small = run(twist), run(twist, contact_radius_law={"kappa": 1.2})
    touching = plain["contact_radius"] > 0.0
    ratio = small["contact_radius"][touching] / plain["contact_radius"][touching]
    assert ratio == pytest.approx(np.full(ratio.shape, math.sqrt(0.6)))
    assert small["torque_z"][650:].min() >= 0.0
    assert np.abs(small["torque_z"]).max() / np.abs(plain["torque_z"]).max() == pytest.approx(
        math.sqrt(0.6), rel=1e-3
    )
    pull = slip(1.0, 0.1, pull=4e-3, duration=0.1)
    assert sliding(run(pull, contact_radius_law={"kappa": 1.2}))[-1] == pytest.approx(
        sliding(run(pull))[-1], rel=1e-3
    )


def test_a_flatter_profile_has_the_larger_slip_torque() -> None:
    """m / (mu N a) is the mean radius under the pressure, 3 pi / 16 for k = 2 and nearly 2/3 when flat."""
    twist = slip(1.0, 0.1, spin=1.0, duration=0.2)
    trials = [run(twist, pressure_profile={"k": k}) for k in (2.0, 50.0)]
    torques = [np.abs(trial["torque_z"]).max() for trial in trials]
    r = np.linspace(1e-3, 1.0, 2000)
    means = []
    for k in (2.0, 50.0):
        inside = share_within(np.array([k]), r)[0]
        means.append(1.0 - np.trapezoid(inside / inside[-1], r))
    assert torques[1] / torques[0] == pytest.approx(means[1] / means[0], rel=5e-3)


def test_unknown_effects_and_parameters_are_refused_by_name() -> None:
    with pytest.raises(ConfigError, match="there is no effect 'glue'"):
        run(hold(1e-3, 0.1), glue={})
    with pytest.raises(ConfigError, match="unknown key 'work'"):
        run(hold(1e-3, 0.1), adhesion={"work": 1.0})
