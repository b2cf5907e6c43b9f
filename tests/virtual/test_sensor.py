"""What the sensors add to the truth."""

import math

import numpy as np
import pytest

from tests.virtual.build import tips_of
from vegrip.messages import FingertipState
from vegrip.virtual.kernels import Records
from vegrip.virtual.sensor import DRAWN_AHEAD, SENSED_CHANNELS, Sensors
from vegrip.virtual.settings import SensorSettings

TRUE = np.array([[3.0, 0.5, -1.0, 0.01, 1e-3, 25.0, 0.02, 4e-3]])
EXACT = dict.fromkeys(
    (
        "normal_force",
        "tangential_force",
        "torque_z",
        "displacement",
        "temperature",
        "slip_speed",
        "contact_radius",
        "force_bias",
        "displacement_bias",
        "force_step",
        "displacement_step",
        "torque_step",
    ),
    0.0,
)
AT_ONCE = {"slip_threshold": 0.0, "slip_delay": 0.0}


def tips(values: np.ndarray, slides: float | np.ndarray = 0.0) -> Records:
    """Return tips that feel these quantities, but for the temperature."""
    names = ("force", "pull_x", "pull_y", "torque", "depth", "", "slip_speed", "a")
    felt = {name: column for name, column in zip(names, values.T, strict=True) if name}
    return tips_of(len(values), side=-1.0, slides=slides, **felt)


def sensed_by(sensors: Sensors, felt: Records, time: float, epoch: int = 0) -> list[FingertipState]:
    return sensors.sample(felt, TRUE[0, 5], time, epoch).states(sensors.fingers)


def measured(settings: SensorSettings, count: int, seed: int = 0) -> np.ndarray:
    sensors = Sensors(settings, ("index",), np.random.default_rng(seed))
    states = [s for i in range(count) for s in sensed_by(sensors, tips(TRUE), 0.002 * i)]
    return np.array([[getattr(state, name) for name in SENSED_CHANNELS] for state in states])


def test_perfect_sensors_tell_the_truth() -> None:
    assert measured(SensorSettings(**EXACT, **AT_ONCE, radius_sensor=True), 3) == pytest.approx(
        np.repeat(TRUE, 3, 0)
    )


def test_noise_has_the_stated_standard_deviation() -> None:
    exact = {"force_step": 0.0, "displacement_step": 0.0, "torque_step": 0.0}
    settings = SensorSettings(**AT_ONCE, **exact, radius_sensor=True)
    std = measured(settings, 20000).std(axis=0)
    force = settings.tangential_force
    stated = [0.01, force, force, 1e-4, 5e-6, 0.05, 5e-5, 5e-5]
    assert std == pytest.approx(stated, rel=0.03)


def test_a_tangential_gain_scales_what_is_measured_of_tangential_forces_and_not_their_noise() -> None:
    plain = measured(SensorSettings(**AT_ONCE, force_step=0.0), 50)
    low = measured(SensorSettings(**AT_ONCE, force_step=0.0, tangential_gain=0.8), 50)
    assert (low - plain)[:, :7] == pytest.approx(np.tile([0.0, -0.1, 0.2, 0.0, 0.0, 0.0, 0.0], (50, 1)))


def test_bias_is_constant_in_a_run_and_scatters_between_runs_as_stated() -> None:
    settings = SensorSettings(**{**EXACT, "force_bias": 0.02})
    runs = np.array([measured(settings, 2, seed) for seed in range(400)])
    assert np.array_equal(runs[:, 0, :6], runs[:, 1, :6])
    assert (runs[:, 0, 0] - TRUE[0, 0]).std() == pytest.approx(0.02, rel=0.1)


def test_values_are_multiples_of_the_resolution() -> None:
    forces = measured(SensorSettings(force_step=0.01), 100)[:, 0]
    assert forces / 0.01 == pytest.approx(np.round(forces / 0.01), abs=1e-9)


def test_missing_sensors_read_nan() -> None:
    sensors = Sensors(SensorSettings(slip_sensor=False), ("index",), np.random.default_rng(0))
    state = sensed_by(sensors, tips(TRUE, 1.0), 0.0)[0]
    assert all(math.isnan(v) for v in (state.slip, state.slip_speed, state.contact_radius))


