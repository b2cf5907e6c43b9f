"""The virtual hand must not be a mirror of what it tests."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import vegrip.virtual

SOURCES = sorted(Path(vegrip.virtual.__file__).parent.rglob("*.py"))
PLAIN = {"clock", "compiled", "config", "errors", "hand_sample", "messages", "types", "virtual"}


def imported(source: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.name)
def test_no_physics_is_imported_from_the_rest_of_the_package(source: Path) -> None:
    ours = {name.split(".")[1] for name in imported(source) if name.startswith("vegrip.")}
    assert ours <= PLAIN


def test_using_the_hand_loads_none_of_the_contact_model() -> None:
    code = (
        "import sys; from vegrip.virtual import VirtualHand; VirtualHand().step(0.01, {}); "
        "print([m for m in sys.modules if m.startswith(('vegrip.contact', 'vegrip.effects', "
        "'vegrip.model', 'vegrip.estimator'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
