"""What others need to know of an effect stands in its file: generic code names no effect."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import vegrip
from vegrip.effects import BUILT_IN, effect

PACKAGE = Path(vegrip.__file__).parent
OWN = {
    "effects": "the effects",
    "virtual": "the simulators have physics and names of their own",
    "model/model.py": "the paper's model, which is a list of effects",
    "identification/samples": "a sample recording, in which an effect is hidden",
}
"""Files and folders that are about certain effects."""

OTHER_WORDS = {
    ("model/writer.py", "adhesion"): "a quantity of the recursion",
    ("transport/mapped/guess.py", "rolling"): "a rolling counter of frames",
}
"""Texts that mean something else."""


def named_effects() -> Iterator[tuple[str, int, str]]:
    """Yield file, line and text of every text in generic code that is the name of an effect."""
    for path in sorted(PACKAGE.rglob("*.py")):
        file = path.relative_to(PACKAGE).as_posix()
        if any(file == own or file.startswith(f"{own}/") for own in OWN):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            named = isinstance(node, ast.Constant) and node.value in BUILT_IN
            if named and (file, node.value) not in OTHER_WORDS:
                yield file, node.lineno, str(node.value)


def test_generic_code_names_no_effect() -> None:
    assert list(named_effects()) == []


@pytest.mark.parametrize("name", BUILT_IN)
def test_what_an_effect_says_of_itself_is_about_itself(name: str) -> None:
    one = effect(name)
    symbols = {p.symbol for p in one.parameters}
    amounts = {p.symbol for p in one.parameters if p.null is not None}
    assert {symbol for symbol, _ in (*one.min_amounts, *one.min_displacement_noises)} <= amounts
    assert {symbol for symbol, _ in one.trial_shapes} <= symbols - amounts
    for _, values in one.trial_shapes:
        assert all(value > 0.0 for value in values)
    assert all(size > 0.0 for size in one.trial_sizes)
    one.imitated_by.format(**dict.fromkeys(symbols, 1.0), radius=8e-3)


@pytest.mark.parametrize("name", BUILT_IN)
def test_companions_name_each_other(name: str) -> None:
    for other in effect(name).companions:
        assert name in effect(other).companions
