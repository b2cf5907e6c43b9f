"""The same text as Python, numba and C."""

import ctypes
import math
import textwrap
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from vegrip.c99 import MEMORY, host, translate

Floats = np.ndarray
Run = Callable[..., tuple[list[float], list[float]]]


@pytest.fixture
def in_c(tmp_path: Path) -> Callable[..., Callable[[Floats], None]]:
    """Compile ``entry(m)`` of a text in C."""
    if host.compiler() is None:
        pytest.skip("no C compiler")

    def made(text: str) -> Callable[[Floats], None]:
        program = translate(textwrap.dedent(text), {"entry": (MEMORY,)})
        library = tmp_path / f"{len(list(tmp_path.iterdir()))}.so"
        strict = ("-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror")
        host.build(program.text(), library, (*(f for f in host.FLAGS if f != "-w"), *strict))
        function = host.load(library).vg_entry
        function.argtypes, function.restype = [ctypes.c_void_p], None
        return lambda m: function(m.ctypes.data)

    return made


@pytest.fixture
def both(in_c: Callable[..., Callable[[Floats], None]]) -> Run:
    """Run ``entry(m)`` compiled by numba and by C; return both memories afterwards."""
    made: dict[str, tuple[Callable[[Floats], None], Callable[[Floats], None]]] = {}

    def run(text: str, m: list[float]) -> tuple[list[float], list[float]]:
        if text not in made:
            made[text] = (by_numba(text), in_c(text))
        memories = [np.array(m, dtype=float) for _ in made[text]]
        for entry, memory in zip(made[text], memories, strict=True):
            entry(memory)
        return memories[0].tolist(), memories[1].tolist()

    return run


def by_numba(text: str) -> Callable[[Floats], None]:
    scope: dict[str, Any] = {"math": math, "np": np}
    exec(textwrap.dedent(text), scope)  # noqa: S102 (written here)
    functions = [name for name, value in scope.items() if isinstance(value, types.FunctionType)]
    scope.update({name: numba.njit(error_model="numpy")(scope[name]) for name in functions})
    entry: Callable[[Floats], None] = scope["entry"]
    return entry
