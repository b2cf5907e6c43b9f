"""Recordings in use: what is wrong with them is nothing but that, and is blamed on no effect."""

from dataclasses import replace

import numpy as np
import pytest

from validation.diagnosis_trials import Case, make_recording
from validation.diagnosis_trials.blind import blind_cases
from validation.diagnosis_trials.faults import NO_FAULTS, Faults
from vegrip.identification.diagnosis.diagnosis import diagnose
from vegrip.identification.fit.noise import STATED, noise_of

PLAIN = Case((), "strong", 291_100_000, style="short")


def of(**faults: float | bool) -> Case:
    return replace(PLAIN, faults=Faults(**faults))


def test_a_fault_has_a_key_of_its_own_and_the_plain_case_its_old_one() -> None:
    assert PLAIN.key == "nothing strong 291100000 short"
    assert of(noise_stated=0.6, gaps=True).key == f"{PLAIN.key} noise_stated 0.6 gaps"
    drawn = blind_cases(6, 3, "use", Faults(jitter=True))
    assert {(one.style, one.faults) for one in drawn} == {("use", Faults(jitter=True))}
    assert [replace(one, faults=NO_FAULTS) for one in drawn] == blind_cases(6, 3, "use")


@pytest.mark.long
def test_each_fault_changes_what_it_says_and_nothing_else() -> None:
    plain = make_recording(PLAIN)
    stated = make_recording(of(noise_stated=0.6, radius_stated=1.08))
    assert stated.fingertip.radius == pytest.approx(1.08 * plain.fingertip.radius)
    assert all(stated.sensors[name] == pytest.approx(0.6 * plain.sensors[name]) for name in plain.sensors)
    lost, later = make_recording(of(gaps=True)), make_recording(of(in_contact=True))
    assert 0.9 < len(lost) / len(plain) < 0.99
    assert later.columns["normal_force"][0] > 20.0 * plain.sensors["normal_force"]
    for some in (lost, later):
        rows = np.isin(plain.t, some.t)
        assert np.array_equal(plain.columns["normal_force"][rows], some.columns["normal_force"])
    shifted = make_recording(of(zero_shift=True))
    moved = [name for name in plain.columns if not np.array_equal(plain.columns[name], shifted.columns[name])]
    assert len(moved) == 1
    change = shifted.columns[moved[0]] - plain.columns[moved[0]]
    assert np.unique(change.round(12)).size == 2
    noisy, quiet = (make_recording(of(jitter=True, gaps=True), quiet=quiet) for quiet in (False, True))
    assert np.array_equal(noisy.t, quiet.t)
    period = np.median(np.diff(plain.t))
    assert np.ptp(np.diff(noisy.t)[np.diff(noisy.t) < 2.0 * period]) > 0.5 * period


@pytest.mark.long
@pytest.mark.parametrize("factor", [0.5, 0.75, 1.0])
def test_noise_that_is_more_than_is_stated_is_measured(factor: float) -> None:
    true = make_recording(PLAIN).sensors
    found = noise_of(make_recording(of(noise_stated=factor)))
    for name in ("normal_force", "displacement", "tangential_force", "torque_z"):
        assert getattr(found, name) == pytest.approx(true[name], rel=0.1)
        assert (found.source[name] == STATED) == (factor == 1.0)
    assert len(found.doubts) == (len(found.source) - 1) * (factor < 1.0)


@pytest.mark.long
@pytest.mark.parametrize("stated", [0.93, 1.08])
def test_a_radius_that_is_stated_wrongly_is_doubted_and_not_named_an_effect(stated: float) -> None:
    recording = make_recording(replace(PLAIN, faults=Faults(radius_stated=stated)))
    found = diagnose(recording, threads=1)
    assert (found.verdict, found.named) == ("adequate", [])
    assert found.model.tip_radius == pytest.approx(recording.fingertip.radius / stated, rel=0.01)
    assert any("the radius of the tip is stated as" in doubt.text for doubt in found.doubts)
