"""No result is lost, and nothing that is there is written over: laws over every command with an output."""

import importlib.util
import json
import shutil
from pathlib import Path

import pytest

from vegrip.cli import main
from vegrip.model import paper_model, write_model

from .walk import commands

Capsys = pytest.CaptureFixture[str]
DATABASE = Path(__file__).parents[2] / "proto" / "fingertip.dbc"
WRITING = [one for one in commands() if "-o" in one.options]

# What each command is called with beside its output; inputs that are not there: a refusal comes before them.
# theirs.dbc and model.toml are there.
BEFORE_ANY_WORK = {
    "demo": [],
    "sample": ["press"],
    "record": [],
    "replay": ["absent", "--through"],
    "import": ["absent.csv"],
    "simulate": ["BENCH/press.toml"],
    "fit": ["absent"],
    "compare": ["absent"],
    "diagnose": ["absent"],
    "add": ["adhesion", "absent"],
    "refine": ["absent"],
    "draft": ["absent"],
    "experiment": ["absent"],
    "fleet": ["absent"],
    "new-effect": ["lateral_give"],
    "changed": ["absent", "other"],
    "paper": [],
    "connect": ["theirs.dbc"],
    "report": ["absent"],
    "controllers": [],
    "export c": ["model.toml"],
    "export learned": ["absent.toml", "absent.txt"],
    "export mujoco": ["model.toml"],
    "export mcap": ["absent"],
    "export lerobot": ["absent"],
    "bridge mcap": [],
}
ENDINGS = {"changed": ".png", "controllers": ".png", "draft": ".py"}  # that the name of an output must have
GROWS = {"check"}  # its output is a folder that the next run goes on with


def test_every_command_with_an_output_is_under_these_laws() -> None:
    assert {one.name for one in WRITING} == set(BEFORE_ANY_WORK) | GROWS


def test_an_output_is_spelled_alike_everywhere_and_can_be_forced() -> None:
    assert {one.name for one in WRITING if not {"--output", "--force"} <= one.options} == GROWS


def existing(folder: Path, name: str) -> Path:
    """Put something of the kind that the command writes in its way."""
    if name in ENDINGS:
        (folder / f"old{ENDINGS[name]}").write_text("measured")
        return folder / f"old{ENDINGS[name]}"
    files = ("fit", "add", "refine", "experiment", "fleet", "connect", "report", "export learned")
    if name in (*files, "export mujoco", "export mcap", "bridge mcap"):
        (folder / "old").write_text("measured")
        return folder / "old"
    (folder / "old").mkdir()
    (folder / "old" / "recording.toml").write_text("measured")
    return folder / "old"


@pytest.mark.parametrize("name", BEFORE_ANY_WORK)
def test_what_is_there_is_refused_before_any_work(
    name: str, bench: Path, tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATABASE, "theirs.dbc")
    write_model(paper_model(8e-3), "model.toml")
    output = existing(tmp_path, name)
    given = [each.replace("BENCH", str(bench)) for each in BEFORE_ANY_WORK[name]]
    arguments = [*name.split(), *given, "-o", str(output)]
    assert main(arguments) in (2, 3)
    complaint = capsys.readouterr().err
    assert str(output) in complaint
    assert "--force" in complaint
    assert len(complaint.splitlines()) == 1
    old = output if output.is_file() else output / "recording.toml"
    assert old.read_text() == "measured"


