"""Other procedures beside the diagnosis: each writes answers that are scored by one rule."""

import json

import pytest

from validation.diagnosis_trials import procedures
from validation.diagnosis_trials.amounts import CATALOGUE_AMOUNTS
from validation.diagnosis_trials.procedures import KEPT, PROCEDURES
from vegrip.cli import run
from vegrip.identification.blind import Answer, Truth, read_answers

SAID = {
    "001": Answer("named", ("adhesion",), exponent=1.5),
    "002": Answer("ambiguous", (), (("sensor_lag", "fast_damping"),)),
}


@pytest.fixture
def blind(tmp_path, monkeypatch):
    """Make a folder of two recordings that one procedure answers, without a fit."""
    for name in SAID:
        (tmp_path / "blind" / name).mkdir(parents=True)
        (tmp_path / "blind" / name / "recording.toml").touch()
    monkeypatch.setattr(procedures, "read_recording", lambda folder, **_: folder.name)
    monkeypatch.setattr(procedures, "fit", lambda recording: recording)
    monkeypatch.setitem(PROCEDURES, "BIC", lambda name: SAID[name])
    monkeypatch.setattr(procedures, "ProcessPoolExecutor", Here)
    return tmp_path / "blind"


class Here:
    def __init__(self, *_) -> None: ...

    def __enter__(self):
        return self

    def __exit__(self, *_) -> None: ...

    def map(self, work, each):
        return map(work, each)


def test_what_a_procedure_says_is_read_as_answers_and_not_asked_twice(blind, tmp_path, monkeypatch) -> None:
    arguments = [str(blind), "-o", str(tmp_path / "answers"), "--only", "BIC", "--only", "everything"]
    assert run(procedures.procedures, arguments, "procedures", KEPT) == 0
    monkeypatch.setitem(PROCEDURES, "BIC", lambda _: pytest.fail("asked again"))
    assert run(procedures.procedures, arguments, "procedures", KEPT) == 0
    truths = dict.fromkeys(SAID, Truth((), (), "none"))
    effects = json.loads((tmp_path / "answers/everything.json").read_text())["001"]["named"]
    assert set(effects) == CATALOGUE_AMOUNTS.keys()
    told = read_answers(tmp_path / "answers/BIC.json", truths, effects)
    assert [(one.named, one.sets) for one in told.values()] == [
        (one.named, one.sets) for one in SAID.values()
    ]
    assert told["001"].exponent == 1.5
