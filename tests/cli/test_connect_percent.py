"""A hand that speaks percent, counts and inches, on pages of big-endian frames: mapped by options alone."""

import json
import shlex
import tomllib

import cantools.database
import numpy as np
import pytest

from vegrip.cli import main
from vegrip.model import paper_model

DBC = """VERSION ""
NS_ :
BS_:
BU_: KRN HOST
BO_ 2566803489 FINGER_FB: 8 KRN
 SG_ FingerIdx M : 3|4@0+ (1,0) [0|15] "" HOST
 SG_ RollCnt : 7|4@0+ (1,0) [0|15] "" HOST
 SG_ F1_Load m1 : 15|12@0+ (0.1,-20) [-20|389.5] "%" HOST
 SG_ F1_ShearU m1 : 19|10@0- (1,0) [-512|511] "cnt" HOST
 SG_ F1_ShearV m1 : 25|10@0- (1,0) [-512|511] "cnt" HOST
 SG_ F2_Load m2 : 15|12@0+ (0.1,-20) [-20|389.5] "%" HOST
 SG_ F2_ShearU m2 : 19|10@0- (1,0) [-512|511] "cnt" HOST
 SG_ F2_ShearV m2 : 25|10@0- (1,0) [-512|511] "cnt" HOST
 SG_ Chk : 63|8@0+ (1,0) [0|255] "" HOST
BO_ 2566803490 MOTOR_FB: 8 KRN
 SG_ Axis M : 7|8@0+ (1,0) [0|3] "" HOST
 SG_ M1_Travel m1 : 15|16@0- (0.0005,0) [-16|16] "in" HOST
 SG_ M1_Temp m1 : 47|8@0+ (1,-40) [-40|215] "degF" HOST
 SG_ M2_Travel m2 : 15|16@0- (0.0005,0) [-16|16] "in" HOST
 SG_ M2_Temp m2 : 47|8@0+ (1,-40) [-40|215] "degF" HOST
 SG_ TurnCnt : 55|4@0+ (1,0) [0|14] "" HOST
BO_ 2566803521 GRIP_CMD: 8 HOST
 SG_ F1_Set : 7|16@0+ (0.1,0) [0|100] "%" KRN
 SG_ F2_Set : 23|16@0+ (0.1,0) [0|100] "%" KRN
"""
RATED = 25.0  # [N] that are 100 %
COUNT = 0.02  # [N] of a count of shear
INCH = 25.4e-3  # [m]
GAINS = [
    *("--set", "fingers.*.normal_force.gain=0.25 N/%"),
    *("--set", "fingers.*.tangential_force_x.gain=0.02 N/cnt"),
    *("--set", "fingers.*.tangential_force_y.gain=0.02 N/cnt"),
    *("--set", "fingers.*.command.gain=4 %/N"),
]
WINDOWS = ["--rest", "0..1", "--press", "1..4", "--shear", "4..8"]


def motion():
    """Finger 1 rests, is pressed, is pulled along its +x and then along its y; finger 2 is not touched."""
    t = np.arange(0.0, 8.0, 0.004)
    depth = np.interp(
        t, [0, 1.2, 2.0, 3.2, 3.6, 4.0, 4.6, 7.6, 7.9], 1e-4 * np.array([-4, -4, 16, 16, -4, -4, 16, 16, -4])
    )
    force = 3.0 * paper_model(7e-3).simulate(t, depth).normal_force
    x = force * np.interp(t, [4.8, 5.3, 6.0, 6.3], [0.0, 0.4, 0.4, 0.0])
    y = force * np.interp(t, [6.4, 6.8, 7.2, 7.5], [0.0, 0.2, 0.2, 0.0])
    return t, depth, force, x, y


