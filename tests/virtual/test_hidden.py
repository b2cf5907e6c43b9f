"""Hidden effects: each changes what it should, by as much as it should, and nothing else.

Those that an effect of the catalogue describes are compared with it in tests/effects/test_against_bench.py.
"""

import math

import numpy as np
import pytest

from vegrip.errors import ConfigError
from vegrip.virtual.bench.protocol import AIR_SEGMENT, Segment, creep, hold, slip, triangles
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.fingertip import Fingertips
from vegrip.virtual.hidden import HIDDEN, Hidden
from vegrip.virtual.settings import FingertipSettings, SensorSettings
from vegrip.virtual.specimen import Specimen

TIP = FingertipSettings(bristle_stiffness=1e10)
QUIET = SensorSettings(
    rate=1000.0, normal_force=0.0, tangential_force=0.0, torque_z=0.0, displacement=0.0, temperature=0.0,
    slip_speed=0.0, force_bias=0.0, displacement_bias=0.0, force_step=0.0, displacement_step=0.0,
    torque_step=0.0, contact_radius=0.0, radius_sensor=True,
)  # fmt: skip
ALL_HIDDEN = [
    pytest.param(name, marks=pytest.mark.long) if name == "jkr_adhesion" else name for name in HIDDEN
]
"""The one that iterates takes five times as long as any other."""
FRICTIONAL = {"load_dependent_friction", "rate_dependent_friction", "friction_ageing", "wet_contact"}


def run(*protocol, rings=12, **hidden):
    trial = run_trial(TIP, protocol, QUIET, hidden=hidden, rings=rings, spokes=2 * rings)
    return {**{f"true_{name}": values for name, values in trial.truth.items()}, **trial.columns}


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


SLIDE = slip(1.0, 0.3, pull=2e-3, spin=0.5, duration=0.2)


@pytest.fixture(scope="module")
def plain():
    return run(SLIDE, rings=6)


@pytest.mark.parametrize("name", ALL_HIDDEN)
def test_every_hidden_effect_leaves_the_other_channels_alone(name, plain) -> None:
    """Those of patch and friction do not touch the normal direction; those of the sensor nothing true."""
    other = run(SLIDE, rings=6, **{name: {}})
    changed = {
        channel
        for channel, values in plain.items()
        if not np.allclose(values, other[channel], rtol=0.0, atol=1e-9 * np.abs(values).max() + 1e-12)
    }
    assert changed
    if name in FRICTIONAL | {"contact_radius_law", "pressure_profile"}:
        assert not changed & {"normal_force", "displacement", "true_indentation", "true_normal_force"}
    if name in {"sensor_lag", "sensor_delay", "cross_talk", "force_drift", "approach_tilt"}:
        assert changed == {"normal_force"}
    if name not in FRICTIONAL:
        assert "true_friction_coefficient" not in changed


@pytest.mark.parametrize("name", ALL_HIDDEN)
def test_every_hidden_effect_stays_finite_through_every_motion(name) -> None:
    trial = run(hold(1e-3, 0.3), creep(1.0, 0.3), triangles(1e-3, 1e-2, 1), rings=4, **{name: {}})
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


def test_play_under_imposed_force_shows_in_the_drive() -> None:
    trial = run(
        (AIR_SEGMENT, Segment(0.2, force=1.0), Segment(0.2, force=0.2)), displacement_backlash={"width": 1e-4}
    )
    difference = trial["displacement"] - trial["true_indentation"]
    assert difference[350] == pytest.approx(0.5e-4)
    assert difference[550] == pytest.approx(-0.5e-4)


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


def test_unknown_effects_and_parameters_are_refused_by_name() -> None:
    with pytest.raises(ConfigError, match="there is no effect 'glue'"):
        run(hold(1e-3, 0.1), glue={})
    with pytest.raises(ConfigError, match="unknown key 'work'"):
        run(hold(1e-3, 0.1), adhesion={"work": 1.0})
