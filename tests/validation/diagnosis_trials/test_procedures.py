"""Other procedures beside the diagnosis: what they are right or wrong about is counted by one rule."""

import pytest

from validation.diagnosis_trials import procedures
from validation.diagnosis_trials.cases import Case
from validation.diagnosis_trials.procedures import NAMELESS, PROCEDURES, Said, judge, tally


@pytest.fixture
def answers(monkeypatch):
    """Let every procedure give the same answer, without a fit."""
    recording = type("Tip", (), {"exponent": 2.0})
    monkeypatch.setattr(procedures, "make_recording", lambda _: None)
    monkeypatch.setattr(procedures, "fingertip", lambda _: recording)
    monkeypatch.setattr(procedures, "fit", lambda _: None)

    def give(said: Said) -> None:
        monkeypatch.setattr(procedures, "PROCEDURES", dict.fromkeys(PROCEDURES, lambda *_: said))

    return give


@pytest.mark.parametrize(
    ("hidden", "said", "by_name", "by_sight"),
    [
        ((), Said(False, (), 2.5), True, True),
        ((), Said(True, ("adhesion",), 2.5), False, False),
        (("adhesion",), Said(True, ("adhesion",), 2.5), True, True),
        (("adhesion",), Said(True, ("adhesion", "presliding"), 2.5), False, True),
        (("adhesion",), Said(False, (), 2.5), False, False),
        (("cogging",), Said(True, (), 2.5), True, True),
        (("cogging",), Said(True, ("adhesion",), 2.5), False, True),
    ],
)
def test_right_is_who_names_exactly_what_is_hidden_or_sees_it_where_it_has_no_names(
    answers, hidden, said, by_name, by_sight
) -> None:
    answers(said)
    told = judge(Case(hidden, "strong", 1))
    assert {told[name]["right"] for name in set(PROCEDURES) - set(NAMELESS)} == {by_name}
    assert {told[name]["right"] for name in NAMELESS} == {by_sight}
    row = tally([told, told])["BIC"]
    assert row[Case(hidden, "strong", 1).kind] == f"{2 * by_name} of 2"
    assert row["bias"] == pytest.approx(0.5)
    assert row["false"] == 2 * bool(set(said.names) - ({*hidden} if hidden != ("cogging",) else set()))
