"""Every command answers alike: laws over the help and the mistakes of usage of all of them."""

import inspect
import json
import re
import shlex
from pathlib import Path
from typing import get_args, get_type_hints

import pytest
from typer.models import ParameterInfo

from vegrip import cli
from vegrip.cli import main
from vegrip.cli._terminal import complain, printer, show, table

from .walk import Command, commands

Capsys = pytest.CaptureFixture[str]
ALL = commands()
BY_NAME = {one.name: one for one in ALL}
UNIT = re.compile(r"\[[^\]\s]+\]|\[[^\]]*/[^\]]*\]")
UNTIL_INTERRUPTED = {"bridge foxglove", "bridge mcap", "bridge ros2", "launch", "node", "record", "check"}


def named(one: Command) -> str:
    return one.name


def written(one: Command) -> str:
    """Return what the author wrote of a command: its docstring and the help of its options."""
    function = one.click.callback
    hints = get_type_hints(inspect.unwrap(function), include_extras=True).values()
    told = [each.help or "" for hint in hints for each in get_args(hint) if isinstance(each, ParameterInfo)]
    return "\n".join([inspect.getdoc(inspect.unwrap(function)) or "", *told])


def examples(one: Command) -> list[list[str]]:
    """Return the commands of the examples in a help, split as a shell does."""
    text = inspect.getdoc(inspect.unwrap(one.click.callback)) or ""
    lines = [line for part in text.split("\n\n") if "vegrip " in part for line in [" ".join(part.split())]]
    found = []
    for line in lines:
        pieces = line[line.index(": vegrip ") + 2 :].split("&&") if ": vegrip " in line else []
        found += [shlex.split(piece)[1:] for piece in pieces]
    return found


def squeezed(text: str) -> str:
    return re.sub(r"[\s│]", "", text)


