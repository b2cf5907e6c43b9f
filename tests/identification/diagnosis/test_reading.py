"""What a diagnosis says can be read: SI beside scaled values, heights, no advice to run what is running."""

import dataclasses
import hashlib
import json
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from tools import make_samples
from vegrip.cli import main
from vegrip.effects import BUILT_IN, effect
from vegrip.identification.compare.where import format_height
from vegrip.identification.diagnosis.account import described, versions
from vegrip.identification.recording import write_recording
from vegrip.identification.samples import recording
from vegrip.model import read_model
from vegrip.parameters import in_si
from vegrip.runtime.replay.run import gaps_of, offline

SCALED = ("x_ref", "over K", "of K", "[K]", "K per")
UNITS = {"K/s": "1/s", "x_ref/s": "1/s", "K s^2/x_ref": "s^2"}  # "1" of the others


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that a diagnosis of the sample writes; what it printed lies beside, as said.txt."""
    folder = tmp_path_factory.mktemp("reading")
    said = StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(said):
        patch.chdir(folder)
        assert main(["sample", "press"]) == 0
        assert main(["diagnose", "press", "-o", "found"]) == 0
    (folder / "said.txt").write_text(said.getvalue())
    return folder / "found"


@pytest.mark.long
def test_the_folder_has_a_picture_per_channel_the_diagnosis_and_a_model_that_reads(found: Path) -> None:
    names = {path.name for path in found.iterdir()}
    assert names == {"normal_force.png", "tangential_force.png", "diagnosis.json", "model.toml"}
    assert (found / "normal_force.png").read_bytes().startswith(b"\x89PNG")
    assert "adhesion" in [one.name for one in read_model(found / "model.toml").effects]


def test_the_hidden_pull_is_told_in_newtons(found: Path) -> None:
    told = json.loads((found / "diagnosis.json").read_text())
    assert told["named"] == ["adhesion"]
    assert told["si"]["pull"]["unit"] == "N"
    hidden = float(make_samples.HIDDEN_EFFECTS["adhesion"]["force"])
    assert told["si"]["pull"]["value"] == pytest.approx(hidden, rel=0.1)


def test_nothing_advises_to_run_what_is_running(found: Path) -> None:
    assert "vegrip diagnose" not in (found / "diagnosis.json").read_text()


def test_every_parameter_whose_text_says_it_is_scaled_can_be_told_in_si() -> None:
    silent, wrong = [], []
    for one in map(effect, BUILT_IN):
        for parameter in one.parameters:
            if any(text in parameter.doc for text in SCALED) and not parameter.of:
                silent.append(parameter.symbol)
            if parameter.of and parameter.unit != UNITS.get(parameter.of, "1"):
                wrong.append(parameter.symbol)
    assert wrong == []
    # growth per x_ref is no multiple of it
    assert set(silent) <= {"g_v", "g_J", "b_x", "beta_x", "K", "rho"}


def test_a_share_of_the_force_at_the_reference_depth_is_newtons() -> None:
    pull = next(p for p in effect("adhesion").parameters if p.symbol == "pull")
    assert in_si(pull, 0.074, 1.99, 8e-4) == (pytest.approx(0.147, abs=1e-3), "N")
    assert in_si(next(p for p in effect("adhesion").parameters if p.symbol == "n_v"), 0.5, 2.0, 1e-3) is None
    for name, place, unit in (("force_drift", 0, "N/s"), ("guide_friction", 1, "m/s"), ("inertia", 0, "kg")):
        value = {"N/s": 0.1 * 2.0, "m/s": 0.1 * 8e-4, "kg": 0.1 * 2.0 / 8e-4}[unit]
        assert in_si(effect(name).parameters[place], 0.1, 2.0, 8e-4) == (pytest.approx(value), unit)


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (-3.5e-6, None, "closer than 3.5 um to the surface"),
        (None, -80e-6, "more than 80 um from the surface"),
        (-80e-6, -3.5e-6, "3.5 um to 80 um from the surface"),
        (None, 2e-3, "at a depth of up to 2 mm"),
    ],
)
def test_a_depth_below_zero_is_a_height(low: float | None, high: float | None, words: str) -> None:
    assert format_height(low, high) == words


def test_a_replay_starts_no_process_that_outlives_it_unless_asked() -> None:
    assert offline({})["suspects"] is False
    assert offline({"suspects": True})["suspects"] is True


@pytest.mark.long
def test_between_trials_no_input_is_stale(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "press"]) == 0
    capsys.readouterr()
    assert main(["replay", "press", "--through", "--json"]) == 0
    (told,) = json.loads(capsys.readouterr().out)["fingers"].values()
    conditions = told["conditions"]
    assert conditions.get("stale", 0) == 0
    assert conditions["ok"] > 0.97 * sum(conditions.values())
    one = recording()
    gaps = gaps_of(one, 0)
    assert len(gaps) == 1 + np.count_nonzero(np.diff(one.episode))
    assert told["contact_time"] < one.duration - sum(end - begin for begin, end in gaps[1:]) * 1e-9


def test_the_last_lines_are_of_the_model_that_was_found_and_those_of_the_start_say_so(found: Path) -> None:
    said, told = (found.parent / "said.txt").read_text(), json.loads((found / "diagnosis.json").read_text())
    before, after = (f"{told['error'][which]:.3f} times the noise" for which in ("before", "after"))
    start, end = (
        said.index(text) for text in (f"the start model leaves {before}", f"adhesion leaves {after}")
    )
    assert start < said.index(told["where"][0]["note"][:40]) < end
    assert [one for one in told["where_after"] if one in told["where"]] == []
    assert not any("times the noise" in one for one in told["warnings"])  # 1.02: the model that was found


def test_every_candidate_has_its_round_and_what_became_of_it(found: Path) -> None:
    told = json.loads((found / "diagnosis.json").read_text())
    assert (told["effects"][0]["name"], told["effects"][0]["outcome"]) == ("adhesion", "taken")
    for one in told["rounds"]:
        assert one["round"] >= 1
        assert one["outcome"].startswith("fails: ") == bool(one["failed"])
        assert one["name"] in (found.parent / "said.txt").read_text()


def test_what_was_measured_is_told_with_the_ranges_and_a_checksum_of_the_file(tmp_path: Path) -> None:
    one = recording()
    one = dataclasses.replace(one, columns={**one.columns, "torque_z": np.full(len(one), np.nan)})
    told = described(one, tmp_path / "nothing")
    assert told["sha256"] == ""
    assert (told["rows"], told["episodes"]) == (len(one), np.unique(one.episode).size)
    assert told["duration"] == pytest.approx(one.t[-1] - one.t[0])
    assert told["tip_radius"] == one.fingertip.radius
    measured = {name for name, values in one.columns.items() if np.isfinite(values).any()}
    assert set(told["channels"]) == measured
    for name in measured:
        assert told["channels"][name] == [np.nanmin(one.columns[name]), np.nanmax(one.columns[name])]
    write_recording(one, tmp_path / "press")
    data = next((tmp_path / "press").glob("recording.csv*"))
    assert described(one, tmp_path / "press")["sha256"] == hashlib.sha256(data.read_bytes()).hexdigest()
    assert {"python", "vegrip", "numpy", "scipy", "numba"} == set(versions())
