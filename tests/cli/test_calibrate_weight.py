"""``vegrip calibrate --weight``: from any kind of recording, into launch file or map, every mistake said."""

import json
import tomllib
from pathlib import Path

import can
import cantools.database
import pytest

from tests.identification.lifts import Hand, Lift
from vegrip.cli import main
from vegrip.clock import NS
from vegrip.config import build
from vegrip.grip.parameters import GraspParameters
from vegrip.identification.recording import write_recording
from vegrip.identification.recording.session import merge_states
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.runtime.launch_file import read_launch_file
from vegrip.transport.codec import CanCodec

LAUNCH = Path(__file__).parents[2] / "launch"
GAINS = (0.93, 0.93)
EVEN = Lift(0.5, (0.5, 0.5))
ALONE = (Lift(0.5, (1.0, 0.0)), Lift(0.5, (0.0, 1.0)))
DBC = """VERSION ""
BU_: Hand PC
BO_ 5 Thumb: 8 Hand
 SG_ Fz : 0|16@1- (0.005,0) [0|0] "N" PC
 SG_ Fx : 16|16@1- (0.005,0) [0|0] "N" PC
 SG_ Fy : 32|16@1- (0.005,0) [0|0] "N" PC
BO_ 6 Index: 8 Hand
 SG_ Fz : 0|16@1- (0.005,0) [0|0] "N" PC
 SG_ Fx : 16|16@1- (0.005,0) [0|0] "N" PC
 SG_ Fy : 32|16@1- (0.005,0) [0|0] "N" PC
"""
MAP = """database = "own.dbc"
[fingers.thumb]
normal_force = { signal = "Thumb.Fz" }
tangential_force_x = { signal = "Thumb.Fx" }
tangential_force_y = { signal = "Thumb.Fy" }
[fingers.index]
normal_force = { signal = "Index.Fz" }
tangential_force_x = { signal = "Index.Fx" }
tangential_force_y = { signal = "Index.Fy" }
"""


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def recorded(name, *lifts, gains=GAINS, **about):
    """Keep a lift as ``vegrip record`` does: a folder for each finger."""
    fingers = Hand(gains, **about).record(*lifts)
    with RecordingWriter(Path(name), radius=9e-3) as writer:
        for state in merge_states(fingers):
            writer.write(state)
    return fingers


