"""A jump of a sensor's zero is found where and as large as it was made, and only there."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.identification.diagnosis import diagnose, diagnosis
from vegrip.identification.diagnosis.candidate_fit import evaluate_candidate, held_out_groups
from vegrip.identification.diagnosis.diagnosis import Diagnosis
from vegrip.identification.diagnosis.zero_jump import Jump, find_jump
from vegrip.identification.experiment.design import next_experiment
from vegrip.identification.fit import fit, noise_of


def found(sample, plain):
    start = fit(sample, noise=noise_of(plain))  # else one jump of the force may pass for slow noise
    return find_jump(evaluate_candidate(start.problem, start.optimum, held_out_groups(start.problem)), 20.0)


def test_nothing_jumps_where_noise_is_left(tip) -> None:
    assert found(tip(13, pull=0.0), tip(13, pull=0.0)) is None


@pytest.mark.parametrize(("channel", "size"), [("normal_force", -0.06), ("displacement", 3e-5)])
def test_a_jump_is_found_with_its_row_and_size_and_taken_off(tip, channel: str, size: float) -> None:
    sample = tip(13, pull=0.0)
    depth = sample.columns["displacement"]
    pressed = np.flatnonzero(depth > 0.5 * depth.max())  # in the air a displacement says nothing of its zero
    row = int(pressed[pressed.size // 2])
    later = np.arange(len(sample)) >= row
    jumped = replace(sample, columns=sample.columns | {channel: sample.columns[channel] + size * later})
    jump = found(jumped, sample)
    assert jump is not None
    assert jump.channel == channel
    assert abs(jump.row - row) <= 2
    assert jump.size == pytest.approx(size, rel=0.1)
    left = jump.removed(jumped).columns[channel] - sample.columns[channel]
    assert np.abs(np.delete(left, np.arange(row - 2, row + 2))).max() < 0.1 * abs(size)


@pytest.mark.parametrize(
    ("is_jump", "size", "named", "sets"),
    [
        pytest.param(True, 0.06, [], [], marks=pytest.mark.long),
        (True, 0.01, [], []),  # of one noise
        (False, 0.01, ["force_drift"], []),
    ],
)
def test_a_jump_is_named_no_drift_and_a_drift_no_jump(tip, is_jump, size, named, sets) -> None:
    sample = tip(13, kinds=("hold", "ramp", "hold"))
    n = len(sample)
    shape = np.arange(n) >= 0.55 * n if is_jump else sample.t / sample.t[-1]
    force = sample.columns["normal_force"] + size * shape
    found = diagnose(replace(sample, columns=sample.columns | {"normal_force": force}), threads=1)
    assert (found.named, found.indistinguishable) == (named, sets)
    said = [one.text for one in found.doubts if "the zero of the force jumps by" in one.text]
    assert len(said) == is_jump
    told = [float(text.split(" at ")[1].split(" s,")[0]) for text in said]
    assert told == pytest.approx([sample.t[shape.argmax()]] * is_jump, abs=0.05)
    assert next_experiment(found) is None  # that a motion could make


@pytest.mark.parametrize(
    ("gain", "known", "is_taken"),
    [(69.0, (), False), (71.0, (), True), (56.0, (300,), True), (54.0, (300,), False)],
)
def test_a_jump_pays_for_its_place_and_another_size_of_a_known_one_does_not(
    monkeypatch, gain, known, is_taken
) -> None:
    def jump(row: int, size: float) -> Jump:
        return Jump("normal_force", row, 0.01 * row, size, gain)

    monkeypatch.setattr(diagnosis, "find_jump", lambda _, least: jump(303, 0.1) if gain > least else None)
    taken = SimpleNamespace(verdict=SimpleNamespace(gain=50.0))
    search = SimpleNamespace(steps=[SimpleNamespace(base=None, taken=taken)], within=lambda _: 5.0)
    one = Diagnosis(SimpleNamespace(), search, jumps={("normal_force", row): jump(row, 0.5) for row in known})
    monkeypatch.setattr(Diagnosis, "verdict", "named")
    assert one.jump == (replace(jump(303, 0.1), row=(*known, 303)[0]) if is_taken else None)
