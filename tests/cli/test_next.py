"""What a command says at its end: what to call next, or what is kept of a work that was stopped."""

import re
import shlex
from pathlib import Path

import pytest

from vegrip import cli
from vegrip.cli import main
from vegrip.cli.sample import NAME
from vegrip.identification.samples import COLUMNS, SAMPLES, UNITS

from .walk import commands

ROOT = Path(__file__).parents[2]
Capsys = pytest.CaptureFixture[str]
MAPS = [word for one in COLUMNS for word in ("--map", one)] + [
    word for one in UNITS for word in ("--unit", one)
]


def next_command(shown: str) -> list[str]:
    (line,) = [line for line in shown.splitlines() if line.startswith("next: ")]
    words = shlex.split(line.removeprefix("next: "))
    assert words[0] == "vegrip"
    by_name = {one.name: one for one in commands()}
    by_name[words[1]].click.make_context(words[1], words[2:])  # raises where an option is unknown
    return words[1:]


def test_import_and_fit_say_what_comes_next(tmp_path: Path, capsys: Capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "press.csv"]) == 0
    capsys.readouterr()
    assert main(["import", "press.csv", "-o", "my rig", *MAPS, "--radius", "8mm"]) == 0
    then = next_command(capsys.readouterr().out)
    assert then == ["fit", "my rig"]
    assert main([*then, "-o", "rig.toml", "--tolerance", "0.001"]) == 0
    assert next_command(capsys.readouterr().out) == (
        ["diagnose", "my rig", "--model", "rig.toml", "--tolerance", "0.001"]
    )
    assert main([*then, "--tolerance", "0.01"]) == 0
    assert next_command(capsys.readouterr().out)[:2] == ["fit", "my rig"]


def test_trials_with_zeros_at_their_touches_are_fitted_with_zeros_of_their_own(
    tmp_path: Path, capsys: Capsys, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "press.csv"]) == 0
    capsys.readouterr()
    arguments = ["import", "press.csv", *MAPS, "--radius", "8mm", "--zero", "displacement=contact"]
    assert main([*arguments, "--zero", "normal_force=baseline", "--baseline", "0.5", "-o", "rig"]) == 0
    assert next_command(capsys.readouterr().out) == ["fit", "rig", "--zeros-each-episode"]
    assert main([*arguments, "--zero", "t=first", "-o", "other"]) == 2
    assert "t has no zero" in capsys.readouterr().err


def test_a_log_whose_radius_is_unknown_is_played_through_the_node(
    tmp_path: Path, capsys: Capsys, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "press.blf"]) == 0
    capsys.readouterr()
    assert main(["import", "press.blf", "-o", "log", "--fingers", "thumb"]) == 0
    assert next_command(capsys.readouterr().out) == ["replay", "log/thumb", "--through"]
    assert main(["import", "press.blf", "-o", "again", "--fingers", "thumb", "--map", "t=x"]) == 2
    assert "--map does not apply to a CAN log" in capsys.readouterr().err


def test_a_suspicious_table_sends_nobody_on(tmp_path: Path, capsys: Capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "press.csv"]) == 0
    arguments = ["import", "press.csv", *MAPS, "--radius", "8mm", "--negate", "normal_force"]
    capsys.readouterr()
    assert main([*arguments, "-o", "wrong"]) == 0
    shown = capsys.readouterr().out
    assert "has the wrong sign" in shown
    assert "import with --negate normal_force" in shown
    assert "next:" not in shown
    assert main([*arguments, "--negate", "normal_force", "-o", "right"]) == 0
    assert "suspicious" not in capsys.readouterr().out
    assert main(["fit", "wrong"]) == 0
    told = capsys.readouterr()
    assert "check columns, units, signs" in told.out.splitlines()[-1]
    assert "--tolerance" not in told.out
    lines = told.err.splitlines()
    assert len(set(lines)) == len(lines), "each step is told once"


