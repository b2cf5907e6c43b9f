"""Single precision is a kind of the translator, and the estimator says nearly the same in it."""

import math
import re

import numpy as np
import pytest

from vegrip.c99 import host, translate
from vegrip.c99.kinds import DOUBLE, FLOAT, INT, MEMORY, REAL
from vegrip.c99.literals import HUGE, SMALLEST_FLOAT, in_range
from vegrip.estimator import ContactEstimator
from vegrip.export import Request
from vegrip.export.estimator import simulated
from vegrip.model import paper_model
from vegrip.model.native import ModuleC

needs_compiler = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")


TEXT = """
import math
LIMITS = (0.5, -2.0, 1e-300)
MOST = 1e50
def f(x, n, m):
    m[n] = x > 0.0
    y = n / 3
    if x < MOST:
        y = max(x, math.exp(-LIMITS[0])) + math.floor(x) + abs(round(x) * 2.5)
    return x ** 3, y, float(n), math.nan
"""


IN_FLOATS = {
    "double": "float", "0.0": "0.0F", "0.5": "0.5F", "2.0": "2.0F", "2.5": "2.5F", "1.0": "1.0F",
    "1e-300": f"{SMALLEST_FLOAT!r}F", "1e+50": f"{HUGE!r}F", "2147483648.0": "2147483648.0F",
    "exp": "expf", "floor": "floorf", "fabs": "fabsf", "rint": "rintf",
}  # fmt: skip
TOKEN = re.compile(r"/\*.*?\*/|\d+\.?\d*(?:e[+-]?\d+)?F?|\w+|\S")


def test_numbers_types_and_functions_become_single_and_nothing_else() -> None:
    double, single = (
        TOKEN.findall(translate(TEXT, {"f": (REAL, INT, MEMORY)}, reals=reals).text())
        for reals in (DOUBLE, FLOAT)
    )
    assert [IN_FLOATS.get(token, token) for token in double] == single
    assert set(double) >= IN_FLOATS.keys()


@pytest.mark.parametrize("value", [1e-300, -1e-300, 1e300, -1e50])
def test_a_constant_out_of_range_keeps_its_sign_and_has_a_reciprocal(value: float) -> None:
    found = np.float32(in_range(value))
    assert math.isfinite(found)
    assert math.isfinite(np.float32(1.0) / found)
    assert np.sign(found) == np.sign(value)


@needs_compiler
def test_in_single_precision_the_estimates_move_by_a_small_part_of_their_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    request = Request(paper_model(8e-3), frames=500)
    monkeypatch.setenv("VEGRIP_KERNEL", "c")
    double = ContactEstimator(request.model, request.noise)
    monkeypatch.setenv("VEGRIP_KERNEL", "c-float")
    single = ContactEstimator(request.model, request.noise)
    assert isinstance(single._module, ModuleC)
    off = []
    for state in simulated(request):
        wanted, said = double.update(state), single.update(state)
        for name in ("normal_force", "indentation", "contact_radius", "friction_coefficient"):
            one, other = getattr(wanted, name), getattr(said, name)
            assert one.valid == other.valid
            off.append(abs(one.value - other.value) / one.std)
    assert 0.0 < max(off) < 0.02  # not the same numbers, and hardly others
