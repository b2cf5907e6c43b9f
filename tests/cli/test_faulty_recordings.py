"""Recordings that cannot carry an answer, as files: what the commands say of them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.identification.recording import Fingertip, Recording, write_recording
from vegrip.identification.recording.report import MISSING
from vegrip.identification.simulate import simulate
from vegrip.identification.simulate.protocol import standard
from vegrip.model import paper_model
from vegrip.web.check.render import where

MODEL = paper_model(8e-3)
BOTH = pytest.mark.parametrize("command", ["fit", "compare"])


@pytest.fixture(scope="module")
def good() -> Recording:
    whole = standard(MODEL)
    protocol = replace(whole, episodes=tuple(whole.episodes[i] for i in (1, 6)), notes=())
    return simulate(MODEL, protocol, sensors={"normal_force": 0.01, "displacement": 5e-6}, rate=100.0)


def only(recording: Recording, *columns: str) -> Recording:
    return replace(recording, columns={name: recording.columns[name] for name in columns})


def later(recording: Recording, seconds: float) -> Recording:
    force = recording.columns["normal_force"].copy()
    for number in np.unique(recording.episode):
        rows = recording.episode == number
        force[rows] = np.interp(recording.t[rows] - seconds, recording.t[rows], force[rows])
    return replace(recording, columns={**recording.columns, "normal_force": force})


@BOTH
def test_without_contact_nothing_is_concluded(command, good, tmp_path: Path, capsys) -> None:
    write_recording(good.select(good.columns["displacement"] < -2e-5), tmp_path / "air")
    assert main([command, str(tmp_path / "air")]) == 3
    streams = capsys.readouterr()
    assert "without contact" in streams.err
    assert streams.out == ""


@BOTH
@pytest.mark.parametrize("missing", ["displacement", "normal_force"])
def test_a_missing_column_is_named(command, missing, good, tmp_path: Path, capsys) -> None:
    left = {"displacement", "normal_force"} - {missing}
    write_recording(only(good, *left), tmp_path / "half")
    assert main([command, str(tmp_path / "half")]) == 3
    assert f"has no {missing}" in capsys.readouterr().err


def in_millimetres(good: Recording) -> Recording:
    return replace(good, columns={**good.columns, "displacement": 1e3 * good.columns["displacement"]})


def pulled(good: Recording) -> Recording:
    return replace(good, columns={**good.columns, "normal_force": -good.columns["normal_force"]})


def touched(good: Recording) -> Recording:
    return good.select(np.cumsum(good.columns["normal_force"] > 0.05) <= 60)


def holed(good: Recording) -> Recording:
    return replace(good, source={**good.source, MISSING: 1224})


FAULTS = {
    "a recorder that lost states": (holed, "1224 states were sent and are not in it"),
    "radius": (lambda good: replace(good, fingertip=Fingertip(1e-3)), "the radius of the tip is stated as"),
    "millimetres": (in_millimetres, "unit of the displacement is wrong"),
    "sign": (pulled, "has the wrong sign"),
    "a touch": (touched, "too little to distinguish effects"),
    "clocks": (lambda good: later(good, 0.06), "their clocks disagree"),
}


@BOTH
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_the_recording_is_said_beside_the_numbers(
    command, fault, good, tmp_path: Path, capsys
) -> None:
    spoil, sentence = FAULTS[fault]
    write_recording(spoil(good), tmp_path / "faulty")
    assert main([command, str(tmp_path / "faulty")]) == 0
    assert sentence in capsys.readouterr().out
    assert main([command, str(tmp_path / "faulty"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert sentence in " ".join(told["doubts"])
    assert sentence in where({"where": [], **told})  # on the check page


@BOTH
def test_nothing_is_doubted_where_nothing_is_wrong(command, good, tmp_path: Path, capsys) -> None:
    write_recording(good, tmp_path / "good")
    assert main([command, str(tmp_path / "good"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["doubts"] == []


@pytest.mark.slow
def test_a_diagnosis_that_must_not_be_relied_on_says_so_first(good, tmp_path: Path, capsys) -> None:
    write_recording(replace(good, fingertip=Fingertip(1e-3)), tmp_path / "small")
    assert main(["diagnose", str(tmp_path / "small")]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert "not reliable" in first
    assert "radius" in first