def test_lost_samples_leave_gaps_in_the_numbers() -> None:
    sensors = Sensors(SensorSettings(dropout=0.3), ("a", "b"), np.random.default_rng(0))
    reading = tips(np.repeat(TRUE, 2, 0))
    states = [s for i in range(2000) for s in sensed_by(sensors, reading, 0.002 * i)]
    numbers = [s.seq for s in states if s.finger == "a"]
    assert len(numbers) == pytest.approx(1400, rel=0.05)
    assert numbers == sorted(set(numbers))
    assert numbers[-1] > 1990


def test_stamps_follow_the_time_with_the_stated_jitter() -> None:
    sensors = Sensors(SensorSettings(jitter=1e-4), ("a",), np.random.default_rng(0))
    reading = tips(TRUE)
    late = [
        sensed_by(sensors, reading, 0.002 * i, 10**9)[0].stamp - 10**9 - 2_000_000 * i for i in range(4000)
    ]
    assert np.std(late) == pytest.approx(1e5, rel=0.05)
    assert np.mean(late) == pytest.approx(0.0, abs=1e4)


def test_the_slip_channel_is_late_and_shows_nothing_below_its_threshold() -> None:
    """Flag and slip speed alike: a slide shows after the delay, creep never does."""
    settings = SensorSettings(**EXACT, slip_threshold=1e-3, slip_delay=0.02)
    sensors = Sensors(settings, ("slides", "creeps"), np.random.default_rng(0))
    values = np.repeat(TRUE, 2, 0)
    values[1, SENSED_CHANNELS.index("slip_speed")] = 9e-4
    shown = [
        [(s.slip, s.slip_speed) for s in sensed_by(sensors, tips(values, 1.0), 0.002 * i)] for i in range(20)
    ]
    assert [slides for slides, _ in shown] == [(0.0, 0.0)] * 10 + [(1.0, 0.02)] * 10
    assert {creeps for _, creeps in shown} == {(0.0, 0.0)}


def test_what_the_tips_feel_of_slip_is_no_finer_than_what_is_published() -> None:
    """20 ms +- 6 ms after slip begins (arXiv 2602.16127); the speed no finer than twice its noise."""
    usual = SensorSettings()
    assert usual.slip_delay == 0.02
    assert usual.slip_threshold >= 2.0 * usual.slip_speed


def test_what_is_sensed_is_what_numbers_drawn_sample_by_sample_give() -> None:
    settings = SensorSettings(rate=500.0, slip_delay=0.006, dropout=0.2, jitter=1e-4, radius_sensor=True)
    fingers, rng = ("a", "b"), np.random.default_rng(3)
    sensors = Sensors(settings, fingers, np.random.default_rng(3))
    rng.standard_normal((2, 8))  # of the bias
    noise = np.array([0.01, 0.01, 0.01, 1e-4, 5e-6, 0.05, 5e-5, 5e-5])
    step = np.array([2e-3, 2e-3, 2e-3, 2e-5, 1e-6, 0.0, 0.0, 0.0])
    slips, truth = [np.zeros((2, 2))] * 3, np.random.default_rng(4)
    for number in range(1, 3 * DRAWN_AHEAD):
        values, slides = truth.uniform(0.0, 2.0, (2, 8)), truth.integers(2, size=2).astype(float)
        values[:, 5], values[:, 6] = TRUE[0, 5], 1e-4 * values[:, 6]
        slips.append(np.where(values[:, 6:7] >= settings.slip_threshold, np.c_[slides, values[:, 6]], 0.0))
        errors = sensors.bias + noise * rng.standard_normal((2, 8))
        lost, shifts = rng.random(2) < 0.2, rng.standard_normal(2)
        sensed = np.c_[values[:, :6], slips[number - 1][:, 1], values[:, 7]] + errors
        sensed = np.where(step > 0.0, np.round(sensed / np.where(step, step, 1.0)) * step, sensed)
        sensed[:, 6:] = np.maximum(sensed[:, 6:], 0.0)
        states = sensed_by(sensors, tips(values, slides), 0.002 * number, 10**9)
        told = [i for i in range(2) if not lost[i]]
        assert [s.finger for s in states] == [fingers[i] for i in told]
        assert {s.seq for s in states} <= {number}
        for state, i in zip(states, told, strict=True):
            assert state.stamp == 10**9 + round((0.002 * number + 1e-4 * float(shifts[i])) * 1e9)
            assert [getattr(state, name) for name in SENSED_CHANNELS] == sensed[i].tolist()
            assert state.slip == slips[number - 1][i, 0]
