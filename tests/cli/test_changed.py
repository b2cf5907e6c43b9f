"""``vegrip changed``: what a machine reads, and what is refused before any fit."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.cli.conftest import first_presses
from vegrip.cli import main
from vegrip.identification.recording import write_recording


@pytest.mark.long
def test_the_json_has_what_the_contract_names(
    bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    later = first_presses()
    columns = {name: values for name, values in later.columns.items() if name != "torque_z"}
    columns["normal_force"] = columns["normal_force"] + 0.02
    write_recording(replace(later, columns=columns), tmp_path / "later")
    assert main(["changed", str(bench / "press"), str(tmp_path / "later"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["verdict"] == "named"
    assert [one["name"] for one in told["changed"]] == ["zero_normal_force"]
    (zero,) = told["changed"]
    assert zero["after"] - zero["before"] == pytest.approx(0.02, abs=3.0 * zero["std"])
    assert zero.keys() >= {"name", "before", "after", "std", "percent", "p"}
    assert (told["indistinguishable"], told["experiment"]) == ([], None)
    assert told["overlap"]["first_only"] == ["torque_z"]
    assert "torque_z" not in told["overlap"]["channels"]


@pytest.mark.long
def test_of_a_hand_each_finger_is_told_by_its_name_and_no_other_hides_what_changed_of_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    press = first_presses()
    names = [name for name in press.columns if name != "torque_z"]

    def write(day: str, finger: str, zero: float = 0.0, gain: float = 1.0) -> None:
        columns = {name: press.columns[name] for name in names}
        columns["normal_force"] = gain * columns["normal_force"] + zero
        tip = replace(press.fingertip, name=finger)
        write_recording(replace(press, columns=columns, fingertip=tip), tmp_path / day / finger)

    for finger in ("index", "thumb", "ring"):
        write("monday", finger)
    write("friday", "index", zero=0.02)
    write("friday", "thumb")
    write("friday", "ring", gain=0.0)  # its sensor is dead, which is said of this finger alone
    write("friday", "little")
    days = [str(tmp_path / "monday"), str(tmp_path / "friday")]
    assert main(["changed", *days, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["fingers"]["index"]["verdict"] == "named"
    assert [one["name"] for one in told["fingers"]["index"]["changed"]] == ["zero_normal_force"]
    assert told["fingers"]["thumb"]["sentence"] == "thumb: nothing changed"
    assert told["not_compared"].keys() == {"ring", "little"}
    assert told["not_compared"]["little"] == "only the second recording has it"
    assert main(["changed", *days, "-o", str(tmp_path / "hand.png")]) == 2
    assert "give its folder" in capsys.readouterr().err
    assert main(["changed", str(tmp_path / "friday" / "ring"), str(tmp_path / "monday" / "ring")]) == 3
    assert capsys.readouterr().err.splitlines()[-1].startswith("vegrip: press is without contact")


def test_what_cannot_be_read_or_written_is_one_sentence(
    bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    press = str(bench / "press")
    assert main(["changed", press, str(tmp_path / "nowhere")]) == 3
    (tmp_path / "there.png").write_bytes(b"")
    assert main(["changed", press, press, "-o", str(tmp_path / "there.png")]) == 3
    assert main(["changed", press]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 3
    assert all(line.startswith("vegrip: ") for line in said)
