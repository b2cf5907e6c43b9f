"""How an answer is judged, and the cases that are drawn."""

import json
from dataclasses import replace

import numpy as np
import pytest

from validation.diagnosis_trials import Case, Outcome, draw_cases, make_recording, tally_outcomes
from validation.diagnosis_trials.__main__ import trial
from validation.diagnosis_trials.amounts import CATALOGUE_AMOUNTS, DRAWN_BY_NAME, UNMODELLED_AMOUNTS
from validation.diagnosis_trials.cases import places_of
from validation.diagnosis_trials.unmodelled import UNMODELLED as UNKNOWN
from validation.diagnosis_trials.visible import remaining_evidence
from vegrip.cli import run
from vegrip.effects import BUILT_IN
from vegrip.identification.fit import fit
from vegrip.virtual.hidden import HIDDEN


def of(hidden, verdict, named=(), sets=(), variable="", after=1.0, leaves=(), places=1) -> Outcome:
    case = Case(hidden, "strong", 0, places)
    return Outcome(case, verdict, named, sets, variable, 2.0, after, (9.0, 1.0), 1.0, dict(leaves))


@pytest.mark.parametrize(
    ("outcome", "answer"),
    [
        (of((), "adequate"), "right"),
        (of((), "unexplained", variable="time"), "wrong"),
        (of(("adhesion",), "named", ("adhesion",)), "right"),
        (of(("adhesion",), "named", ("adhesion", "sensor_lag")), "wrong"),
        (of(("adhesion",), "named", ("sensor_lag",)), "wrong"),
        (of(("adhesion",), "adequate"), "missed"),
        (of(("adhesion",), "unexplained", ("adhesion",)), "unexplained"),
        (of(("adhesion",), "ambiguous", ("force_drift",), (("adhesion", "force_drift"),)), "set"),
        (of(("adhesion",), "ambiguous", ("force_drift",), (("inertia", "force_drift"),)), "wrong"),
        (of(("adhesion", "sensor_lag"), "named", ("adhesion",)), "partly"),
        (of(("adhesion", "sensor_lag"), "named", ("sensor_lag", "adhesion")), "right"),
        (of(("adhesion", "sensor_lag"), "named", ("adhesion",), leaves={"sensor_lag": 3.0}), "right"),
        (of(("adhesion", "sensor_lag"), "named", ("adhesion",), leaves={"sensor_lag": 30.0}), "partly"),
        (of(("day_and_night",), "unexplained", variable="time"), "right"),
        (of(("day_and_night",), "unexplained", variable="speed"), "other variable"),
        (of(("day_and_night",), "named", ("mullins_softening",)), "wrong"),
        (of(("day_and_night",), "adequate"), "missed"),
    ],
)
def test_an_answer_is_right_only_with_exactly_what_is_hidden(outcome, answer) -> None:
    assert outcome.answer == answer
    assert outcome.right == (answer in ("right", "set"))
    assert Outcome.of(json.loads(json.dumps(outcome.as_dict()))) == outcome


def test_tally_counts_by_kind_and_says_what_was_taken_for_what() -> None:
    told = tally_outcomes(
        [
            of((), "adequate"),
            of((), "named", ("sensor_lag",)),
            of(("adhesion",), "named", ("adhesion",)),
            of(("adhesion", "sensor_lag"), "named", ("adhesion",), after=1.2),
            of(("crack",), "unexplained", variable="time"),
        ]
    )
    assert told["false_alarms"] == 1
    assert {kind: some["right"] for kind, some in told["kinds"].items()} == {
        "none": 1, "one": 1, "pair": 0, "outside": 1,
    }  # fmt: skip
    assert told["confusion"]["nothing"] == {"adequate": 1, "sensor_lag": 1}
    assert told["at_the_floor"] == {"right": 1, "of": 2}


def test_what_a_recording_cannot_show_is_counted_by_itself_whatever_was_said() -> None:
    dim = {"adhesion": 2.0}
    told = tally_outcomes(
        [
            of(("adhesion",), "adequate", leaves=dim),
            of(("adhesion",), "named", ("adhesion",), leaves=dim),
            of(("adhesion",), "adequate", leaves={"adhesion": 20.0}),
        ]
    )
    assert told["kinds"]["one"]["answers"] == {"missed": 1}
    assert told["out_of_sight"] == {"adhesion": {"adequate": 1, "adhesion": 1}}


