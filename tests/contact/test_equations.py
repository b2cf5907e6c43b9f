"""docs/theory.md says where each equation of the paper is; the code there says so too."""

import importlib
import inspect
import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "theory.md"
ROW = re.compile(r"^\* (\([^:]*\)): `([\w.]+)`$", re.MULTILINE)
SPAN = re.compile(r"\((\d+)\)(?:-\((\d+)\))?")


def numbers(text: str) -> set[int]:
    """Equations in a text: ``(2), (18)-(20)`` are 2, 18, 19, 20."""
    return {n for a, b in SPAN.findall(text) for n in range(int(a), int(b or a) + 1)}


INDEX = [(numbers(equations), place) for equations, place in ROW.findall(PAGE.read_text(encoding="utf-8"))]


def test_every_equation_of_the_paper_is_somewhere() -> None:
    assert set().union(*(found for found, _ in INDEX)) == set(range(1, 66))


def test_the_equations_that_a_model_runs_lead_to_its_effects() -> None:
    running = set().union(*(found for found, place in INDEX if place.startswith("vegrip.effects.")))
    assert running >= {14, 15, 20, 32, 34, 36}


@pytest.mark.parametrize(("equations", "place"), INDEX, ids=[place for _, place in INDEX])
def test_the_code_names_the_equations_it_is(equations: set[int], place: str) -> None:
    module_name, name = place.rsplit(".", 1)
    module = importlib.import_module(module_name)
    assert getattr(module, name)
    assert equations <= numbers(inspect.getsource(module))
