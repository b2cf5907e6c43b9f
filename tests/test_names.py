"""Names: a boolean reads as a question, and a constant that others import has one meaning."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1] / "vegrip"
FOLDERS = ("c99", "canopen", "cli", "identification", "transport", "web")

QUESTION = re.compile(
    r"^_*(is|are|was|has|have|had|can|may|must|should|does|needs?|wants?|uses?|takes?|knows|rounds|waits|opens"
    r"|returns|with|without|hears|fits|holds|shows|gives|moves)(_|$)"
)
PARTICIPLE = re.compile(r"(^|_)\w{2,}(ed|en|ing)(_|$)|^(found|lost|sent|shut|torn|held|kept|told|met)(_|$)")
COMMAND = re.compile(
    r"^(ask|say|keep|show|force|follow|announce|advise|refit|estimate|receive|listen|use|allow)(_|$)"
)
PUBLISHED = {
    # keys of launch files, maps, messages and files, and arguments of python-can, canopen and rich
    *(
        "fd",
        "master",
        "sender_time",
        "batch",
        "raw",
        "virtual",
        "first",
        "remote",
        "error_frames",
        "infinite",
        "required",
        "on_can",
    ),
    *("present", "stderr", "value", "recovered"),
    # options of commands, under their own names
    *(
        "as_json",
        "quick",
        "each",
        "control",
        "channel",
        "web",
        "json",
        "thorough",
        "fifo",
        "autostart",
        "spread",
    ),
}
STATEMENTS = {"by_force", "beyond", "deep"}  # that read as answers where they are used


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def booleans(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and name of each parameter and attribute that is declared as a boolean."""
    for node in ast.walk(tree):
        if isinstance(node, ast.arg) and _is_bool(node.annotation):
            yield node.lineno, node.arg
        elif isinstance(node, ast.AnnAssign) and _is_bool(node.annotation):
            target = node.target
            yield node.lineno, target.attr if isinstance(target, ast.Attribute) else ast.unparse(target)


def _is_bool(annotation: ast.expr | None) -> bool:
    return isinstance(annotation, ast.Name) and annotation.id == "bool"


def reads_as_question(name: str) -> bool:
    return name in PUBLISHED | STATEMENTS or any(
        rule.search(name) for rule in (QUESTION, PARTICIPLE, COMMAND)
    )


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_boolean_reads_as_a_question(folder: str) -> None:
    bare = [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for line, name in booleans(parsed(path))
        if not reads_as_question(name)
    ]
    assert bare == []


def test_a_bare_adjective_is_found() -> None:
    tree = ast.parse("class A:\n    fresh: bool\n    is_old: bool\n\ndef f(busy: bool, tested: bool): ...")
    assert [name for _, name in booleans(tree) if not reads_as_question(name)] == ["fresh", "busy"]


def constants(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Name and value of each constant of a module."""
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            if isinstance(target, ast.Name) and target.id.isupper() and target.id != "GROUP":
                yield target.id, ast.dump(node.value)


def imported_constants(tree: ast.Module) -> Iterator[tuple[str, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, alias.name) for alias in node.names if alias.name.isupper())


def test_a_constant_that_others_import_has_one_meaning() -> None:
    """Options of the commands are named by what is typed, and each command has its own help for them."""
    values: dict[str, dict[str, str]] = defaultdict(dict)
    imported = set()
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            tree = parsed(path)
            module = ".".join(path.relative_to(ROOT.parent).with_suffix("").parts).removesuffix(".__init__")
            imported |= set(imported_constants(tree))
            if folder != "cli":
                for name, value in constants(tree):
                    values[name][module] = value
    shared = [
        f"{name}: {', '.join(sorted(places))}"
        for name, places in sorted(values.items())
        if len(set(places.values())) > 1 and any((module, name) in imported for module in places)
    ]
    assert shared == []