def frames():
    """Yield time, identifier and data; both pages of a cycle bear the same count."""
    database = cantools.database.load_string(DBC, "dbc")
    loads, motor = (database.get_message_by_name(name) for name in ("FINGER_FB", "MOTOR_FB"))
    rng = np.random.default_rng(7)
    turn = 0
    for i, row in enumerate(zip(*motion(), strict=True)):
        for finger, zero in ((1, 3.4), (2, -1.2)):
            t, depth, force, x, y = row if finger == 1 else (row[0], -4e-4, 0.0, 0.0, 0.0)
            values = {
                f"F{finger}_Load": zero + 100.0 * force / RATED + rng.normal(0.0, 0.15),
                f"F{finger}_ShearU": round(4 - x / COUNT + rng.normal(0.0, 1.2)),
                f"F{finger}_ShearV": round(-7 + y / COUNT + rng.normal(0.0, 1.2)),
            }
            data = bytearray(
                loads.encode({"FingerIdx": finger, "RollCnt": i % 16, "Chk": 0, **values}, strict=False)
            )
            data[7] = ~sum(data[:7]) & 0xFF
            yield t + 2e-4 * finger, loads.frame_id, bytes(data)
            if i % 5 == 0:
                travel = {
                    f"M{finger}_Travel": 2.2 - depth / INCH,
                    f"M{finger}_Temp": 88,
                    "TurnCnt": turn % 15,
                }
                turn += 1
                yield (
                    t + 1e-3 + 1e-4 * finger,
                    motor.frame_id,
                    motor.encode({"Axis": finger, **travel}, strict=False),
                )


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("traffic") / "drive.log"
    lines = [
        f"({1.7e9 + t:.6f}) can0 {identifier:08X}#{data.hex().upper()}" for t, identifier, data in frames()
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "krn.dbc").write_text(DBC)
    return tmp_path


def connect(log, *options):
    return main(["connect", "krn.dbc", "-o", "hand.toml", "--log", str(log), *options])


def test_units_that_tell_no_newtons_are_asked_for_in_one_sentence_with_every_option(log, folder, capsys):
    assert connect(log) == 3
    said = " ".join(capsys.readouterr().err.split())
    assert "the units do not say how many newtons one is, so nothing is written" in said
    for option in ("normal_force.gain=0.25 N/%", "tangential_force_x.gain=0.25 N/cnt", "command.gain=4 %/N"):
        assert f"--set 'fingers.*.{option}'" in said
    assert not (folder / "hand.toml").exists()


def test_what_only_the_shear_needs_is_left_out_and_told(log, folder, capsys):
    assert connect(log, *WINDOWS, *GAINS[:2], "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert any(
        "FINGER_FB.F1_ShearU [cnt] for tangential_force_x is left out" in each for each in told["open"]
    )
    assert any("GRIP_CMD.F1_Set [%], which takes the command, is left out" in each for each in told["open"])
    assert "tangential_force_x" not in tomllib.loads((folder / "hand.toml").read_text())["fingers"]["thumb"]


