"""Every mutant is the file with one change, and those that are left out are there and have a reason."""

import ast
import importlib.util
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
_spec = importlib.util.spec_from_file_location("mutants", ROOT / "tools" / "mutants.py")
mutants = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(mutants)


def of(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    path = tmp_path / "module.py"
    path.write_text(text)
    return [one.after for one in mutants.mutants(path)]


@pytest.mark.parametrize(
    ("text", "after"),
    [
        ("a - b", ["a + b"]),
        ("a ** b", ["a * b"]),
        ("a -= b", ["a += b"]),
        ("a <<= b", ["a >>= b"]),
        ("a < b", ["a <= b", "a >= b"]),
        ("a <= b == c", ["a < b == c", "a > b == c", "a <= b != c"]),
        ("a is not b", ["a is b"]),
        ("a and b and c", ["a or b and c", "a and b or c"]),
        ("f(not a)", ["f( a)"]),
        ("-a", ["+a"]),
        ("True", ["False"]),
        ("3", ["4"]),
        ("0xFF", ["510"]),
        ("0.0", ["1.0"]),
        ("0.25", ["0.5"]),
        ("(a) * (-b)", ["(a) / (-b)", "(a) * (+b)"]),
    ],
)
def test_each_operator_comparison_boolean_and_number_is_changed_alone(
    text, after, tmp_path, monkeypatch
) -> None:
    assert of(text, tmp_path, monkeypatch) == after


def test_types_messages_and_decorators_stay(tmp_path, monkeypatch) -> None:
    text = """
@cache(size=3)
def f(a: "int | None", b: A | B) -> A | B:
    x: A | B
    raise ValueError("a - b" + str(3) + f"{a + b}")
"""
    assert of(text, tmp_path, monkeypatch) == []


def test_a_change_in_the_middle_of_a_broken_line_is_found(tmp_path, monkeypatch) -> None:
    assert of("x = (ä\n  # + and -\n  + b)", tmp_path, monkeypatch) == ["- b)"]


@pytest.mark.parametrize("folder", mutants.FOLDERS)
def test_the_mutants_of_a_folder_are_programs_and_another_one_each(folder: str) -> None:
    chosen = mutants.sample([folder], 30, 0)[folder]
    assert len({one.name for one in chosen}) == 30
    for one in chosen:
        text = (ROOT / one.path).read_bytes()
        changed = one.applied(text)
        assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(text))


def test_a_larger_sample_begins_with_the_smaller_one() -> None:
    small, large = (mutants.sample(["effects"], count, 0)["effects"] for count in (10, 20))
    assert small == large[:10]
    assert small != mutants.sample(["effects"], 10, 1)["effects"]


def test_the_nearest_tests_come_first() -> None:
    files = mutants.related("vegrip/contact/elastic.py")
    near = [
        "tests/contact/test_elastic.py",  # its own
        "tests/contact/test_history.py",  # of what imports it
        "tests/contact/test_prony.py",  # of its folder
        "tests/model/test_channels.py",  # of what else names its folder
    ]
    assert sorted(near, key=files.index) == near


def test_each_mutant_that_is_left_out_exists_and_has_a_reason() -> None:
    entries = tomllib.loads(mutants.EQUIVALENT.read_text())
    files = {name.split(" | ")[0] for name in entries}
    names = {one.name for file in files for one in mutants.mutants(ROOT / file)}
    assert entries.keys() - names == set(), "no such mutant (any more)"
    assert all(len(reason.split()) > 3 for reason in entries.values())
