"""From a database and a log nobody has seen to a map that runs, without code and without a terminal."""

import json
import math
import tomllib

import pytest

from tools.make_samples import foreign_motion
from vegrip.cli import main
from vegrip.identification.samples import FOREIGN_DATABASE, FOREIGN_LOG, SAMPLES

WINDOWS = ["--rest", "0..2", "--press", "2..5", "--shear", "5..8", "--twist", "8..10"]


@pytest.fixture
def gripper(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in (FOREIGN_DATABASE, FOREIGN_LOG):
        SAMPLES[name].write(tmp_path / name)
    return tmp_path


def connect(*arguments):
    return main(["connect", FOREIGN_DATABASE, "-o", "hand.toml", *arguments])


def test_a_gripper_with_odd_units_signs_and_pages_is_mapped_by_its_log_and_four_windows(gripper, capsys):
    assert connect("--log", FOREIGN_LOG, *WINDOWS, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["implausible"] == []
    hand = tomllib.loads((gripper / "hand.toml").read_text())
    left = hand["fingers"]["left"]
    assert {c: left[c]["signal"] for c in ("normal_force", "tangential_force_x", "tangential_force_y")} == {
        "normal_force": "TIP_L.LoadA",
        "tangential_force_x": "TIP_L.LoadC",
        "tangential_force_y": "TIP_L.LoadB",
    }
    assert (left["normal_force"]["sign"], left["displacement"]["sign"]) == (-1, -1)
    assert "sign" not in left["tangential_force_x"]
    assert left["normal_force"]["zero"] == pytest.approx(30.0, abs=0.3)
    assert left["normal_force"]["noise"] == pytest.approx(0.02, rel=0.2)
    assert abs(left["displacement"].get("zero", 0.0)) < 0.1  # [mm] of 1.2
    assert hand["rate"] == pytest.approx(100.0, rel=0.01)
    crc = {"kind": "crc8", "signal": "Check", "polynomial": 0x31, "start": 0xFF}
    assert [hand["messages"][name]["checksum"] for name in ("TIP_L", "TIP_R", "SET_GRIP")] == [crc] * 3
    right = hand["fingers"]["right"]  # never touched: as its sibling
    assert (right["normal_force"]["signal"], right["normal_force"]["sign"]) == ("TIP_R.LoadA", -1)
    assert right["command"] == {
        "signal": "SET_GRIP.Effort_R",
        "kind": "force",
        "unit": "gf",
        "set": {"Enable": 1},
    }


def test_what_the_map_makes_of_the_log_is_what_the_fingertip_did(gripper, capsys):
    connect("--log", FOREIGN_LOG, *WINDOWS)
    capsys.readouterr()
    assert main(["connect", "hand.toml", "--log", FOREIGN_LOG, "--json"]) == 0
    values = json.loads(capsys.readouterr().out)["values"]["left"]
    motion = foreign_motion()
    steps = {"normal_force": 0.02, "tangential_force_x": 0.02, "tangential_force_y": 0.02, "torque_z": 2e-4}
    for channel, step in steps.items():
        least, last, largest = values[channel]
        true = motion[channel]
        assert least == pytest.approx(float(true.min()), abs=step), channel
        assert largest == pytest.approx(float(true.max()), abs=step), channel
        assert last == pytest.approx(float(true[-1]), abs=step), channel
    assert values["rate"] == pytest.approx(100.0, rel=0.01)


def test_the_map_launches_as_it_is(gripper, capsys):
    assert connect("--log", FOREIGN_LOG, *WINDOWS, "--channel", "can0") == 0
    assert "next: vegrip launch hand" in capsys.readouterr().out
    assert main(["launch", "hand", "--check"]) == 0
    assert "grasp_force" in capsys.readouterr().out


def test_without_windows_the_log_alone_gives_signs_and_noise(gripper):
    assert connect("--log", FOREIGN_LOG, "--set", "fingers.left.normal_force.signal=TIP_L.LoadA") == 0
    hand = tomllib.loads((gripper / "hand.toml").read_text())
    assert hand["fingers"]["left"]["displacement"]["signal"] == "TIP_L.Stroke"
    assert hand["messages"]["TIP_L"]["counter"] == "AliveCtr"


def test_without_traffic_the_names_alone_give_a_map_and_the_open_questions(gripper, capsys):
    assert connect() == 0
    assert "looks like a checksum of a kind that is not known without traffic" in capsys.readouterr().out
    assert tomllib.loads((gripper / "hand.toml").read_text())["fingers"]["left"]


def test_what_was_said_of_a_checksum_is_open_no_more(gripper, capsys):
    asked = 'messages.TIP_L.checksum={ kind = "sum", signal = "Check" }'
    assert connect("--set", asked) == 0
    assert "TIP_L.Check" not in capsys.readouterr().out
    hand = tomllib.loads((gripper / "hand.toml").read_text())
    assert hand["messages"]["TIP_L"]["checksum"] == {"kind": "sum", "signal": "Check"}


def test_forces_of_no_known_direction_are_sent_to_the_windows_that_show_it(gripper, capsys):
    assert connect("--log", FOREIGN_LOG) == 0
    shown = capsys.readouterr().out
    assert "no name says the direction of these forces: TIP_L.Load" in shown
    assert connect("--log", FOREIGN_LOG, *WINDOWS, "--force") == 0
    assert "no name says the direction" not in capsys.readouterr().out


def test_every_key_can_be_said_by_an_option(gripper):
    said = ["--set", "fingers.left.normal_force.sign=-1", "--set", 'command.silence="holds"']
    said += ["--set", 'fingers.right.tangential_force_x={ stated = "1.5 N" }', "--set", "rate=50"]
    assert connect(*said) == 0
    hand = tomllib.loads((gripper / "hand.toml").read_text())
    assert hand["fingers"]["left"]["normal_force"]["sign"] == -1
    assert hand["command"]["silence"] == "holds"
    assert hand["fingers"]["right"]["tangential_force_x"] == {"stated": "1.5 N"}
    assert hand["rate"] == 50


BAD = {
    "no database": (["connect", "none.dbc"], 3, "there is no such file"),
    "not a database": (["connect", "bad.dbc"], 3, "bad.dbc: cannot be read as a CAN database"),
    "nothing of a fingertip": (["connect", "car.dbc"], 3, "no signal looks like the force or position"),
    "another hand's log": (
        ["connect", "car.dbc", "--log", FOREIGN_LOG],
        3,
        "no message of car.dbc came, but",
    ),
    "not a log": (["connect", FOREIGN_DATABASE, "--log", "bad.asc"], 3, "bad.asc"),
    "a window that is none": (
        ["connect", FOREIGN_DATABASE, "--press", "5..2"],
        2,
        "--press is '5..2'; give two times",
    ),
    "a setting that is none": (["connect", FOREIGN_DATABASE, "--set", "sign"], 2, "write KEY=VALUE"),
    "a setting of nothing": (
        ["connect", FOREIGN_DATABASE, "--set", "fingers.left.normal_force.sing=1"],
        3,
        "unknown key",
    ),
    "a file that is there": (["connect", FOREIGN_DATABASE, "-o", "bad.dbc"], 3, "is there already"),
    "a channel that is not there": (
        ["connect", FOREIGN_DATABASE, "--channel", "can97"],
        4,
        "cannot be opened",
    ),
    "no press in the window": (
        ["connect", FOREIGN_DATABASE, "--log", FOREIGN_LOG, "--rest", "0..1", "--press", "1..2"],
        3,
        "no finger answers to the press",
    ),
    "a unit that cannot be": (
        ["connect", "newton.dbc", "--log", FOREIGN_LOG, *WINDOWS],
        3,
        "which no soft fingertip has",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_gets_one_sentence_and_an_exit_code(gripper, capsys, name):
    arguments, code, said = BAD[name]
    (gripper / "bad.dbc").write_text("hello")
    (gripper / "bad.asc").write_bytes(b"\x00\xff\x00")
    (gripper / "car.dbc").write_text(
        'VERSION ""\nBU_: A\nBO_ 1 ENGINE: 8 A\n SG_ Rpm : 0|16@1+ (1,0) [0|0] "rpm" A\n'
    )
    (gripper / "newton.dbc").write_text((gripper / FOREIGN_DATABASE).read_text().replace('"mm"', '"um"'))
    assert main(arguments) == code
    error = capsys.readouterr().err
    assert said in " ".join(error.split())
    assert "Traceback" not in error


def test_a_map_that_says_the_wrong_sign_is_told_by_its_values(gripper, capsys):
    connect("--log", FOREIGN_LOG, *WINDOWS, "--set", "fingers.left.displacement.sign=1")
    capsys.readouterr()
    assert main(["connect", "hand.toml", "--log", FOREIGN_LOG]) == 3
    assert "indentation falls while the normal force grows" in " ".join(capsys.readouterr().err.split())


def test_a_value_that_was_never_measured_is_left_out_of_the_json(gripper, capsys):
    connect("--log", FOREIGN_LOG, *WINDOWS, "--json")
    values = json.loads(capsys.readouterr().out)["values"]["left"]
    assert "slip" not in values
    assert not any(math.isnan(v) for key in values if key != "rate" for v in values[key])


@pytest.mark.usefixtures("runtime")
def test_a_bus_on_which_nothing_comes_is_told_before_anything_is_written(gripper, capsys):
    live = ["--channel", "silent", "--interface", "virtual", "--seconds", "0.2"]
    assert connect(*live) == 3
    assert "no frame came; look at channel and bit rate" in " ".join(capsys.readouterr().err.split())
    assert not (gripper / "hand.toml").exists()
