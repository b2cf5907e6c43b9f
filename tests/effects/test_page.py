"""The page of effects has what the code has."""

import re
from pathlib import Path

import pytest

from vegrip.cli import main
from vegrip.effects import BUILT_IN, effect

PAGE = (Path(__file__).parents[2] / "docs" / "effects.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", BUILT_IN)
def test_the_page_lists_every_parameter_with_its_typical_value_and_prior(name):
    row = next(line for line in PAGE.splitlines() if line.startswith(f"| [{name}]"))
    for p in effect(name).parameters:
        std = f"{100.0 * p.std:g} %" if p.transform == "log" else f"{p.std:g}"
        unit = "" if p.unit == "1" else f" {p.unit}"
        mark = "" if p.null is None else "†"
        absent = f" ({p.null:g})" if p.null else ""
        assert re.search(
            rf"{re.escape(f'`{p.symbol}`{mark} {p.default:g} ± {std}{unit}{absent}')}(; | \|)", row
        )
    assert all(other in row for other in effect(name).confounded)
    assert effect(name).experiment in row


def test_the_page_is_in_the_order_in_which_effects_act():
    places = [PAGE.index(f"| [{name}]") for name in BUILT_IN]
    assert places == sorted(places)


EXAMPLE = Path(__file__).parents[2] / "examples" / "second_spot"


def test_the_example_is_what_the_command_writes(tmp_path, capsys):
    folder = tmp_path / "written"
    assert main(["new-effect", "second_spot", "-o", str(folder)]) == 0
    assert "pip install" in capsys.readouterr().out
    files = {path.relative_to(folder): path.read_text() for path in folder.rglob("*") if path.is_file()}
    assert len(files) == 4
    for path, text in files.items():
        assert (EXAMPLE / path).read_text() == text


@pytest.mark.parametrize(
    ("name", "code", "words"),
    [
        ("adhesion", 2, "already"),
        ("two words", 2, "small letters"),
        ("lambda", 2, "small letters"),
        ("Stiff", 2, "small letters"),
    ],
)
def test_a_name_that_cannot_be_is_refused(name, code, words, tmp_path, capsys):
    assert main(["new-effect", name, "-o", str(tmp_path / "x")]) == code
    assert words in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "x").exists()


def test_a_folder_with_something_in_it_is_left_alone(tmp_path, capsys):
    (tmp_path / "mine.txt").write_text("mine")
    assert main(["new-effect", "give", "-o", str(tmp_path)]) == 3
    assert "not empty" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]
