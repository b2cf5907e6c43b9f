"""How slip is felt: measured from a log or a calibration, written into a map or a launch file."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import can
import cantools.database
import numpy as np
import pytest

from vegrip.cli import main
from vegrip.cli._written_settings import write_settings
from vegrip.errors import InputError
from vegrip.grip.friction_settings import COARSEST_CREEP
from vegrip.identification.calibration.session import Calibration, judge, load, save, usual_limits
from vegrip.identification.calibration.trials import practice_tip, practise
from vegrip.identification.experiment.design_space import RigLimits
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.mapped.price import settings

LAUNCH = Path(__file__).parents[2] / "launch"
BRACES = '[[node]]\nprogram = "grasp_force"\nparameters = { thumb = "thumb" }\n'
LEARNED = {"learning": True, "slip_threshold": 1.5e-4, "slip_delay": 0.02}
DBC = """VERSION ""
BU_: Hand PC
BO_ 5 Tip: 8 Hand
 SG_ Fz : 0|16@1- (0.005,0) [0|0] "N" PC
 SG_ Fx : 16|16@1- (0.005,0) [0|0] "N" PC
 SG_ Fy : 32|16@1- (0.005,0) [0|0] "N" PC
 SG_ Slip : 48|8@1+ (1,0) [0|255] "" PC
 SG_ SlipSpeed : 56|8@1- (0.02,0) [0|0] "mm/s" PC
"""


def log(dbc, delay=0.03):
    """Write a log at 200 Hz: a rest, a press, then slides of 0.1 mm/s under a growing load, felt late."""
    Path("own.dbc").write_text(dbc)
    message = cantools.database.load_string(dbc, "dbc").get_message_by_name("Tip")
    names = [signal.name for signal in message.signals]
    rng = np.random.default_rng(2)
    with can.CanutilsLogWriter("own.log", channel="own") as written:
        for i in range(2400):
            t = i / 200
            phase = (t - 4.0) % 1.6 if t > 4.0 else 0.0
            felt = 0.9 + delay <= phase < 1.1 + delay
            slides = 0.9 <= phase < 1.1
            load = 1.4 * np.interp(phase, [0.1, 0.9], [0.0, 1.0]) * (0.8 if slides else 1.0) * (phase < 1.1)
            force = 2.0 * np.interp(t, [1.5, 3.0], [0.0, 1.0])
            values = {
                "Fz": force + rng.normal(0.0, 0.01),
                "Fx": load + rng.normal(0.0, 0.01),
                "Fy": rng.normal(0.0, 0.01),
                "Slip": 40 * felt + int(rng.integers(0, 2)),
                "SlipSpeed": 0.1 * felt,
            }
            data = message.encode({name: values[name] for name in names}, strict=False)
            written.on_message_received(
                can.Message(timestamp=t, arbitration_id=5, data=data, is_extended_id=False)
            )


def connected(capsys, *options):
    windows = ["--rest", "0..1.4", "--press", "1.5..3.5"]
    assert main(["connect", "own.dbc", "--log", "own.log", *windows, "-o", "h.toml", "--json", *options]) == 0
    return tomllib.loads(Path("h.toml").read_text()), json.loads(capsys.readouterr().out)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_log_with_slides_tells_how_slip_is_felt_and_switches_learning_on(capsys):
    log(DBC)
    hand, told = connected(capsys)
    friction = hand["friction"]
    assert friction["slip_delay"] == pytest.approx(0.03, abs=0.006)
    assert friction["slip_threshold"] == pytest.approx(1e-4, rel=0.01)
    assert friction["learning"] is True
    assert not any("friction is not learned" in line for line in told["open"])
    assert settings(open_plan("h.toml"))["friction"] == friction


def test_a_slip_channel_that_is_a_level_gets_the_level_that_says_slip(capsys):
    log(DBC)
    hand, _ = connected(capsys)
    assert 1.0 < hand["fingers"]["thumb"]["slip"]["above"] < 20.0


def test_without_a_slip_speed_the_threshold_is_asked_for_and_a_stated_one_is_taken(capsys):
    log(DBC.replace(' SG_ SlipSpeed : 56|8@1- (0.02,0) [0|0] "mm/s" PC\n', ""))
    hand, told = connected(capsys)
    assert "friction" not in hand
    (open_,) = [line for line in told["open"] if "friction is not learned" in line]
    assert "no slip speed is measured" in open_
    assert "--set friction.slip_threshold=1e-4" in open_
    hand, _ = connected(capsys, "--force", "--set", "friction.slip_threshold=1e-4")
    assert hand["friction"]["slip_threshold"] == 1e-4
    assert hand["friction"]["slip_delay"] == pytest.approx(0.03, abs=0.006)


@pytest.mark.parametrize("name", ["can0.toml", "demo.toml"])
def test_a_launch_file_gets_what_was_measured_and_keeps_every_other_line(folder, name):
    text = (LAUNCH / name).read_text()
    (folder / name).write_text(text)
    for figures in ({**LEARNED, "slip_delay": 0.5}, LEARNED):  # the second replaces the first
        write_settings(folder / name, "friction", figures, "measured")
    changed = (folder / name).read_text()
    before, after = tomllib.loads(text), tomllib.loads(changed)
    (grasp,) = [one for one in after["node"] if one["program"] == "grasp_force"]
    assert grasp["parameters"].pop("friction") == LEARNED
    (grasp_before,) = [one for one in before["node"] if one["program"] == "grasp_force"]
    grasp_before.setdefault("parameters", {}).pop("friction", None)
    assert after == before
    assert set(text.split("\n")) - set(changed.split("\n")) <= {
        line for line in text.split("\n") if "friction.learning" in line
    }


def test_a_map_gets_what_was_measured(capsys):
    log(DBC)
    connected(capsys)
    write_settings(Path("h.toml"), "friction", LEARNED, "measured")
    assert tomllib.loads(Path("h.toml").read_text())["friction"] == LEARNED


@pytest.mark.parametrize("text", ['[[node]]\nprogram = "record"\n', BRACES])
def test_a_launch_file_that_cannot_be_added_to_is_refused_with_the_lines_to_write(folder, text):
    (folder / "x.toml").write_text(text)
    with pytest.raises(InputError, match=r"parameters\.friction\.slip_delay = 0\.02"):
        write_settings(folder / "x.toml", "friction", LEARNED, "measured")
    assert (folder / "x.toml").read_text() == text


def test_launch_belongs_to_the_end(folder, capsys):
    (folder / "x.toml").write_text(BRACES)
    assert main(["calibrate", "tip", "--radius", "9 mm", "--no-ask", "--launch", "x.toml"]) == 2
    assert "--launch belongs to the end of a calibration; add --end" in capsys.readouterr().err


@pytest.mark.long
def test_the_slides_of_a_calibration_tell_how_slip_is_felt(folder):
    tip = practice_tip(14)
    calibration = Calibration(folder / "tip", tip.radius, usual_limits(RigLimits(), tip.radius))
    save(calibration)
    while calibration.asked.get("kind") != "slide":
        trial = judge(calibration).next.trial
        recording = practise(trial, tip, 2)
        columns = {name: values for name, values in recording.columns.items() if name != "slip_speed"}
        calibration.take(replace(recording, columns=columns))
    save(calibration)
    found = load(calibration.folder).slip_channel()  # the speeds are kept with the trials
    assert found.lacking == ""
    speeds = calibration.trials[-1].speeds
    assert min(speed for speed in speeds if speed > 0.0) < COARSEST_CREEP  # fine enough to probe by
    assert found.threshold == min(speed for speed in speeds if speed > 0.0)
    assert found.delay < 0.03