def told(capsys, *arguments):
    assert main(["calibrate", *arguments, "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("weight", ["0.5", "500 g", "0.5kg"])
def test_a_session_tells_the_common_gain(capsys, weight):
    recorded("lift", EVEN)
    found = told(capsys, "lift", "--weight", weight)
    assert found["gain"] == pytest.approx(0.93, rel=0.01)
    assert found["each_finger_known"] is False
    assert found["lifts"] == 1
    assert found["settings"]["tangential_gain_std"] > found["std"]
    assert found["written"] is None


def test_what_it_means_is_said(capsys):
    recorded("lift", EVEN)
    assert main(["calibrate", "lift", "--weight", "0.5"]) == 0
    said = capsys.readouterr().out
    assert "tangential forces read 7 % low: gain 0.9" in said
    assert "the shares do not distinguish the fingers" in said
    assert "the pads face sideways" in said
    assert "to grip by it add --launch FILE: sensors.tangential_gain = 0.9" in said


def test_an_mcap_file_tells_the_same_as_its_session(capsys):
    pytest.importorskip("mcap.reader", reason="the extra `bags` is not installed")
    recorded("lift", EVEN)
    assert main(["import", "lift", "-o", "lift.mcap", "--json"]) == 0
    capsys.readouterr()
    assert told(capsys, "lift.mcap", "--weight", "0.5") == told(capsys, "lift", "--weight", "0.5")


def test_a_can_log_in_our_own_layout_tells_the_gain(capsys):
    fingers = Hand(GAINS).record(EVEN)
    codec = CanCodec(tuple(fingers), fd=True)
    with can.BLFWriter("lift.blf") as log:
        for state in merge_states(fingers):
            for frame in codec.encode(state):
                log.on_message_received(
                    can.Message(
                        timestamp=state.stamp / NS,
                        arbitration_id=frame.arbitration_id,
                        data=frame.data,
                        is_fd=True,
                        is_extended_id=False,
                    )
                )
    assert told(capsys, "lift.blf", "--weight", "0.5")["gain"] == pytest.approx(0.93, rel=0.01)


@pytest.mark.parametrize("hand", ["hand.toml", "launch.toml"])
def test_a_log_of_a_hand_of_another_make_is_read_by_its_map(capsys, hand):
    Path("own.dbc").write_text(DBC)
    Path("hand.toml").write_text(MAP)
    Path("launch.toml").write_text(
        '[transport]\nkind = "can"\nmap = "hand.toml"\n[[node]]\nprogram = "grasp_force"\n'
    )
    database = cantools.database.load_string(DBC, "dbc")
    with can.CanutilsLogWriter("lift.log", channel="own") as log:
        for state in merge_states(Hand(GAINS).record(EVEN)):
            message = database.get_message_by_name(state.finger.capitalize())
            values = (state.normal_force, state.tangential_force_x, state.tangential_force_y)
            data = message.encode(dict(zip(("Fz", "Fx", "Fy"), values, strict=True)))
            identifier = message.frame_id
            log.on_message_received(
                can.Message(
                    timestamp=state.stamp / NS, arbitration_id=identifier, data=data, is_extended_id=False
                )
            )
    assert told(capsys, "lift.log", "--weight", "0.5", "--map", hand)["gain"] == pytest.approx(0.93, rel=0.01)


def test_a_running_node_is_recorded_for_some_seconds(capsys, monkeypatch):
    asked = []

    def record(node, folder, seconds):
        asked.append((node, seconds))
        recorded(folder, EVEN)

    monkeypatch.setattr("vegrip.cli.record.record_from_node", record)
    found = told(capsys, "--weight", "0.5", "--node", "grasp_force", "--seconds", "12")
    assert asked == [("grasp_force", 12.0)]
    assert found["gain"] == pytest.approx(0.93, rel=0.01)
    assert told(capsys, "kept", "--weight", "0.5", "--node", "grasp_force")["gain"] == found["gain"]
    assert told(capsys, "kept", "--weight", "0.5")["gain"] == found["gain"]


@pytest.mark.parametrize("name", ["can0.toml", "demo.toml"])
def test_a_launch_file_gets_the_gain_and_keeps_every_other_line(capsys, name):
    recorded("alone", *ALONE, gains=(0.85, 1.0))
    recorded("even", EVEN, gains=(0.9, 0.9))
    before = tomllib.loads((LAUNCH / name).read_text())
    Path(name).write_text((LAUNCH / name).read_text())
    for lift in ("alone", "even"):  # the second replaces the first
        found = told(capsys, lift, "--weight", "0.5", "--launch", name)
        (grasp,) = [each for each in read_launch_file(Path(name)) if each.program == "grasp_force"]
        sensors = build(GraspParameters, grasp.parameters, name).sensors
        own = {finger: sensors.of(finger) for finger in ("thumb", "index")}
        for finger, each in own.items():
            wanted = found["settings"].get("fingers", {}).get(finger, found["settings"])
            assert (each.tangential_gain, each.tangential_gain_std) == (
                wanted["tangential_gain"],
                wanted["tangential_gain_std"],
            )
        assert (own["thumb"] == own["index"]) is (lift == "even")
    after = tomllib.loads(Path(name).read_text())
    for table in (before, after):
        (grasp,) = [each for each in table["node"] if each["program"] == "grasp_force"]
        grasp.setdefault("parameters", {}).pop("sensors", None)
    assert after == before


def test_a_map_gets_the_gain_and_the_node_that_takes_the_map_has_it(capsys):
    Path("own.dbc").write_text(DBC)
    Path("hand.toml").write_text(MAP + '[transport]\nkind = "can"\nchannel = "own"\n')
    recorded("lift", EVEN)
    found = told(capsys, "lift", "--weight", "0.5", "--launch", "hand.toml")
    (node,) = read_launch_file(Path("hand.toml"))
    assert node.parameters["sensors"] == found["settings"]


def test_two_weights_that_disagree_are_said(capsys):
    recorded("light", Lift(0.25, (0.5, 0.5)), gains=(0.81, 0.81))
    recorded("heavy", Lift(0.75, (0.64, 0.36)), gains=(0.95, 0.95))
    weights = ("--weight", "250 g", "--weight", "750 g")
    found = told(capsys, "light", "heavy", *weights)
    assert found["depends_on_load"] is True
    assert [round(each["gain"], 2) for each in found["weights"]] == [0.81, 0.95]
    assert main(["calibrate", "light", "heavy", *weights]) == 0
    assert "the gain depends on the load: 0.81" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (["lift", "--weight", "0"], 3, "--weight is '0', which is 0 kg; give a mass above 0"),
        (["lift", "--weight=-1"], 3, "--weight is '-1', which is -1 kg; give a mass above 0"),
        (["lift", "--weight", "heavy"], 3, "--weight is 'heavy'; give a mass like '500 g'"),
        (["lift", "--weight", "nan"], 3, "--weight is 'nan'; give a mass like '500 g'"),
        (["lift", "--weight", "5 N"], 3, "'N' is not a unit of this quantity; it needs one like kg"),
        (["lift", "--weight", "500"], 3, "which is 500 kg; give a mass above 0 and up to 100 kg"),
        (["lift", "--weight", "5"], 3, "no weight of 5 kg was lifted"),
        (["lift", "--weight", "0.2"], 3, "and a gain lies in 0.5 .. 2"),
        (["lift/index", "--weight", "0.5"], 3, "index: holds index alone"),
        (["nothing", "--weight", "0.5"], 3, "nothing: there is no such recording"),
        (["note.txt", "--weight", "0.5"], 3, "is no folder of fingers, MCAP file or CAN log"),
        (["--weight", "0.5"], 2, "name the recording of the lift, or a running node"),
        (["lift", "--weight", "0.5", "--weight", "1"], 2, "give one --weight, or one for each"),
        (["lift", "--weight", "0.5", "--end"], 2, "--end does not go with --weight"),
        (
            ["lift", "--weight", "0.5", "--launch", "none.toml"],
            3,
            "none.toml cannot be read as",
        ),
        (["lift", "--map", "hand.toml"], 2, "--map belongs to --weight"),
        (["--weight", "0.5", "--node", "nobody"], 2, "there is no node 'nobody'"),
        ([], 2, "name the folder of the calibration"),
    ],
)
def test_a_mistake_is_one_sentence(runtime, capsys, arguments, code, sentence):
    recorded("lift", EVEN)
    Path("note.txt").write_text("a note")
    assert main(["calibrate", *arguments, "--json"]) == code
    said = capsys.readouterr()
    assert sentence in said.err
    assert "Traceback" not in said.err
    assert said.out == ""


def test_a_recording_without_tangential_forces_is_refused(capsys):
    for name, each in Hand(GAINS).record(EVEN).items():
        columns = {"normal_force": each.columns["normal_force"]}
        write_recording(type(each)(name, each.t, each.episode, columns, each.fingertip), Path("lift") / name)
    assert main(["calibrate", "lift", "--weight", "0.5"]) == 3
    assert "index has no tangential_force_x and no tangential_force_y" in capsys.readouterr().err
