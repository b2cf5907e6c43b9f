"""A hand whose fingers differ by one letter or number: all of them are mapped, and what is open is said."""

import json
import math
import shlex
import tomllib
from pathlib import Path

import can
import cantools.database
import numpy as np
import pytest

from vegrip.cli import main
from vegrip.connect.guess import all_signals
from vegrip.transport.maps.database import read_dbc

STATE = """BO_ {identifier} {f}_State: 12 Hand
 SG_ {own}_{normal}" PC
 SG_ {own}_Fs1 : 16|16@1- (0.5,0) [-3000|3000] "gf" PC
 SG_ {own}_Fs2 : 32|16@1- (0.5,0) [-3000|3000] "gf" PC
 SG_ {own}_Enc : 48|16@1- (1,0) [0|0] "cnt" PC
 SG_ {own}_Level : 64|8@1+ (1,0) [0|255] "" PC
 SG_ {own}_Roll : 72|4@1+ (1,0) [0|15] "" PC
 SG_ {own}_Crc : 80|8@1+ (1,0) [0|255] "" PC
"""
TARGET = ' SG_ {own}_Tgt : {bit}|16@1+ (1,0) [0|1000] "permille" Hand\n'
WINDOWS = ["--rest", "0..1", "--press", "1..4", "--shear", "4..8"]
COUNT = 1e-6  # [m] of a count of the encoder
GRAM = 9.80665e-3  # [N]


def own(finger):
    """Return how the signals of a finger begin: as its message, or shorter."""
    return finger.replace("Pad", "P")


def dbc(fingers, normal):
    states = "".join(
        STATE.format(identifier=528 + n, f=f, own=own(f), normal=normal) for n, f in enumerate(fingers)
    )
    targets = "".join(TARGET.format(own=own(f), bit=16 * n) for n, f in enumerate(fingers))
    return f'VERSION ""\nBU_: Hand PC\n{states}BO_ 768 Cmd: 8 PC\n{targets}'


def written(fingers, normal='Fn : 0|16@1- (0.5,0) [-3000|3000] "gf', silent=()):
    """Write the database and a log in which all others rest, press and are sheared along their x."""
    text = dbc(fingers, normal)
    Path("own.dbc").write_text(text)
    database, rng = cantools.database.load_string(text, "dbc"), np.random.default_rng(5)
    with can.CanutilsLogWriter("own.log", channel="own") as log:
        for i in range(1600):
            t = i / 200
            depth = 900e-6 * math.sin(math.pi * (t - 1) / 3) if t < 4 else min(500e-6, (t - 4) * 2e-3)
            depth = max(depth, -200e-6) if t > 1 else -200e-6
            force = 4.8e3 * max(depth, 0.0) * 1.0
            shear = 0.3 * force * max(math.sin(math.pi * (t - 5) / 3), 0.0) if t > 5 else 0.0
            for n, f in enumerate(fingers):
                if f in silent:
                    continue
                fn, fs1, fs2 = (
                    round((value / GRAM + rng.normal(0.0, 0.6)) / 0.5) * 0.5
                    for value in (-force + 14 * GRAM, 5 * GRAM, -shear)
                )
                values = {
                    normal.partition(" ")[0]: fn,
                    "Fs1": fs1,
                    "Fs2": fs2,
                    "Enc": round(1200 - depth / COUNT),
                }
                values |= {"Level": i % 7 * 3, "Roll": i % 16, "Crc": 0}
                message = database.get_message_by_name(f"{f}_State")
                data = bytearray(
                    message.encode({f"{own(f)}_{k}": v for k, v in values.items()}, strict=False)
                )
                data[10] = sum(data[:10]) & 0xFF
                log.on_message_received(
                    can.Message(
                        timestamp=t + n * 4e-4,
                        arbitration_id=528 + n,
                        data=data,
                        is_fd=True,
                        is_extended_id=False,
                    )
                )


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def connected(capsys, *options):
    assert main(["connect", "own.dbc", "--log", "own.log", *WINDOWS, "-o", "h.toml", "--json", *options]) == 0
    return tomllib.loads(Path("h.toml").read_text()), json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    "fingers", [("FA", "FB", "FC"), ("F1", "F2", "F3"), ("TipL", "TipM", "TipR"), ("PadK", "PadL", "PadM")]
)
def test_every_finger_of_one_letter_or_number_is_proposed_with_its_own_signals(folder, capsys, fingers):
    written(fingers)
    hand, told = connected(capsys, "--fingers", "thumb,index,middle")
    assert list(hand["fingers"]) == ["thumb", "index", "middle"]
    for f, mapped in zip(fingers, hand["fingers"].values(), strict=True):
        assert {name: mapped[name]["signal"] for name in list(mapped) if "force" in name} == {
            "normal_force": f"{f}_State.{own(f)}_Fn",
            "tangential_force_x": f"{f}_State.{own(f)}_Fs2",
            "tangential_force_y": f"{f}_State.{own(f)}_Fs1",
        }
    assert not any("no further finger" in sentence for sentence in told["open"])