@pytest.mark.parametrize(("rows", "is_enough"), [(1, False), (49, False), (50, True)])
def test_too_few_rows_for_a_fit_send_nobody_to_one(
    rows: int, is_enough: bool, tmp_path: Path, capsys: Capsys, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = (f"{i / 100},{i / 1e5},{i / 100}\n" for i in range(rows))
    Path("few.csv").write_text("t,displacement,normal_force\n" + "".join(lines))
    assert main(["import", "few.csv", "-o", "few", "--radius", "8mm"]) == 0
    shown = capsys.readouterr().out
    assert ("next: vegrip fit few" in shown) == is_enough
    assert ("few has fewer than 50 rows with displacement" in shown) == (not is_enough)


@pytest.mark.parametrize("options", [[], ["--radius", "8mm"], ["--map", "t=t"]])
def test_a_table_is_no_recording_to_go_to_mcap_whatever_is_said_of_it(
    options: list[str], tmp_path: Path, capsys: Capsys, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("few.csv").write_text("t,normal_force\n0,1\n1,2\n")
    assert main(["import", "few.csv", *options, "-o", "few.mcap"]) == 3
    assert "few.csv: is a file; a recording is a folder: make one" in capsys.readouterr().err
    assert not Path("few.mcap").exists()


@pytest.mark.parametrize("name", sorted(cli.STOPPED))
def test_a_command_that_is_interrupted_says_what_it_keeps(name: str, capsys: Capsys, monkeypatch) -> None:
    def interrupted(*, drive: bool = False, weight: bool = False) -> None:
        raise KeyboardInterrupt

    assert name.split(maxsplit=1)[0] in cli.COMMANDS
    monkeypatch.setattr(cli, "load", lambda _: cli._as_app(interrupted))
    assert main(name.split()) == 130
    assert capsys.readouterr().err == f"vegrip: stopped; {cli.STOPPED[name]}\n"


def test_who_ends_a_program_that_runs_until_then_is_told_nothing(capsys: Capsys, monkeypatch) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "load", lambda _: cli._as_app(interrupted))
    assert main(["monitor"]) == 130
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "command", ["fit", "diagnose", "refine -o m.toml", "replay --through", "fleet", "report"]
)
def test_a_table_as_recording_is_sent_to_import(
    command: str, tmp_path: Path, capsys: Capsys, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my press.csv.gz").write_text("t,normal_force\n")
    assert main([*command.split(), "my press.csv.gz"]) == 3
    assert "make one with `vegrip import 'my press.csv.gz' -o 'my press'`" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("fit press/recording.toml", "is a file; a recording is a folder: give press\n"),
        ("fit press/recording.csv.gz", "is a file; a recording is a folder: give press\n"),
        ("fit press.toml", "press.toml: is a file; a recording is a folder\n"),
        ("import press.toml -o x", "press.toml: is TOML, as a model or a map is, and no table"),
        (
            "import log.txt -o x",
            "none of its 1 frames is a fingertip's state (for a hand of another make see",
        ),
        ("export c picture.png -o x", "picture.png: is not a text file in UTF-8; give a file of TOML\n"),
        ("export c press -o x", "press: cannot be read (Is a directory)\n"),
        ("connect press", "press: is a folder; give a file\n"),
    ],
)
def test_a_file_of_another_kind_is_named_with_what_to_give(
    words: str, sentence: str, tmp_path: Path, capsys: Capsys, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("press").mkdir()
    for name in ("press/recording.toml", "press/recording.csv.gz", "press.toml"):
        Path(name).write_text("a = 1\n")
    Path("log.txt").write_text("(1700000000.000000) can0 123#0011223344556677\n")
    Path("picture.png").write_bytes(b"\x89PNG\r\n")
    assert main(words.split()) == 3
    assert sentence in capsys.readouterr().err


def test_help_and_pages_know_the_same_samples() -> None:
    (argument,) = NAME.__metadata__
    listed = argument.help.removeprefix("One of ").partition(";")[0].split(", ")
    assert listed == list(SAMPLES)
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    used = {name for page in pages for name in re.findall(r"vegrip sample ([\w.]+)", page.read_text("utf-8"))}
    assert used
    assert used <= set(SAMPLES)
