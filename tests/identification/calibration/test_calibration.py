"""A calibration leads a soft fingertip to its model, by trials of a bench that shares no physics with it."""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.identification.reach import greatest_depth, greatest_speed
from vegrip.errors import InputError, RecordingError, UsageError
from vegrip.identification.calibration.checks import check_trial
from vegrip.identification.calibration.plan import first_of, next_of
from vegrip.identification.calibration.session import (
    JOINED,
    MODEL,
    Calibration,
    Done,
    Standing,
    finish,
    judge,
    load,
    save,
    usual_limits,
)
from vegrip.identification.calibration.trials import TRIAL_KINDS, practice_tip, practise
from vegrip.identification.experiment.design_space import RigLimits
from vegrip.identification.fit import fit
from vegrip.identification.fit.noise import in_air
from vegrip.identification.recording import Fingertip, Recording, read_recording
from vegrip.identification.slip_channel import SlipChannel
from vegrip.model import read_model
from vegrip.parameters import coordinate

Practised = tuple[Calibration, list[str], Standing]
SEED = 4
SOFT = 11


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Practised:
    """A fingertip that nothing knows, through all trials that are asked for, and what is judged of it."""
    tip = practice_tip(SEED)
    calibration = Calibration(
        tmp_path_factory.mktemp("calibration"), tip.radius, usual_limits(RigLimits(), tip.radius)
    )
    why = []
    while (found := (judged := judge(calibration)).next).trial is not None:
        assert greatest_depth(found.trial.protocol) <= calibration.limits.depth * 1.001
        assert greatest_speed(found.trial.protocol) <= calibration.limits.speed * 1.001
        recording = practise(found.trial, tip, SEED + len(calibration.trials))
        assert float(recording.columns["normal_force"].max()) <= 1.3 * calibration.limits.force
        calibration.take(recording)
        why.append(found.why)
    save(calibration)
    return calibration, why, judged


@pytest.mark.long
def test_every_kind_is_done_once_and_in_its_order(done: Practised) -> None:
    calibration, why, _ = done
    assert tuple(dict.fromkeys(one.kind for one in calibration.trials)) == TRIAL_KINDS
    assert all(one.is_good for one in calibration.trials)
    assert why[0].startswith("nothing is known yet")
    assert all("not yet" in text or "no good" in text for text in why[1:])


@pytest.mark.long
def test_the_model_is_that_of_the_fingertip(done: Practised) -> None:
    calibration = done[0]
    ended = finish(calibration, "vegrip calibrate tip --end")
    tip = practice_tip(SEED)
    values = read_model(calibration.folder / MODEL).values
    assert values["mu"].value == pytest.approx(tip.friction, rel=0.05)
    assert values["p"].value == pytest.approx(tip.exponent, abs=0.05)
    force = tip.reference_force * (0.1 * tip.radius / tip.reference_indentation) ** tip.exponent
    assert values["K"].value == pytest.approx(force, rel=0.08)
    assert all(one.std > 0.0 for one in ended.known)
    assert ended.error < 1.15
    alone = fit(read_recording(calibration.folder / JOINED), read_model(calibration.folder / MODEL))
    assert alone.error == pytest.approx(ended.error, rel=0.02), "one zero goes for all that is kept"
    assert ended.account["calibration"]["again"] == []
    if ended.added:  # what was found missing is asked for from then on
        assert {one.symbol for one in judge(deepcopy(calibration)).known} == {
            one.symbol for one in ended.known
        }


def test_a_calibration_goes_on_where_it_was(done: Practised) -> None:
    calibration = done[0]
    assert load(calibration.folder) == calibration


def test_a_rig_that_cannot_pull_or_twist_is_told_what_is_left_out(
    done: Practised,
) -> None:
    calibration, _, judged = done
    limits = replace(calibration.limits, tangential_force=0.0, torque=0.0)
    assert judged.fit is not None
    found = next_of(judged.fit, ["press"], ["press"], limits)
    assert set(found.left_out) == {"slide", "twist"}
    assert found.trial is not None
    assert found.trial.kind == "hold"


def test_while_the_slides_do_not_tell_how_slip_is_felt_one_more_is_asked_for(
    done: Practised, monkeypatch: pytest.MonkeyPatch
) -> None:
    calibration = deepcopy(done[0])
    assert calibration.slip_channel().lacking == ""
    assert done[2].next.trial is None
    monkeypatch.setattr(Calibration, "slip_channel", lambda _: SlipChannel(1e-4, float("nan"), 2))
    found = judge(calibration).next
    assert found.trial is not None
    assert found.trial.kind == "slide"
    assert "2 slides begin clearly in the load, 3 are needed" in found.why