def test_a_report_that_cannot_be_written_is_refused_before_any_work(
    bench: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(bench)
    monkeypatch.setattr("vegrip.web.report.make.make_report", lambda *_: pytest.fail("begins to work"))
    assert main(["report", "press", "-o", "press.toml/report.html"]) == 3
    said = capsys.readouterr()
    assert "press.toml: cannot be written" in said.err
    assert said.out == ""


PRINTING = {
    "fit": ["press"],
    "add": ["adhesion", "press"],
    "compare": ["press", "--model", "press.toml"],
    "diagnose": ["press"],
    "refine": ["press"],
    "fleet": ["fleet", "-j", "1"],
    "changed": ["press", "press"],
    "paper": [],
}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(one, marks=pytest.mark.long) if one in ("changed", "fleet", "refine") else one
        for one in PRINTING
    ],
)
def test_what_cannot_be_written_is_a_sentence_and_the_result_is_printed_all_the_same(
    name: str, bench: Path, tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(bench)
    (tmp_path / "file").write_text("not a folder")
    if name == "fleet":
        monkeypatch.chdir(tmp_path)
        shutil.copytree(bench / "press", tmp_path / "fleet" / "a")
    output = str(tmp_path / "file" / f"result{ENDINGS.get(name, '')}")
    code = main([name, *PRINTING[name], "-o", output, "--json"])
    told = capsys.readouterr()
    assert code == 3
    assert json.loads(told.out)
    complaints = [line for line in told.err.splitlines() if line.startswith("vegrip: ")]
    assert len(complaints) == 1
    assert output in complaints[0]


def test_a_result_that_the_disk_refuses_afterwards_is_printed_too(
    bench: Path, tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("vegrip.model.write_model", full)
    output = tmp_path / "model.toml"
    assert main(["fit", str(bench / "press"), "-o", str(output), "--json"]) == 4
    told = capsys.readouterr()
    assert json.loads(told.out)["parameters"]
    assert "No space left on device" in told.err


def test_folders_of_an_output_are_made_and_go_again_when_nothing_comes(
    tmp_path: Path, capsys: Capsys
) -> None:
    assert main(["fit", str(tmp_path / "absent"), "-o", str(tmp_path / "models" / "today" / "x.toml")]) == 3
    assert not (tmp_path / "models").exists()
    assert "there is no such folder" in capsys.readouterr().err


def test_a_recording_that_is_replaced_by_force_comes_back_when_the_new_one_fails(
    bench: Path, tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = tmp_path / "rec"
    assert main(["import", str(bench / "raw.csv"), "-o", str(output)]) == 0
    old = (output / "recording.csv").read_text()
    (output / "notes.txt").write_text("mine")

    def full(*_: object, **__: object) -> None:
        (output / "recording.toml").write_text("half of it")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("vegrip.identification.recording.write_recording", full)
        assert main(["import", str(bench / "raw.csv"), "-o", str(output), "--force"]) == 130
    assert (output / "recording.csv").read_text() == old
    assert "half" not in (output / "recording.toml").read_text()
    (tmp_path / "next.csv").write_text("t,normal_force\n0,5\n")
    assert main(["import", str(tmp_path / "next.csv"), "-o", str(output), "--force"]) == 0
    assert (output / "recording.csv").read_text() != old
    assert (output / "notes.txt").read_text() == "mine"
    assert [each.name for each in tmp_path.iterdir() if each.name.startswith(".")] == []


DRAWING = {
    "compare": ["absent", "-o", "new"],
    "diagnose": ["absent", "-o", "new"],
    "paper": ["-o", "new"],
    "refine": ["absent", "--report", "new"],
    "experiment": ["absent", "--plot", "new.png"],
    "draft": ["absent", "-o", "law.py", "--picture", "new.png"],
    "simulate": ["BENCH/press.toml", "-o", "rec", "--plot", "new.png"],
    "replay": ["BENCH/press", "--through", "--plot", "new.png"],
}


@pytest.mark.parametrize("name", DRAWING)
def test_without_matplotlib_a_picture_is_refused_before_any_work(
    name: str, bench: Path, tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda n, *a: None if n == "matplotlib" else find(n, *a))
    given = [each.replace("BENCH", str(bench)) for each in DRAWING[name]]
    assert main([name, *given]) == 2
    told = capsys.readouterr()
    assert "pip install 'vegrip[plot]'" in told.err
    assert (told.out, len(told.err.splitlines())) == ("", 1)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "flag"), [("simulate", "--plot"), ("replay", "--plot"), ("refine", "--report")]
)
def test_a_picture_that_cannot_be_written_costs_no_result(
    name: str, flag: str, bench: Path, tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("not a folder")
    given = {
        "simulate": [str(bench / "press.toml"), "-o", "rec"],
        "replay": [str(bench / "press"), "--through"],
        "refine": [str(bench / "press")],
    }[name]
    assert main([name, *given, flag, "file/new.png", "--json"]) == 3
    told = capsys.readouterr()
    assert json.loads(told.out)
    assert "file/new.png: cannot be written" in told.err
