"""Recordings that cannot carry an answer: said in words, and nothing named."""

import dataclasses

import numpy as np
import pytest

from vegrip.errors import RecordingError
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.data_checks import shift
from vegrip.identification.recording import Fingertip, Recording


def changed(recording: Recording, **columns: np.ndarray) -> Recording:
    kept = {k: v for k, v in recording.columns.items() if k in ("displacement", "normal_force")}
    return dataclasses.replace(recording, columns={**kept, **columns})


def later(recording: Recording, seconds: float) -> np.ndarray:
    """Return the force as a clock would show it that is ``seconds`` late, episode by episode."""
    out = recording.columns["normal_force"].copy()
    for number in np.unique(recording.episode):
        rows = recording.episode == number
        t = recording.t[rows]
        out[rows] = np.interp(t - seconds, t, out[rows])
    return out


@pytest.mark.parametrize("seconds", [0.08, -0.08, 0.0])
def test_shift_of_clocks_is_found_in_the_rates(bench, seconds) -> None:
    plain = bench()
    force, depth = later(plain, seconds), plain.columns["displacement"]
    first = np.r_[1.0, np.diff(plain.episode) != 0]
    assert shift(plain.t, first, depth, force) == pytest.approx(seconds, abs=0.0101)


def test_without_contact_it_is_refused_in_a_sentence() -> None:
    t = np.arange(0.0, 10.0, 5e-3)
    rng = np.random.default_rng(1)
    columns = {
        "displacement": -1e-3 + 2e-4 * np.sin(t) + 5e-6 * rng.standard_normal(t.size),
        "normal_force": 0.3 + 0.01 * rng.standard_normal(t.size),  # a zero that is off is no contact
    }
    air = Recording("air", t, np.zeros(t.size, dtype=int), columns, Fingertip(0.01), {"normal_force": 0.01})
    with pytest.raises(RecordingError, match="without contact"):
        diagnose(air)


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.06, pytest.param(-0.06, marks=pytest.mark.long)])
def test_clocks_that_disagree_are_said_and_no_effect_is_named(bench, seconds) -> None:
    plain = bench()
    found = diagnose(changed(plain, normal_force=later(plain, seconds)))
    assert found.verdict == "unexplained"
    assert found.named == []
    assert any("clocks" in one.text for one in found.doubts)


@pytest.mark.slow
@pytest.mark.long
def test_a_clock_that_is_a_little_early_is_at_least_said_beside_the_damping_it_looks_like(bench) -> None:
    found = diagnose(changed(bench(), normal_force=later(bench(), -0.008)))
    assert found.verdict == "unexplained" or "fast_damping" in found.named
    assert any("clock" in one.text for one in found.doubts)


@pytest.mark.slow
def test_a_touch_is_too_short_to_name_anything(bench) -> None:
    sticky = bench("sensor_lag")
    brief = changed(sticky).select((sticky.episode == 0) & (sticky.t < sticky.t[0] + 0.9))
    found = diagnose(brief)
    assert found.named == []
    assert any("too little" in one.text for one in found.doubts)


@pytest.mark.slow
def test_a_radius_smaller_than_the_indentation_is_said(bench) -> None:
    small = dataclasses.replace(changed(bench("sensor_lag")), fingertip=Fingertip(1.2e-3))
    found = diagnose(small)
    assert found.named == []
    assert any("radius" in one.text for one in found.doubts)


@pytest.mark.slow
def test_what_a_fault_of_the_recording_would_imitate_is_said_with_the_name(bench) -> None:
    found = diagnose(changed(bench("sensor_lag")))
    assert found.named == ["sensor_lag"]
    assert any("clock is late" in one.text for one in found.doubts)


@pytest.mark.slow
def test_flat_tops_are_the_end_of_the_scale(bench) -> None:
    force = bench().columns["normal_force"]
    found = diagnose(changed(bench(), normal_force=np.minimum(force, 0.7 * force.max())))
    assert "saturation" in [one.candidate.name for one in found.search.accepted]
    assert any("saturate" in sentence for sentence in found.as_dict()["warnings"])
