"""``vegrip replay --through``: a recording goes through the grasp force node, and a summary comes out."""

import json
import time
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.identification.recording import Fingertip, Recording, read_recording, write_recording
from vegrip.identification.recording.session import read_output
from vegrip.messages import FingertipState
from vegrip.transport.open import Hand, open_endpoint

Capsys = pytest.CaptureFixture[str]


@pytest.fixture
def press(tmp_path: Path) -> Path:
    """Half a second of air, a press to 1 mm within a second, a hold with Hertz' force, 100 Hz."""
    t = np.arange(0.0, 3.0, 0.01)
    depth = 1e-3 * np.clip(t - 0.5, 0.0, 1.0) - 1e-4 * (t < 0.5)
    force = 2.0 * (np.maximum(depth, 0.0) / 1e-3) ** 1.5
    rng = np.random.default_rng(1)
    columns = {
        "displacement": depth + rng.normal(0.0, 5e-6, t.size),
        "normal_force": force + rng.normal(0.0, 0.01, t.size),
        "tangential_force_x": 0.1 * force,
        "tangential_force_y": 0.0 * force,
        "torque_z": 0.0 * force,
    }
    sensors = {"normal_force": 0.01, "displacement": 5e-6}
    recording = Recording("press", t, np.zeros(t.size, int), columns, Fingertip(0.009), sensors)
    write_recording(recording, tmp_path / "press")
    return tmp_path / "press"


def test_the_node_follows_a_press(press: Path, tmp_path: Path, capsys: Capsys) -> None:
    out, plot = tmp_path / "out", tmp_path / "plots" / "press.png"
    assert main(["replay", str(press), "--through", "--json", "-o", str(out), "--plot", str(plot)]) == 0
    told = json.loads(capsys.readouterr().out)
    index = told["fingers"]["index"]
    assert (index["samples"], told["rejected"]) == (300, {})
    assert index["contact_time"] == pytest.approx(2.5, abs=0.3)
    assert index["force_rms"] < 0.1  # [N] of 2
    assert index["commands"] >= 300
    assert plot.read_bytes().startswith(b"\x89PNG")
    contact = read_output(out / "index" / "contact.csv")
    assert contact["normal_force"][-1] == pytest.approx(2.0, abs=0.1)
    assert contact["indentation"][-1] == pytest.approx(1e-3, abs=5e-5)
    np.testing.assert_array_equal(read_recording(out / "index").stamps, read_recording(press).stamps)


def test_people_get_a_table(press: Path, capsys: Capsys) -> None:
    whole = read_recording(press)
    left = {name: one for name, one in whole.columns.items() if "tangential" not in name}
    write_recording(replace(whole, columns=left), press.parent / "bare")
    assert (
        main(["replay", str(press.parent / "bare"), "--through", "--finger", "thumb", "--load", "1.9"]) == 0
    )
    shown = " ".join(capsys.readouterr().out.split())
    assert "thumb" in shown
    assert "refused as outliers" in shown
    assert "lowest margin bound below 0: a slip was possible" in shown


def test_a_share_of_a_mass_is_said_to_be_assumed_only_where_no_load_is_felt(
    press: Path, capsys: Capsys
) -> None:
    whole = read_recording(press)
    left = {name: one for name, one in whole.columns.items() if "tangential" not in name}
    write_recording(replace(whole, columns=left), press.parent / "bare")
    for name, said in (("bare", "index taken to bear an even share of 0.2 kg, 1.96 N each"), ("press", "")):
        assert main(["replay", str(press.parent / name), "--through", "--mass", "0.2", "--json"]) == 0
        told = json.loads(capsys.readouterr().out)["assumed"]
        assert told.startswith(said)
        assert bool(told) is bool(said)


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (["absent", "--through"], 3, "there is no such folder"),
        (["absent"], 3, "there is no such folder"),
        (["PRESS", "--through", "--speed", "2"], 2, "leave out --speed"),
        (["PRESS", "--plot", "x.png"], 2, "belong to --through"),
        (["PRESS", "--through", "--parameters", "absent.toml"], 3, "there is no such file"),
        (["PRESS", "--through", "-o", "PRESS"], 3, "holds a recording already"),
        (["PRESS", "--through", "--plot", "x.nosuchformat"], 3, "the picture cannot be written"),
        (["PRESS", "--set", "transport.kind=pigeon"], 3, "'kind' is 'pigeon'"),
    ],
)
def test_bad_input_gets_one_sentence(
    arguments: list[str], code: int, sentence: str, press: Path, capsys: Capsys
) -> None:
    assert main(["replay", *(str(press) if a == "PRESS" else a for a in arguments)]) == code
    shown = capsys.readouterr()
    assert sentence in shown.err
    assert len(shown.err.strip().splitlines()) == 1
    assert "Traceback" not in shown.err + shown.out


@pytest.mark.usefixtures("runtime")
def test_a_recording_played_on_a_bus_arrives_there_in_full_and_at_its_pace(press: Path) -> None:
    bus = {"channel": "played"}
    with closing(open_endpoint(bus, Hand(("thumb", "index")))) as listener:
        started = time.monotonic()
        arguments = ["--finger", "index", "--speed", "10", "--set", "transport.channel=played"]
        assert main(["replay", str(press), *arguments]) == 0
        assert time.monotonic() - started > 0.29  # [s] for 2.99 s
        states: list[FingertipState] = []
        recorded = read_recording(press)
        while len(states) < len(recorded) and time.monotonic() - started < 60.0:
            states += [message for message in listener.receive(0.1) if isinstance(message, FingertipState)]
        states += [message for message in listener.receive(0.1) if isinstance(message, FingertipState)]
    assert {state.finger for state in states} == {"index"}
    np.testing.assert_allclose(
        [state.normal_force for state in states], recorded.columns["normal_force"], rtol=1e-6
    )


@pytest.mark.parametrize("options", [["--map", "hand.toml"], []])
def test_a_log_that_is_not_there_is_called_a_file(options: list[str], tmp_path: Path, capsys: Capsys) -> None:
    assert main(["replay", str(tmp_path / "nosuch.log"), *options]) == 3
    assert "nosuch.log: there is no such file\n" in capsys.readouterr().err
