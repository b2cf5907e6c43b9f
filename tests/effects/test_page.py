"""The catalogue of effects has what the code has."""

import importlib.util
import re
from pathlib import Path

import pytest

from vegrip.cli import main
from vegrip.effects import BUILT_IN, effect
from vegrip.model import paper_model

DOCS = Path(__file__).parents[2] / "docs"
SPEC = importlib.util.spec_from_file_location("effect_pages", DOCS / "site" / "effect_pages.py")
catalogue = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(catalogue)


def test_the_generated_catalogue_has_every_parameter_with_its_prior_and_the_motion():
    text = catalogue.page()
    for name in BUILT_IN:
        section = text.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
        for p in effect(name).parameters:
            prior = f"{100.0 * p.std:g} %" if p.transform == "log" else f"{p.std:g}"
            assert f"| `{p.symbol}` | {p.unit} | {p.default:g} | {prior} |" in section
        assert all(f"[{other}](#{other})" in section for other in effect(name).confounded)
        assert effect(name).experiment in section


def test_the_catalogue_is_in_the_order_in_which_effects_act_and_says_what_each_leaves():
    sections = re.split(r"^## ", catalogue.page(), flags=re.MULTILINE)[1:]
    assert [section.partition("\n")[0] for section in sections] == list(BUILT_IN)
    base = {one.name for one in paper_model(0.008).effects}
    for name, section in zip(BUILT_IN, sections, strict=True):
        assert ("What a model without it leaves: " in section) == (name not in base)


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