def test_a_recording_is_taken_once(done: Practised) -> None:
    calibration = deepcopy(done[0])
    for kind in ("press", "hold"):
        with pytest.raises(UsageError, match=r"is the recording of trial 2 \(hold\) again"):
            calibration.take(read_recording(calibration.folder / calibration.trials[1].folder), kind)
    assert calibration == done[0]


def test_a_trial_that_fails_twice_is_not_asked_for_a_third_time(done: Practised) -> None:
    calibration, _, judged = done
    assert judged.fit is not None
    once = next_of(judged.fit, ["press", "hold", "slide"], [*TRIAL_KINDS], calibration.limits)
    assert once.trial is not None
    assert once.trial.kind == "twist"
    twice = next_of(judged.fit, ["press", "hold", "slide"], [*TRIAL_KINDS, "twist"], calibration.limits)
    assert twice.trial is None or "no good twist" not in twice.why


def test_the_first_trial_is_gentle() -> None:
    limits = usual_limits(RigLimits(), 9e-3)
    gentle, bold = (first_of(9e-3, replace(limits, force=force)).trial for force in (0.5, 5.0))
    assert gentle is not None
    assert bold is not None
    assert greatest_depth(gentle.protocol) < greatest_depth(bold.protocol) <= 0.51 * limits.depth


def test_a_fingertip_softer_than_guessed_is_pressed_deeper_and_not_refused(tmp_path: Path) -> None:
    tip = practice_tip(SOFT)
    calibration = Calibration(tmp_path, tip.radius, usual_limits(RigLimits(), tip.radius))
    first = judge(calibration).next.trial
    assert first is not None
    done = calibration.take(practise(first, tip, SOFT))
    assert "too gently" in done.problems[0]
    second = judge(calibration).next.trial
    assert second is not None
    assert second.kind == "press"
    assert greatest_depth(second.protocol) > 1.5 * greatest_depth(first.protocol)
    assert calibration.take(practise(second, tip, SOFT + 1)).is_good


def test_a_gentle_hold_that_the_noise_of_the_displacement_shakes_is_a_hold() -> None:
    t = np.arange(0.0, 5.0, 0.005)
    depth = 0.3e-3 * np.clip((t - 0.5) / 0.2, 0.0, 1.0)
    force = 0.36 * (depth / 0.3e-3) * (0.8 + 0.2 * np.exp(-np.clip(t - 0.7, 0.0, None)))
    rng = np.random.default_rng(3)
    columns = {
        "displacement": depth + rng.normal(0.0, 5e-6, t.size),
        "normal_force": force + rng.normal(0.0, 0.01, t.size),
    }
    sensors = {"displacement": 5e-6, "normal_force": 0.01}
    hold = Recording("hold", t, np.zeros(t.size, int), columns, Fingertip(5e-3), sensors)
    assert check_trial("hold", hold) == []
    moving = {**columns, "displacement": columns["displacement"] + 3e-5 * np.clip(t - 0.7, 0.0, None)}
    swelling = {**moving, "normal_force": columns["normal_force"] + 0.05 * np.clip(t - 0.7, 0.0, None)}
    (said,) = check_trial("hold", replace(hold, columns=swelling))
    assert "hold still" in said


def test_a_zero_that_differs_from_trial_to_trial_is_taken_off_each(tmp_path: Path) -> None:
    tip = practice_tip(SEED)
    limits = usual_limits(RigLimits(), tip.radius)
    trial = first_of(tip.radius, limits).trial
    assert trial is not None
    practised = [practise(trial, tip, number) for number in range(2)]
    joined = []
    for folder, zeros in (("same", (0.0, 0.0)), ("other", (0.02, -0.03))):
        calibration = Calibration(tmp_path / folder, tip.radius, limits)
        for made, zero in zip(practised, zeros, strict=True):
            force = made.columns["normal_force"] + zero
            calibration.take(replace(made, columns={**made.columns, "normal_force": force}), "press")
        joined.append(calibration.joined()[0].columns["normal_force"])
    assert joined[0] == pytest.approx(joined[1], abs=1e-9)
    air = in_air(calibration.joined()[0])
    assert abs(float(np.mean(joined[0][air]))) < 1e-3


