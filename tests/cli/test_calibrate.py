"""``vegrip calibrate`` without a terminal: one step a call, and every mistake one sentence."""

import io
import json
import sys

import pytest

from tests.identification.reach import greatest_depth
from vegrip.cli import main
from vegrip.identification.calibration.trials import Trial, practice_tip, practise
from vegrip.identification.recording import write_recording
from vegrip.identification.simulate import read_protocol

RADIUS = f"{1e3 * practice_tip(4).radius} mm"


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.long
def test_a_step_a_call_leads_from_the_first_press_to_the_next_trial(tmp_path, capsys):
    assert main(["calibrate", "tip", "--radius", RADIUS, "--normal-force", "4", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["next"]["kind"] == "press"
    assert told["trials"] == []
    motion = read_protocol(tmp_path / told["motion"])
    write_recording(practise(Trial("press", motion, ()), practice_tip(4)), tmp_path / "pressed")
    assert main(["calibrate", "tip", "--take", "pressed", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [(one["kind"], one["good"]) for one in told["trials"]] == [("press", True)]
    K = told["parameters"]["K"]
    assert K["known"]
    assert K["goal"] == pytest.approx(0.03 * K["value"])  # in newtons, as its std
    assert not told["parameters"]["mu"]["known"]
    assert told["next"]["kind"] == "hold"
    assert "mu" in told["why"]
    assert main(["calibrate", "tip"]) == 0
    shown = capsys.readouterr().out
    assert "not yet known" in shown
    assert "then: vegrip calibrate tip --take RECORDING" in shown
    assert main(["calibrate", "tip", "--drop", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["next"]["kind"] == "press"


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        ([], 2, "state the radius"),
        (["--radius", "soft"], 3, "give a length like '8 mm'"),
        (["--radius", "9 mm", "--take", "nothing"], 3, "there is no such folder"),
        (["--radius", "9 mm", "--drop", "3"], 2, "there is no trial 3"),
        (["--radius", "9 mm", "--end"], 2, "nothing was recorded yet"),
        (["--radius", "9 mm", "--node", "nobody"], 2, "there is no node 'nobody'"),
        (["--radius", "9 mm", "--depth", "-1"], 3, "depth"),
        (["--radius", "9 mm", "--virtual", "11"], 2, "fingertip 11 has a radius of 0.005287 m; leave"),
    ],
)
def test_a_mistake_is_one_sentence(runtime, capsys, arguments, code, sentence):
    assert main(["calibrate", "tip", "--json", *arguments]) == code
    said = capsys.readouterr().err
    assert sentence in said
    assert "Traceback" not in said


def test_what_is_no_calibration_is_not_written_into(tmp_path, capsys):
    (tmp_path / "tip").mkdir()
    (tmp_path / "tip" / "mine.txt").write_text("mine")
    assert main(["calibrate", "tip", "--radius", "9 mm", "--json"]) == 3
    assert "is no calibration" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "tip").iterdir()] == ["mine.txt"]


def test_another_radius_is_refused(capsys):
    assert main(["calibrate", "tip", "--radius", "9 mm", "--json"]) == 0
    assert main(["calibrate", "tip", "--radius", "8 mm", "--json"]) == 2
    assert "is the calibration of a fingertip of radius 0.009 m" in capsys.readouterr().err


def test_limits_that_are_given_later_are_those_of_the_next_trial(tmp_path, capsys):
    assert main(["calibrate", "tip", "--radius", "9 mm", "--json"]) == 0
    before = read_protocol(tmp_path / json.loads(capsys.readouterr().out)["motion"])
    assert main(["calibrate", "tip", "--depth", "2e-4", "--json"]) == 0
    after = read_protocol(tmp_path / json.loads(capsys.readouterr().out)["motion"])
    assert greatest_depth(after) < 0.5 * greatest_depth(before)
    assert main(["calibrate", "tip", "--json"]) == 0
    capsys.readouterr()
    assert json.loads((tmp_path / "tip" / "calibration.json").read_text())["limits"]["depth"] == 2e-4


def test_in_a_terminal_a_mistake_is_told_and_asked_again(monkeypatch, capsys):
    answers = io.StringIO("nowhere\ndrop 1\nquit\n")
    answers.isatty = lambda: True
    monkeypatch.setattr(sys, "stdin", answers)
    assert main(["calibrate", "tip", "--radius", "9 mm"]) == 0
    shown = capsys.readouterr().out
    assert "there is no such folder" in shown
    assert "there is no trial 1" in shown
    assert shown.count("the folder of its recording") == 3
