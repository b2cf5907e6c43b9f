"""The score of answers to blind recordings: exact, and no hedge pays."""

import json

import pytest

from vegrip.cli import main
from vegrip.identification.blind import Answer, Truth, score

ONE = Truth(("adhesion",), ("adhesion",), "one", style="use")
TWO = Truth(("adhesion", "sensor_lag"), ("adhesion", "sensor_lag"), "pair")
DIM = Truth(("adhesion", "sensor_lag"), ("adhesion",), "pair")
DARK = Truth(("adhesion",), (), "one")
NONE = Truth((), (), "none")
OUTSIDE = Truth(("speed_band",), ("speed_band",), "outside", ("speed",))
NOTHING, UNEXPLAINED = Answer("adequate"), Answer("unexplained")
EVERYTHING = Answer("named", ("adhesion", "sensor_lag", "fast_damping"))


def one_of(*sets: tuple[str, ...], named: tuple[str, ...] = ()) -> Answer:
    return Answer("ambiguous", named, sets)


@pytest.mark.parametrize(
    ("truth", "answer", "points"),
    [
        (NONE, NOTHING, 1.0),
        (NONE, UNEXPLAINED, 0.0),
        (NONE, one_of(("adhesion", "sensor_lag")), 0.0),
        (ONE, Answer("named", ("adhesion",)), 1.0),
        (ONE, NOTHING, 0.0),
        (ONE, EVERYTHING, 0.0),
        (ONE, one_of(("adhesion", "force_drift")), 0.5),
        (ONE, one_of(("adhesion", "force_drift", "sensor_lag")), 1.0 / 3.0),
        (ONE, one_of(("force_drift", "sensor_lag")), 0.0),
        (ONE, one_of(()), 0.0),
        (ONE, one_of(("force_drift", "sensor_lag"), named=("adhesion",)), 0.0),
        (TWO, Answer("named", ("sensor_lag", "adhesion")), 1.0),
        (TWO, Answer("named", ("adhesion",)), 0.0),
        (TWO, one_of(("adhesion", "sensor_lag")), 0.0),
        (TWO, one_of(("sensor_lag", "fast_damping"), named=("adhesion",)), 0.5),
        (TWO, one_of(("sensor_lag", "fast_damping"), ("adhesion", "force_drift")), 0.25),
        (DIM, Answer("named", ("adhesion",)), 1.0),
        (DIM, Answer("named", ("adhesion", "sensor_lag")), 1.0),
        (DIM, Answer("named", ("sensor_lag",)), 0.0),
        (OUTSIDE, Answer("unexplained", variable="speed"), 1.0),
        (OUTSIDE, Answer("unexplained", variable="time"), 0.0),
        (OUTSIDE, UNEXPLAINED, 0.0),
        (OUTSIDE, Answer("named", ("adhesion",)), 0.0),
    ],
)
def test_points_are_how_often_a_draw_from_the_answer_is_exactly_right(truth, answer, points) -> None:
    assert answer.points(truth) == pytest.approx(points)


def test_what_no_recording_shows_is_not_asked_and_no_answer_is_no_point() -> None:
    truths = {"1": NONE, "2": ONE, "3": DARK, "4": OUTSIDE}
    told = score(truths, {"2": Answer("named", ("sensor_lag",)), "3": EVERYTHING, "4": UNEXPLAINED})
    assert told["score"] == 0.0
    assert told["asked"] == 3
    assert told["falsely_named"] == 1
    assert told["grades"] == {"no answer": 1, "wrong": 1, "other variable": 1}
    told = score(truths, {"1": NOTHING, "2": one_of(("adhesion", "force_drift"))})
    assert told["score"] == pytest.approx(0.5)
    assert told["kinds"]["one"] == {"points": 0.5, "of": 1}
    assert told["styles"]["use"] == {"points": 0.5, "of": 1}


def test_answers_and_truth_are_files_and_a_wrong_name_is_an_error_with_its_place(tmp_path, capsys) -> None:
    truth, answers = tmp_path / "hidden.json", tmp_path / "ours.json"
    about = {"hidden": ["adhesion"], "visible": ["adhesion"], "kind": "one", "style": "use", "exponent": 2.0}
    hidden = {"001": about, "002": about}
    truth.write_text(json.dumps({"seed": 1, "effects": ["adhesion"], "recordings": hidden}))

    def scored(told: object, *options: str) -> int:
        answers.write_text(told if isinstance(told, str) else json.dumps(told))
        return main(["trial", "--score", str(answers), "--truth", str(truth), "--json", *options])

    right = {"001": {"verdict": "named", "named": ["adhesion"], "exponent": 1.9}}
    for options, share in ((), 0.5), (("-n", "1"), 1.0):
        assert scored(right, *options) == 0
        (told,) = json.loads(capsys.readouterr().out).values()
        assert told["score"] == share
    assert told["bias"] == pytest.approx(0.1)
    rivals = ["adhesion", "zero_jump", "friction_trend"]  # no effects, but may stand beside one
    assert scored({"001": {"verdict": "ambiguous", "sets": [rivals]}}) == 0
    (told,) = json.loads(capsys.readouterr().out).values()
    assert told["score"] == pytest.approx(0.5 / 3.0)
    for wrong, said in (
        ({"001": {"verdict": "named", "named": ["adhesoin"]}}, "did you mean adhesion?"),
        ({"001": {"verdict": "named", "named": ["zero_jump"]}}, "no effect is called 'zero_jump'"),
        ({"001": {"verdict": "certain"}}, "001"),
        ({"1": {"verdict": "adequate"}}, "there is no recording '1'"),
        ({"001": "adequate"}, "must be an object"),
        ({"001": {"named": ["adhesion"]}}, "'verdict' is missing"),
        ([], "one JSON object"),
        ("{", "is no JSON"),
    ):
        assert scored(wrong) == 3
        assert said in capsys.readouterr().err


def test_a_truth_is_not_given_away_with_the_recordings(tmp_path, capsys) -> None:
    assert main(["trial", str(tmp_path), "--truth", str(tmp_path / "hidden.json")]) == 2
    assert "given away" in capsys.readouterr().err
    assert main(["trial", "--truth", str(tmp_path / "hidden.json")]) == 2
    assert main(["trial", "--score", "absent.json", "--truth", str(tmp_path / "hidden.json")]) == 3
