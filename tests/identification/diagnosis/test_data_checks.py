"""Recordings that cannot carry an answer: said in words, and nothing named."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.errors import RecordingError
from vegrip.identification.diagnosis import data_checks, diagnose
from vegrip.identification.diagnosis.candidate_fit import evaluate_candidate, held_out_groups
from vegrip.identification.diagnosis.data_checks import (
    apart,
    check_before_search,
    check_clocks,
    check_lookalikes,
    refuse_unusable,
    shift,
)
from vegrip.identification.fit import fit
from vegrip.identification.recording import Fingertip, Recording

KINDS = ("hold", "ramp", "hold", "ramp", "hold", "ramp")


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


def pressed(
    *, rows: int = 800, depth: float = 1e-3, late: int = 0, missing: int = 0, still: int = 0
) -> SimpleNamespace:
    """Return a problem of presses of half a second that has at most the fault that is asked for."""
    step, k, tip = 5e-3, np.arange(rows), 0.008
    displacement = depth * np.sin(2.0 * np.pi * k * step)
    force = np.roll(np.maximum(displacement / depth, 0.0) ** 1.5, late)
    displacement[205 : 205 + still] = displacement[205]
    recording = SimpleNamespace(
        is_step=False,
        t=k * step,
        episode=np.zeros(rows, dtype=np.int64),
        columns={"displacement": displacement, "normal_force": force},
        fingertip=SimpleNamespace(radius=tip),
        source={"missing_states": missing},
    )
    measured = SimpleNamespace(
        recording=recording,
        motion=SimpleNamespace(displacement=displacement),
        first=np.r_[1.0, np.zeros(rows - 1)],
        force=force,
    )
    model = SimpleNamespace(tip_radius=tip)
    return SimpleNamespace(measured=measured, model=model, stiffness=np.maximum(displacement, 0.0))


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ({}, ""),
        ({"rows": 280}, "are in contact: too little"),
        ({"rows": 420}, ""),
        ({"depth": 7.3e-3}, "the deepest indentation is 7.3 mm, the radius of the tip is stated as 8 mm"),
        ({"depth": 7.1e-3}, ""),
        ({"late": 41}, "the force changes 205 ms after the displacement"),
        ({"late": 40}, "the force changes 200 ms after the displacement: a slow sensor"),
        ({"late": -41}, "the force changes 205 ms before the displacement"),
        ({"late": 4}, "the force changes 20 ms after the displacement: a slow sensor"),
        ({"late": -4}, "the force changes 20 ms before the displacement: a slow sensor"),
        ({"late": 3}, ""),
        (
            {"still": 20},
            "the force rises by 0.505 N within 0.095 s of one displacement: its sensor stands still",
        ),
        ({"still": 19}, ""),
        ({"missing": 7}, "7 states were sent"),
    ],
)
def test_each_fault_of_a_recording_is_a_doubt_of_its_own_and_some_are_grave(fault, words) -> None:
    found = list(check_before_search(pressed(**fault)))
    is_grave = "missing" not in fault and "a slow sensor" not in words
    assert [one.is_grave for one in found] == [is_grave] * bool(words)
    assert all(words in one.text for one in found)


def test_rates_say_nothing_of_clocks_across_gaps_in_the_air_or_without_a_motion() -> None:
    m = pressed(late=40).measured
    t, depth, force = m.recording.t, m.motion.displacement, m.force
    assert shift(t, m.first, depth, force) == pytest.approx(0.2)
    assert shift(t, m.first, -np.abs(depth), force) == 0.0
    assert shift(t, m.first, depth, np.full(t.size, 2.0)) == 0.0
    assert shift(t, m.first, depth, np.random.default_rng(2).standard_normal(t.size)) == 0.0
    assert shift(t, np.ones(t.size), depth, force) == 0.0
    assert shift(np.cumsum(np.tile([5e-3, 0.02], 400)), m.first, depth, force) != pytest.approx(0.2)


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


@pytest.mark.parametrize("noises", [7.9, 8.1])
def test_a_force_within_eight_times_its_noise_touches_nothing(noises) -> None:
    force = 0.3 + 0.01 * np.r_[np.zeros(500), np.full(500, noises), np.nan]
    measured = SimpleNamespace(force=force, noise=SimpleNamespace(normal_force=0.01))
    if noises > 8.0:
        refuse_unusable(SimpleNamespace(name="air"), measured)
        return
    with pytest.raises(RecordingError, match=r"air is without contact.*\(0.3 N, \+-0.01 N\)"):
        refuse_unusable(SimpleNamespace(name="air"), measured)


@pytest.mark.parametrize("seconds", [0.012, -0.012])
def test_the_clock_of_a_force_that_is_late_or_early_is_fitted(tip, seconds) -> None:
    found = fit(tip(13, kinds=("hold", "ramp"), late=("delay", seconds)))
    base = evaluate_candidate(found.problem, found.optimum, held_out_groups(found.problem))
    late, gain = apart(base)
    assert late == pytest.approx(seconds, abs=1e-4)
    n = found.problem.counted.sum()  # nearly all of the misfit goes
    assert gain == pytest.approx(0.5 * n * (base.error**2 - 1.0), rel=0.02)


@pytest.mark.parametrize(
    ("late", "gain", "best", "said"),
    [
        (0.01, 19.9, 0.0, ""),
        (0.01, 20.1, -5.0, "10 ms late"),
        (0.01, 1121.0, 1000.0, "10 ms late"),
        (0.01, 1119.0, 1000.0, ""),
        (-0.02, 1022.0, 1000.0, "20 ms early"),
        (-0.02, 1020.0, 1000.0, ""),
        (0.0, 1022.0, 1000.0, "0 ms early"),
    ],
)
def test_clocks_are_doubted_where_they_explain_more_than_any_effect(
    monkeypatch, late, gain, best, said
) -> None:
    """By 20 nats, and a late one, which may be a slow sensor, by a tenth more."""
    monkeypatch.setattr(data_checks, "apart", lambda _: (late, gain))
    found = check_clocks(None, best)
    assert [one.is_grave for one in found] == [True] * bool(said)
    assert all(f"a force that is {said} explains more" in one.text for one in found)


def test_what_else_would_look_like_an_effect_is_told_with_its_values() -> None:
    told = check_lookalikes(["adhesion", "sensor_lag"], {"tau": 0.0123}, 0.01)
    assert len(told) == 1
    assert "12" in told[0].text
    assert not told[0].is_grave


@pytest.mark.slow
def test_a_force_that_is_early_has_a_wrong_clock_and_no_effect_is_named(tip) -> None:
    """No sensor shows what will be; a slow one of the displacement looks like it, but touches otherwise."""
    found = diagnose(tip(15, kinds=KINDS, late=("delay", -0.008)))
    assert (found.verdict, found.named) == ("unexplained", [])
    assert any("ms early explains more" in one.text for one in found.doubts if one.is_grave)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "name", "symbol"),
    [
        ("lag", "sensor_lag", "tau"),
        pytest.param("delay", "sensor_delay", "T_y", marks=pytest.mark.long),
        ("displacement", "displacement_lag", "tau_d"),
    ],
)
def test_a_slow_sensor_is_named_by_the_shape_of_what_it_shows(tip, kind, name, symbol) -> None:
    found = diagnose(tip(23, kinds=KINDS, late=(kind, 0.016)))
    assert found.named == [name]
    assert found.model.values[symbol].value == pytest.approx(0.016, rel=0.05)
    assert not any(one.is_grave for one in found.doubts)


@pytest.mark.long
def test_a_slow_sensor_is_measured_beside_many_relaxation_times(tip) -> None:
    seconds, branches = 0.016, ((0.12, 20.0), (0.12, 3.0), (0.12, 0.4))
    found = diagnose(tip(27, kinds=KINDS, branches=branches, late=("lag", seconds)))
    assert found.verdict in ("named", "ambiguous")
    assert "sensor_lag" in [one.candidate.name for one in found.search.accepted]
    assert found.model.values["tau"].value == pytest.approx(seconds, rel=0.2)


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


@pytest.mark.long
def test_flat_tops_are_the_end_of_the_scale(bench) -> None:
    force = bench().columns["normal_force"]
    found = diagnose(changed(bench(), normal_force=np.minimum(force, 0.7 * force.max())))
    assert "saturation" in [one.candidate.name for one in found.search.accepted]
    assert any("saturate" in sentence for sentence in found.as_dict()["warnings"])