@pytest.mark.long
def test_what_an_effect_leaves_is_seen_in_the_same_recording_without_it() -> None:
    shown = remaining_evidence(Case(("adhesion", "pressure_profile"), "weak", 3, style="short"))
    assert shown["adhesion"] > 100.0
    assert abs(shown["pressure_profile"]) < 20.0
    assert remaining_evidence(Case((), "strong", 3, style="short")) == {}


def test_everything_the_bench_can_hide_has_an_amount_and_a_name_of_the_catalogue_or_a_variable() -> None:
    assert set(CATALOGUE_AMOUNTS) == set(HIDDEN) - {"sensor_delay"}
    assert set(HIDDEN) <= set(BUILT_IN)
    assert set(UNMODELLED_AMOUNTS) == set(UNKNOWN)
    assert not set(UNMODELLED_AMOUNTS) & set(BUILT_IN)
    assert all(kind.shows for kind in UNKNOWN.values())


def test_cases_hold_every_kind_and_every_effect_and_no_seed_twice() -> None:
    drawn = list(draw_cases(400, seed=3))
    assert {one.kind for one in drawn} == {"none", "one", "pair", "outside"}
    assert {one.hidden[0] for one in drawn if one.kind == "one"} == set(CATALOGUE_AMOUNTS) - {*DRAWN_BY_NAME}
    assert {one.size for one in drawn if one.kind == "one"} == {"strong", "weak"}
    assert {one.hidden[0] for one in drawn if one.kind == "outside"} == set(UNMODELLED_AMOUNTS)
    assert len({one.seed for one in drawn}) == 400
    assert not {one.seed for one in drawn} & {one.seed for one in draw_cases(400, seed=4)}
    assert drawn[:50] == list(draw_cases(50, seed=3))
    for name in ("adhesion", *DRAWN_BY_NAME):
        assert {one.hidden for one in draw_cases(20, kinds=["one"], only=[name])} == {(name,)}


def test_places_are_a_matter_of_the_case_and_hide_nothing_that_goes_by_the_hour() -> None:
    drawn = list(draw_cases(60, seed=3, kinds=["one"], places=3))
    assert {one.places for one in drawn} == {3}
    assert {one.hidden[0] for one in drawn} == set(CATALOGUE_AMOUNTS) - {"force_drift", *DRAWN_BY_NAME}
    assert drawn[0].key != replace(drawn[0], places=1).key
    assert of((), "unexplained", places=3).right
    assert not of((), "named", ("sensor_lag",), places=3).right


@pytest.mark.long
def test_each_place_is_as_stiff_as_its_own_recording_says() -> None:
    case = Case((), "strong", 4, places=2)
    recording = make_recording(case)
    own = fit(recording, laws=places_of(case, np.unique(recording.episode).size))
    assert own.error == pytest.approx(1.0, abs=0.05)
    assert fit(recording).error > 1.5
    softer, stiffer = sorted(law["K"] for law in own.laws)
    assert stiffer > 1.05 * softer


@pytest.mark.long
def test_the_same_case_is_the_same_recording() -> None:
    one, again = (make_recording(Case(("sensor_lag",), "weak", 5)) for _ in range(2))
    other = make_recording(Case(("sensor_lag",), "strong", 5))
    assert all(np.array_equal(one.columns[name], again.columns[name]) for name in one.columns)
    assert not np.array_equal(one.columns["normal_force"], other.columns["normal_force"])
    assert np.array_equal(one.columns["displacement"], other.columns["displacement"])


def main(arguments: list[str]) -> int:
    return run(trial, arguments, "trials")


def test_command_goes_on_where_it_was_stopped(tmp_path, capsys) -> None:
    file = tmp_path / "done.jsonl"
    wanted = list(draw_cases(3, seed=2, kinds=["none"]))
    file.write_text("".join(json.dumps(_adequate(one).as_dict()) + "\n" for one in wanted))
    arguments = ["-n", "3", "--seed", "2", "--kind", "none", "-o", str(file), "--json"]
    assert main(arguments) == 0  # nothing left to do
    told = json.loads(capsys.readouterr().out)
    assert told["trials"] == 3
    assert told["false_alarms"] == 0
    assert main(arguments[:-1]) == 0
    assert "100%" in capsys.readouterr().out
    file.write_text("{}\n")
    assert main(arguments) == 3
    assert "line 1" in capsys.readouterr().err
    assert main(["--effect", "magic"]) == 2
    assert main(["--kind", "some"]) == 2
    assert "Traceback" not in capsys.readouterr().err


def _adequate(case: Case) -> Outcome:
    return Outcome(case, "adequate", (), (), "", 1.0, 1.0, (1.0, 1.0), 1.0)