def test_the_map_reads_what_the_hand_did(log, folder, capsys):
    assert connect(log, *WINDOWS, *GAINS, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["implausible"] == []
    hand = tomllib.loads((folder / "hand.toml").read_text())
    thumb = hand["fingers"]["thumb"]
    assert thumb["trigger"] == "FINGER_FB.F1_Load"  # other pages are of the other finger
    assert thumb["normal_force"]["noise"] == pytest.approx(0.15 / 100.0 * RATED, rel=0.2)
    assert (thumb["tangential_force_x"]["signal"], thumb["tangential_force_x"]["sign"]) == (
        "FINGER_FB.F1_ShearU",
        -1,
    )
    assert thumb["tangential_force_y"]["signal"] == "FINGER_FB.F1_ShearV"
    _, depth, force, x, _ = motion()
    values = told["values"]["thumb"]
    assert values["rate"] == pytest.approx(250.0, rel=0.01)
    assert told["values"]["index"]["rate"] == pytest.approx(250.0, rel=0.01)
    assert values["normal_force"][2] == pytest.approx(force.max(), abs=0.2)
    assert values["tangential_force_x"][2] == pytest.approx(x.max(), abs=0.15)
    assert np.ptp(values["displacement"]) == pytest.approx(np.ptp(depth), abs=2e-5)
    assert values["displacement"][2] == pytest.approx(depth.max(), rel=0.15)
    assert values["temperature"][1] == pytest.approx((88 - 32) / 1.8, abs=0.01)


def test_a_count_of_several_pages_is_no_counter_and_one_that_ends_early_has_its_modulus(log, folder, capsys):
    assert connect(log, *WINDOWS, *GAINS, "--json") == 0
    assert any(
        "FINGER_FB.RollCnt does not go up by one" in each
        for each in json.loads(capsys.readouterr().out)["open"]
    )
    messages = tomllib.loads((folder / "hand.toml").read_text())["messages"]
    assert "counter" not in messages["FINGER_FB"]
    assert messages["MOTOR_FB"] == {"counter": "TurnCnt", "modulus": 15}
    assert messages["FINGER_FB"]["checksum"] == {"signal": "Chk", "kind": "sum", "final": 255}


def test_the_noise_of_a_held_value_covers_what_it_is_late_by(log, folder):
    assert connect(log, *WINDOWS, *GAINS) == 0
    noise = tomllib.loads((folder / "hand.toml").read_text())["fingers"]["thumb"]["displacement"]["noise"]
    t, depth, *_ = motion()
    pressing = (t >= 1.0) & (t <= 4.0)
    held = depth[(np.arange(t.size) // 5) * 5]  # of every fifth sample
    late = float(np.sqrt(np.mean((depth - held)[pressing] ** 2)))
    assert noise > np.sqrt(5.0) * late
    assert noise < 3.0 * np.sqrt(5.0) * np.hypot(late, 0.0005 * INCH / np.sqrt(12.0))


@pytest.mark.parametrize("step", ["0.0005", "-0.0005"])  # in the air it says -56 mm, or 56 mm
def test_a_finger_that_was_not_pressed_has_no_zero_of_its_indentation_and_that_is_told(
    log, folder, capsys, step
):
    (folder / "krn.dbc").write_text(
        DBC.replace("M2_Travel m2 : 15|16@0- (0.0005", f"M2_Travel m2 : 15|16@0- ({step}")
    )
    connect(log, *WINDOWS, *GAINS, "--json")
    said = json.loads(capsys.readouterr().out)["open"]
    (told,) = [each for each in said if "index was not pressed from the air" in each]
    is_left_out = step.startswith("-")
    assert ("left out: in the air it says 5" in told) == is_left_out
    index = tomllib.loads((folder / "hand.toml").read_text())["fingers"]["index"]
    assert ("displacement" in index) != is_left_out


def test_what_is_said_stands_against_what_is_found(log, folder):
    said = ["--set", "fingers.thumb.normal_force.noise=0.5", "--set", "fingers.thumb.displacement.zero=2.2"]
    said += ["--set", 'fingers.thumb.tangential_force_x.signal="FINGER_FB.F1_ShearV"']
    connect(log, *WINDOWS, *said, *GAINS)
    thumb = tomllib.loads((folder / "hand.toml").read_text())["fingers"]["thumb"]
    assert thumb["normal_force"]["noise"] == 0.5
    assert thumb["displacement"]["zero"] == 2.2
    assert thumb["tangential_force_x"]["signal"] == "FINGER_FB.F1_ShearV"
    assert thumb["tangential_force_x"]["zero"] == pytest.approx(-7.0, abs=0.5)  # its own, not the other's
    assert thumb["tangential_force_y"]["signal"] == "FINGER_FB.F1_ShearU"


def test_the_remedy_for_names_that_tell_nothing_works(log, folder, capsys):
    for name in ("Load", "ShearU", "ShearV", "Travel", "Temp"):
        text = (folder / "krn.dbc").read_text()
        (folder / "krn.dbc").write_text(
            text.replace(f"_{name} ", f"_{name[0]}q{name[-1]} ").replace('"in"', '""')
        )
    (folder / "krn.dbc").write_text(
        (folder / "krn.dbc").read_text().replace('"degF"', '""').replace('"cnt"', '""')
    )
    assert connect(log) == 3
    assert "--set fingers.thumb.normal_force.signal=MESSAGE.SIGNAL" in " ".join(
        capsys.readouterr().err.split()
    )
    said = ["--set", "fingers.thumb.normal_force.signal=FINGER_FB.F1_Lqd"]
    assert connect(log, *said, "--set", "fingers.thumb.normal_force.gain=0.25 N/%") == 0
    thumb = tomllib.loads((folder / "hand.toml").read_text())["fingers"]["thumb"]
    assert thumb["normal_force"]["zero"] == pytest.approx(3.4, abs=0.05)


BAD = {
    "a window after the end": ([*GAINS, "--press", "100..110"], "--press 100..110 lies after the end"),
    "a gain of another quantity": (["--set", "fingers.*.normal_force.gain=0.25 N/A"], "'gain'"),
    "a gain without a number": (["--set", "fingers.*.normal_force.gain=abc"], "must be a number and a unit"),
    "a signal that is not there": (
        [*GAINS, "--set", "fingers.thumb.normal_force.signal=FINGER_FB.F9"],
        "FINGER_FB has no signal 'F9'",
    ),
    "two fingers on one signal": (
        [*GAINS, "--set", "fingers.index.normal_force.signal=FINGER_FB.F1_Load"],
        "FINGER_FB.F1_Load is already the normal_force of thumb",
    ),
    "a place that cannot be written": (
        [*GAINS, "-o", "/proc/hand.toml"],
        "/proc: cannot be written",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_gets_one_sentence(log, folder, capsys, name):
    options, sentence = BAD[name]
    assert connect(log, *options) == 3
    said = " ".join(capsys.readouterr().err.split())
    assert sentence in said
    assert "Traceback" not in said
    assert not (folder / "hand.toml").exists()


def test_frames_that_are_too_short_are_told_with_the_remedy(log, folder, capsys):
    for left_out, code in ((2, 0), (6, 3)):  # the last byte holds no signal
        lines = log.read_text().splitlines()
        short = [line[:-left_out] if " 18FE5022#" in line else line for line in lines]
        (folder / "short.log").write_text("\n".join(short) + "\n")
        assert connect(folder / "short.log", *GAINS, "--force") == code
        said = " ".join(capsys.readouterr().err.split())
        told = "800 frames of MOTOR_FB are shorter than the 8 bytes that krn.dbc says; missing from them"
        assert (told in said) == (code == 3)


@pytest.mark.parametrize(
    ("names", "sentence"),
    [
        ("a,b,c", "c: no name, letter or number shows a further finger"),
        ("a", "the hand has 2 fingers and 1 names"),
    ],
)
def test_names_and_fingers_that_are_left_over_are_told(log, capsys, names, sentence):
    connect(log, *GAINS, "--fingers", names, "--json")
    assert any(sentence in each for each in json.loads(capsys.readouterr().out)["open"])


def test_the_option_for_a_current_as_a_poor_force_works_as_it_is_told(log, folder, capsys):
    text = (
        (folder / "krn.dbc")
        .read_text()
        .replace("_Load ", "_Lqd ")
        .replace("_Temp ", "_Cur ")
        .replace("degF", "mA")
    )
    (folder / "krn.dbc").write_text(text)
    connect(log, "--json")
    told = json.loads(capsys.readouterr().out)["open"]
    option = next(each for each in told if "is a current" in each).partition("--set ")[2]
    assert (
        main(["connect", "krn.dbc", "--log", str(log), "-o", "b.toml", "--set", shlex.split(option)[0]]) == 0
    )
    thumb = tomllib.loads((folder / "b.toml").read_text())["fingers"]["thumb"]
    assert thumb["normal_force"]["gain"] == "2.5 N/A"


def test_a_position_command_is_complete_with_the_two_options_that_were_asked_for(log, folder, capsys):
    text = (folder / "krn.dbc").read_text().replace('[0|100] "%"', '[0|100] "mm"')
    (folder / "krn.dbc").write_text(text)
    assert connect(log, *WINDOWS, *GAINS[:6]) == 0
    assert "nothing is commanded until you say the stiffness" in " ".join(capsys.readouterr().out.split())
    said = ["--set", "fingers.*.command.stiffness=2 N/mm"]
    said += [
        f
        for n, name in ((1, "thumb"), (2, "index"))
        for f in ("--set", f"fingers.{name}.command.feedback=MOTOR_FB.M{n}_Travel")
    ]
    assert connect(log, *WINDOWS, *GAINS[:6], *said, "--force") == 0
    command = tomllib.loads((folder / "hand.toml").read_text())["fingers"]["thumb"]["command"]
    assert (command["signal"], command["kind"], command["stiffness"]) == (
        "GRIP_CMD.F1_Set",
        "position",
        "2 N/mm",
    )