def shown_help(one: Command, capsys: Capsys, flag: str) -> str:
    assert main([*one.path, flag]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("command", ALL, ids=named)
def test_both_flags_show_the_same_help_with_every_unit_of_the_source(
    command: Command, capsys: Capsys
) -> None:
    shown = shown_help(command, capsys, "-h")
    assert shown == shown_help(command, capsys, "--help")
    units = UNIT.findall(written(command))
    assert [unit for unit in units if squeezed(unit) not in squeezed(shown)] == []


def test_nothing_that_is_printed_is_read_as_markup(capsys: Capsys) -> None:
    content = table("speed [m/s]", "note")
    content.add_row("[m]", "add a [transport.curve] table")
    show(content)
    printer().print("radius [m], [N]")
    complain("radius [m]")
    told = capsys.readouterr()
    assert all(text in told.out for text in ("speed [m/s]", "[m] ", "[transport.curve]", "radius [m], [N]"))
    assert "radius [m]" in told.err
    own = [path for path in Path(cli.__file__).parent.glob("*.py") if "Console(" in path.read_text()]
    calls = [call for path in own for call in re.findall(r"\bConsole\([^)]*\)", path.read_text())]
    assert [call for call in calls if "markup=False" not in call] == []


def test_units_are_looked_for_at_all() -> None:
    assert {"[m]", "[m/s]"} <= set(UNIT.findall(written(BY_NAME["experiment"])))


@pytest.mark.parametrize("command", ALL, ids=named)
def test_every_help_has_an_example_of_the_command_and_it_can_be_parsed(command: Command) -> None:
    told = examples(command)
    assert any(tuple(each[: len(command.path)]) == command.path for each in told), told
    for each in told:
        assert each[0] in cli.COMMANDS
        depth = 1 if each[0] in BY_NAME else 2
        one = BY_NAME[" ".join(each[:depth])]
        one.click.make_context(one.name, each[depth:])  # raises where an option is unknown or a value wrong


@pytest.mark.parametrize("command", ALL, ids=named)
def test_an_unknown_option_is_one_sentence_with_the_nearest_one(command: Command, capsys: Capsys) -> None:
    if command.name == "param set":
        pytest.skip("its value may look like an option: -1")
    options = sorted(option for option in command.options if option.startswith("--") and len(option) > 5)
    known = [option for option in options if option[-1] != option[-2]]
    wrong = known[0][:-2] + known[0][-1] + known[0][-2] if known else "--nosuch"
    assert main([*command.path, wrong]) == 2
    told = capsys.readouterr()
    assert len(told.err.splitlines()) == 1
    assert f"there is no option {wrong}" in told.err
    assert not known or "did you mean --" in told.err
    assert f"vegrip {command.name} -h" in told.err
    assert told.out == ""


def test_what_prints_has_json() -> None:
    assert {one.name for one in ALL if "--json" not in one.options} == UNTIL_INTERRUPTED


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["fit", "x", "--tolerance", "5"], "--tolerance is '5': it must be less than or equal to 1"),
        (["simulate", "x", "-o", "y", "--rate", "fast"], "--rate is 'fast': it must be a valid number"),
        (["import", "x.csv"], "-o/--output is missing (Folder to write the recording to"),
        (["fit"], "RECORDING is missing"),
        (["fit", "x", "y"], "unexpected extra argument"),
        (["topic", "ecko"], "did you mean 'echo'"),
        (["diagnos"], "did you mean diagnose?"),
        (["add", "adhesoin", "x"], "did you mean adhesion?"),
        (["experiment", "x", "--candidates", "adhesoin"], "did you mean adhesion?"),
        (["launch", "demmo"], "did you mean demo?"),
        (["sample", "pres"], "did you mean press?"),
        (["bench", "recursoin"], "did you mean recursion?"),
        (["import", "x.csv", "-o", "y", "--radius", "-8 mm"], "give a length above 0"),
        (["import", "x.csv", "-o", "y", "--radius", "8"], "which is 8 m"),
        (["node", "grasp_force", "--set", "fingers=[]"], "'fingers' is empty"),
        (["node", "grasp_force", "--set", "parametres.x=1"], "did you mean parameters?"),
    ],
)
def test_a_mistake_is_one_sentence_before_any_work(
    arguments: list[str], sentence: str, bench: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(bench)
    given = ["press" if each == "x" and arguments[0] in ("add", "experiment") else each for each in arguments]
    assert main(given) in (2, 3)
    told = capsys.readouterr().err
    assert len(told.splitlines()) == 1
    assert sentence in told


def test_parameters_of_a_launch_file_are_checked_without_starting_it(tmp_path: Path, capsys: Capsys) -> None:
    file = tmp_path / "bad.toml"
    file.write_text('[[node]]\nprogram = "virtual_hand"\nparameters.seeed = 1\n')
    assert main(["launch", str(file), "--check"]) == 3
    assert "did you mean seed?" in capsys.readouterr().err


def test_commands_come_in_groups_and_the_version_is_told(capsys: Capsys) -> None:
    assert main([]) == 0
    shown = capsys.readouterr().out
    assert all(f"\n  {heading}" in shown for heading in cli.GROUPS)
    assert main(["--version"]) == 0
    assert re.fullmatch(r"vegrip \d+\.\d+\.\d+\S*\n", capsys.readouterr().out)


@pytest.mark.parametrize(("words", "wanted"), [("vegrip fi", "fit"), ("vegrip fit --tol", "--tolerance")])
def test_the_shell_completes_commands_and_options(
    words: str, wanted: str, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("_VEGRIP_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(len(words.split()) - 1))
    with pytest.raises(SystemExit):
        cli.entry()
    assert wanted in capsys.readouterr().out.split()


RUN_HERE = [
    one.name
    for one in ALL
    if one.path[0]
    not in ("demo", "launch", "node", "monitor", "check", "topic", "param", "lifecycle", "record", "zero")
    and one.path[0] not in ("grasp", "release")
    and one.name not in ("bridge mcap", "bridge ros2")
]


def is_run_by(name: str, other: str) -> bool:
    mine, longer = examples(BY_NAME[name]), examples(BY_NAME[other])
    return len(mine) < len(longer) and longer[: len(mine)] == mine


RUN_BY_ANOTHER = {name for name in RUN_HERE for other in RUN_HERE if is_run_by(name, other)}
"""Their examples are the first lines of another one."""
LONG = {
    "controllers",
    "changed",
    "refine",
    "report",
    "fleet",
    "experiment",
    "diagnose",
    "draft",
    "bench",
    "trial",
    "replay",
    "export",
    "paper",
}
"""First words of those that take several seconds each."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long if name.split()[0] in LONG else ())
        for name in RUN_HERE
        if name not in RUN_BY_ANOTHER
    ],
)
def test_an_example_runs_as_written_in_an_empty_folder(
    name: str, tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for example in examples(BY_NAME[name]):
        assert main(example) in ((0, 4) if name == "doctor" else (0,)), (example, capsys.readouterr().err)


def test_a_sample_that_is_there_is_no_mistake_and_a_changed_one_is_not_replaced(
    tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "press"]) == 0
    assert main(["sample", "press"]) == 0
    (tmp_path / "press" / "recording.toml").write_text("mine")
    assert main(["sample", "press"]) == 3
    assert (tmp_path / "press" / "recording.toml").read_text() == "mine"
    capsys.readouterr()
    assert main(["sample", "--json"]) == 0
    assert "press.blf" in json.loads(capsys.readouterr().out)
