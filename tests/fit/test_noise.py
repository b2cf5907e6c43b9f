"""Where the noise comes from."""

import numpy as np
import pytest

from vegrip.fit.measured import prepare, spikes
from vegrip.fit.noise import noise_of, rough
from vegrip.recording import Recording


def test_white_noise_is_found_under_a_motion() -> None:
    t = np.arange(0.0, 20.0, 5e-3)
    values = np.sin(t) + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    assert rough(values, np.zeros(t.size)) == pytest.approx(0.01, rel=0.05)


def test_stated_noise_is_believed_unless_air_contradicts_it(bench) -> None:
    recording = bench()
    noise = noise_of(recording)
    assert noise.normal_force == recording.sensors["normal_force"]
    assert "stated" in noise.source["normal_force"]
    assert not noise.doubts
    wrong = _with_sensors(recording, {**recording.sensors, "normal_force": 1e-3})
    noise = noise_of(wrong)
    assert noise.normal_force == pytest.approx(0.01, rel=0.1)
    assert "air" in noise.source["normal_force"]
    assert len(noise.doubts) == 1


def test_without_a_statement_the_signals_tell(bench) -> None:
    noise = noise_of(_with_sensors(bench(), {}))
    assert noise.normal_force == pytest.approx(0.01, rel=0.2)
    assert noise.displacement == pytest.approx(5e-6, rel=0.2)
    assert "neighbouring" in noise.source["displacement"]


def test_single_wild_rows_are_taken_out_and_turns_are_not(bench) -> None:
    recording = bench()
    assert not prepare(recording, noise_of(recording)).outliers
    force = recording.columns["normal_force"].copy()
    force[[500, 1200, 3000]] += 1.0
    wild = Recording("wild", recording.t, recording.episode, {**recording.columns, "normal_force": force},
                     recording.fingertip, recording.sensors)  # fmt: skip
    assert prepare(wild, noise_of(wild)).outliers == {"normal_force": 3}


def test_a_step_is_no_spike() -> None:
    step = np.r_[np.zeros(20), np.ones(20)]
    assert not spikes(step, 0.01, np.zeros(40)).any()
    step[7] = 1.0
    assert np.flatnonzero(spikes(step, 0.01, np.zeros(40))).tolist() == [7]


def _with_sensors(recording: Recording, sensors: dict[str, float]) -> Recording:
    return Recording(
        recording.name, recording.t, recording.episode, recording.columns, recording.fingertip, sensors
    )