def test_a_counter_is_found_by_its_rolling_whatever_its_name(folder, capsys):
    written(("FA", "FB", "FC"))
    hand, told = connected(capsys)
    assert [m["counter"] for m in hand["messages"].values()] == ["FA_Roll", "FB_Roll", "FC_Roll"]
    assert not any("no counter" in sentence for sentence in told["price"])


def test_every_signal_without_a_unit_of_force_is_named_with_the_option_that_answers_it(folder, capsys):
    written(("FA", "FB", "FC"))
    _, told = connected(capsys)
    said = "\n".join(told["open"])
    options = [shlex.split(line.partition("--set ")[2])[0] for line in told["open"] if "--set" in line]
    assert "FA_State.FA_Enc [cnt]" in said
    assert "Cmd.FA_Tgt [permille]" in said
    assert "FA_State.FA_Level (and 2 alike)" in said
    said_by_option = [part for option in options if "Level" not in option for part in ("--set", option)]
    hand, told = connected(capsys, "--force", *said_by_option)
    assert [line for line in told["open"] if "Level" not in line] == []
    for f, mapped in zip(("FA", "FB", "FC"), hand["fingers"].values(), strict=True):
        assert mapped["displacement"]["signal"] == f"{f}_State.{f}_Enc"
        assert mapped["displacement"]["sign"] == -1
        assert mapped["command"]["signal"] == f"Cmd.{f}_Tgt"


def test_a_force_of_no_known_name_is_found_by_the_press_and_said_once_for_all_fingers(folder, capsys):
    written(("FA", "FB", "FC"), 'Nrm : 0|16@1- (0.5,0) [-3000|3000] "cnt')
    assert main(["connect", "own.dbc", "--log", "own.log", *WINDOWS, "-o", "h.toml"]) == 3
    said = capsys.readouterr().err
    assert "FA_State.FA_Nrm answers to the press most" in said
    assert not Path("h.toml").exists()
    (_, option) = shlex.split(said[said.index("--set") :].rpartition(", with")[0])
    hand, _ = connected(capsys, "--set", option)
    for f, mapped in zip(("FA", "FB", "FC"), hand["fingers"].values(), strict=True):
        force = mapped["normal_force"]
        assert (force["signal"], force["sign"]) == (f"{f}_State.{f}_Nrm", -1)
        assert force["zero"] == pytest.approx(14.0, abs=0.3)
        assert force["noise"] > 0.0


def test_a_finger_that_no_name_tells_is_not_denied(folder, capsys):
    written(("FA", "FB"))
    _, told = connected(capsys, "--fingers", "thumb,index,middle")
    assert any("middle: no name, letter or number shows a further finger" in line for line in told["open"])


@pytest.mark.parametrize(
    ("options", "named"), [(["--fingers", "thumb,index,middle"], "middle: "), ([], "a further finger: ")]
)
def test_of_a_finger_that_sends_nothing_it_is_said_that_no_frame_came(folder, capsys, options, named):
    written(("FA", "FB", "FC"), silent=("FC",))
    hand, told = connected(capsys, *options)
    assert list(hand["fingers"]) == ["thumb", "index"]
    (said,) = [line for line in told["open"] if "no frame of FC_State came" in line]
    assert said.startswith(named)
    assert not any("shows a further finger" in line for line in told["open"])


ALONE = {
    "axes of one finger": ("Tip", ("LoadA", "LoadB", "LoadC", "TorqueA", "TorqueB", "TorqueC")),
    "x, y and z": ("Tip", ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")),
    "two shears": ("Tip", ("Fn", "Fs1", "Fs2", "Ts1", "Ts2")),
}


@pytest.mark.parametrize("name", ALONE)
def test_the_letter_of_an_axis_is_no_finger(folder, name):
    message, signals = ALONE[name]
    lines = [
        f' SG_ {signal} : {8 * n}|8@1- (1,0) [0|0] "{"Nm" if signal[0] == "T" else "N"}" PC'
        for n, signal in enumerate(signals)
    ]
    (folder / "one.dbc").write_text(
        "\n".join(['VERSION ""', "BU_: Hand PC", f"BO_ 5 {message}: 8 Hand", *lines, ""])
    )
    assert {one.finger for one in all_signals(read_dbc(folder / "one.dbc"))} == {""}
