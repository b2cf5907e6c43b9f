"""What a user types: every public name is there, and nothing is imported before it is asked for."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import vegrip

COUNT = """
import sys
before = set(sys.modules)
import vegrip
print(*sorted(set(sys.modules) - before))
"""
LIGHT = 60
"""Modules of the standard library at most; ``typing`` and ``importlib`` alone bring some twenty."""


def fresh(program: str) -> str:
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return done.stdout


def test_importing_the_package_imports_nothing_else() -> None:
    brought = fresh(COUNT).split()
    foreign = [name for name in brought if name.partition(".")[0] not in sys.stdlib_module_names]
    assert foreign == ["vegrip"]
    assert len(brought) <= LIGHT, brought


@pytest.mark.parametrize("name", vegrip.__all__)
def test_every_public_name_is_there_and_says_what_it_is_for(name: str) -> None:
    found = getattr(vegrip, name)
    assert name in dir(vegrip)
    assert isinstance(found, str) or found.__doc__


def test_the_names_that_type_checkers_see_are_those_that_are_found() -> None:
    assert set(vegrip.__all__) == {*vegrip._PLACES, "__version__"}


def test_a_name_that_is_not_public_is_not_there() -> None:
    with pytest.raises(AttributeError, match="module 'vegrip' has no attribute 'GraspForce'"):
        vegrip.GraspForce  # noqa: B018


def test_the_type_checker_knows_every_public_name() -> None:

    tree = ast.parse(Path(vegrip.__file__).read_text(encoding="utf-8"))
    guarded = next(node for node in tree.body if isinstance(node, ast.If))
    seen = {
        alias.name: node.module
        for node in guarded.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert seen == vegrip._PLACES


SLOW = """
import sys
import vegrip.demo.command, vegrip.nodes.grasp_force, vegrip.nodes.virtual_hand
print("scipy.optimize" in sys.modules, "scipy.integrate" in sys.modules, "numba" in sys.modules)
import vegrip.identification.experiment, vegrip.trials.fronts
print("scipy.stats" in sys.modules)
"""


def test_no_program_pays_for_the_start_of_what_it_does_not_use() -> None:
    """Each takes 0.2 s of processor time in every process; ``scipy.special`` has the few functions."""
    assert fresh(SLOW).split() == ["False"] * 4
