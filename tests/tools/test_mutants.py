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
    chosen = mutants.sample([folder], 10, 0)[folder]
    assert len({one.name for one in chosen}) == 10
    for one in chosen:
        text = (ROOT / one.path).read_bytes()
        changed = one.applied(text)
        assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(text))


def test_a_larger_sample_begins_with_the_smaller_one() -> None:
    small, large = (mutants.sample(["effects"], count, 0)["effects"] for count in (10, 20))
    assert small == large[:10]
    assert small != mutants.sample(["effects"], 10, 1)["effects"]


def test_files_that_are_left_out_have_no_mutants() -> None:
    chosen = mutants.sample(["contact/creep.py", "contact/geometry.py"], 10, 0, ["contact/c*.py"])
    assert [len(some) for some in chosen.values()] == [0, 5]


def test_the_nearest_tests_come_first() -> None:
    assert mutants.related("vegrip/grip/safety/__init__.py")[mutants.DECLARED] == 0
    far = mutants.related("vegrip/contact/elastic.py")
    assert mutants.DECLARED not in far
    near = [
        "tests/contact/test_elastic.py",  # its own
        "tests/contact/test_history.py",  # that imports it
        "tests/contact/test_coupling.py",  # of its folder
        "tests/model/test_channels.py",  # of what else names its folder
    ]
    assert [far[file] for file in near] == [0, 1, 2, 4]
    assert list(far.values()) == sorted(far.values())
    assert mutants.related("vegrip/grip/kernels/choice.py")["tests/grip/policies/test_baselines.py"] == 1
    assert mutants.related("vegrip/estimator/kernels/sense.py")["tests/grip/kernels/test_control.py"] == 3


def test_each_mutant_that_is_left_out_exists_and_has_a_reason() -> None:
    entries = tomllib.loads(mutants.EQUIVALENT.read_text())
    files = {name.split(" | ")[0] for name in entries}
    names = {one.name for file in files for one in mutants.mutants(ROOT / file)}
    assert entries.keys() - names == set(), "no such mutant (any more)"
    assert all(len(reason.split()) > 3 for reason in entries.values())


@pytest.mark.parametrize(
    ("line", "reached"),
    [
        ("        return a - LIMIT", {"vegrip/a.py:C.m"}),
        ("LIMIT = 2 * BASE", {"vegrip/a.py:C.m", "vegrip/b.py:f"}),
        ("BASE = 3", {"vegrip/a.py:C.m", "vegrip/b.py:f"}),
        ("    part: int = 7", {"vegrip/b.py:f"}),
    ],
)
def test_a_change_is_seen_by_the_functions_that_it_is_in_or_that_take_it(
    line, reached, tmp_path, monkeypatch
) -> None:
    files = {
        "vegrip/a.py": "BASE = 3\nLIMIT = 2 * BASE\nclass C:\n    part: int = 7\n    def m(self, a):\n"
        "        return a - LIMIT\n",
        "vegrip/b.py": "from vegrip.a import LIMIT, C\ndef f(x):\n    return C().part + LIMIT\n"
        "def g(x):\n    return x\n",
    }
    monkeypatch.setattr(mutants, "texts", lambda _: files)
    mutants.named_in.cache_clear()
    number = files["vegrip/a.py"].splitlines().index(line) + 1
    mutant = mutants.Mutant("vegrip/a.py", 0, 1, "", number, line, "", 0)
    assert mutants.functions_with(mutant) == reached
    mutants.named_in.cache_clear()


@pytest.mark.long
def test_a_mutant_meets_the_quickest_test_that_enters_it_and_one_without_end_is_noticed_by_time(
    tmp_path, monkeypatch
) -> None:
    """A project of one file; a test that fails without a change notices none."""
    law = """
def down(n):
    while n > 0:
        n = n - 1
    return n

def other(n):
    return n + 2

def unseen(n):
    return n * 3

MOST = 7
"""
    tests = """
import time
from vegrip.part import law

def test_slow():
    time.sleep(0.3)
    assert law.down(3) == 0

def test_quick():
    assert law.down(2) == 0

def test_other():
    assert law.other(1) == 3

def test_broken():
    assert law.unseen(1) == 4

def test_constant():
    assert law.MOST == 7
"""
    packages = dict.fromkeys(("vegrip/__init__.py", "vegrip/part/__init__.py"), "")
    texts = packages | {"vegrip/part/law.py": law, "tests/part/test_law.py": tests}
    texts["pyproject.toml"] = '[tool.pytest.ini_options]\naddopts = "--import-mode=importlib"\n'
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    for name, value in {"ROOT": tmp_path, "WORK": tmp_path / "build", "SLACK_S": 1.0}.items():
        monkeypatch.setattr(mutants, name, value)
    monkeypatch.setattr(mutants, "RESULTS", tmp_path / "build" / "results.jsonl")
    (tmp_path / "build" / "records").mkdir(parents=True)
    for function in (mutants.texts, mutants.related, mutants.users_of, mutants._imports, mutants._mirror):
        function.cache_clear()
    every = {one.after: one for one in mutants.mutants(tmp_path / "vegrip/part/law.py")}
    with mutants.Round(1, 60.0, 2, 60.0) as the_round:
        chosen = [one.name.partition("::")[2] for one in the_round.records.choose(every["n = n + 1"], [0])]
        assert chosen[:2] == ["test_quick", "test_slow"]
        results = {
            change: the_round.run(every[change])
            for change in ("while n <= 0:", "n = n + 1", "return n + 3", "return n / 3", "MOST = 8")
        }
        the_round.seconds = 0.0  # no time for any test
        results["late"] = the_round.run(every["return n + 3"])
    assert list(results.values()) == ["killed", "timeout", "killed", "survived", "killed", "no answer"]
    for function in (mutants.texts, mutants.related, mutants.users_of, mutants._imports, mutants._mirror):
        function.cache_clear()