@pytest.mark.long
def test_a_rig_that_loses_its_zeros_between_trials_costs_no_accuracy(done: Practised, tmp_path: Path) -> None:
    calibration = done[0]
    tip = practice_tip(SEED)
    moved = Calibration(tmp_path, tip.radius, calibration.limits)
    zeros = (0.0, 40e-6, -60e-6, 25e-6, -35e-6)  # [m]
    for one, zero in zip(calibration.trials, zeros, strict=False):
        made = read_recording(calibration.folder / one.folder)
        away = made.columns["displacement"] + zero
        moved.take(replace(made, columns={**made.columns, "displacement": away}), one.kind)
    joined = calibration.joined(), moved.joined()
    kept, lost = (fit(whole, zeros=trials) for whole, trials in joined)
    for symbol in kept.problem.symbols:
        _, parameter = kept.model.parameters[symbol]
        one, other = kept.model.values[symbol], lost.model.values[symbol]
        off = coordinate(parameter, other.value) - coordinate(parameter, one.value)
        assert abs(off) < 0.5 * one.std, symbol
    assert lost.error == pytest.approx(kept.error, rel=0.01)


def _like(recording: Recording, **columns: np.ndarray | None) -> Recording:
    changed = {**recording.columns, **columns}
    return replace(recording, columns={k: v for k, v in changed.items() if v is not None})


def test_what_a_trial_lacks_is_said_with_the_remedy(done: Practised) -> None:
    calibration = done[0]
    by_kind = {one.kind: read_recording(calibration.folder / one.folder) for one in calibration.trials}
    hold, slide, twist = by_kind["hold"], by_kind["slide"], by_kind["twist"]
    assert "equally fast" in check_trial("press", hold)[0]
    assert "hold still" in check_trial("hold", by_kind["press"])[-1]
    assert "slides in 0 rows" in check_trial("slide", _like(slide, slip=np.zeros(len(slide))))[0]
    assert "no slip column" in check_trial("slide", _like(slide, slip=None))[0]
    flat = {"tangential_force_x": None, "tangential_force_y": None, "torque_z": None}
    assert "no tangential force" in check_trial("slide", _like(slide, **flat))[0]
    assert "no torque" in check_trial("twist", _like(twist, torque_z=np.zeros(len(twist))))[-1]
    noise = 1e-4 * np.random.default_rng(0).standard_normal(len(twist))
    drowned = _like(twist, torque_z=1e-2 * twist.columns["torque_z"] + noise)
    assert "its torque reaches" in check_trial("twist", drowned)[-1]
    touching = slide.columns["normal_force"] > 0.5 * slide.columns["normal_force"].max()
    late = slide.select(np.arange(len(slide)) >= int(np.argmax(touching)))
    assert "half a second in the air" in check_trial("slide", late)[0]


def test_what_cannot_be_used_is_refused_and_not_kept(tmp_path: Path) -> None:
    calibration = Calibration(tmp_path, 9e-3, usual_limits(RigLimits(), 9e-3))
    t = np.arange(500) * 5e-3
    rest = np.random.default_rng(0).normal(0.0, 0.01, t.size)
    nothing = Recording(
        "air", t, np.zeros(t.size, dtype=np.int64), {"normal_force": rest, "displacement": rest}
    )
    with pytest.raises(RecordingError, match="nothing is pressed"):
        calibration.take(nothing)
    with pytest.raises(RecordingError, match="no displacement"):
        calibration.take(replace(nothing, columns={"normal_force": rest}))
    with pytest.raises(UsageError, match="no trial 'poke'"):
        calibration.take(nothing, "poke")
    with pytest.raises(UsageError, match="no trial 1"):
        calibration.drop(1)
    assert calibration.trials == []
    assert not (tmp_path / "trials").exists()


@pytest.mark.parametrize("text", ["", "[]", '{"radius": "x"}', '{"radius": 1, "limits": {}, "trials": [{}]}'])
def test_a_damaged_calibration_is_one_sentence(tmp_path: Path, text: str) -> None:
    (tmp_path / "calibration.json").write_text(text)
    with pytest.raises(InputError, match="cannot be read"):
        load(tmp_path)


def test_what_to_record_again_are_kinds_without_a_good_trial(tmp_path: Path) -> None:
    calibration = Calibration(tmp_path, 9e-3, usual_limits(RigLimits(), 9e-3))
    calibration.trials = [
        Done("press", "presses", "trials/1-press", ["too slow"]),
        Done("press", "presses", "trials/2-press"),
        Done("hold", "one hold", "trials/3-hold", ["too short"]),
    ]
    assert calibration.again == ["hold (one hold): too short"]
