"""Single precision: the text is rewritten token by token, and the estimator says nearly the same."""

import math

import numpy as np
import pytest

from vegrip.c99 import host
from vegrip.c99.single import HUGE, SMALLEST_FLOAT, single_literal, single_precision
from vegrip.estimator import ContactEstimator
from vegrip.estimator.kernels_c import KernelsC
from vegrip.export import Request
from vegrip.export.vectors import simulated
from vegrip.model import paper_model

needs_compiler = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")


@pytest.mark.parametrize(
    ("double", "single"),
    [
        ("double x = 1.0;", "float x = 1.0F;"),
        ("x = exp(-y) + sqrt(2e-3);", "x = expf(-y) + sqrtf(2e-3F);"),
        ("const double *m = (double)i;", "const float *m = (float)i;"),
        ("m[12] = 3 + 0x1F; /* double 1.0 */", "m[12] = 3 + 0x1F; /* double 1.0 */"),
        ('printf("double %f 1.5", .5);', 'printf("double %f 1.5", .5F);'),
        ("double exp = my_exp(1.); exp = exp + 1e3;", "float exp = my_exp(1.F); exp = exp + 1e3F;"),
        ("x > 1e-300 && x < 1e50", f"x > {SMALLEST_FLOAT!r}F && x < {HUGE!r}F"),
        ("int64_t n = 250000001LL; u = 1U;", "int64_t n = 250000001LL; u = 1U;"),
    ],
)
def test_numbers_types_and_functions_become_single_and_nothing_else(double: str, single: str) -> None:
    assert single_precision(double) == single


@pytest.mark.parametrize("value", [1e-300, -1e-300, 1e300, -1e50])
def test_a_constant_out_of_range_keeps_its_sign_and_has_a_reciprocal(value: float) -> None:
    found = np.float32(single_literal(value))
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
    assert isinstance(single._module, KernelsC)
    off = []
    for state in simulated(request):
        wanted, said = double.update(state), single.update(state)
        for name in ("normal_force", "indentation", "contact_radius", "friction_coefficient"):
            one, other = getattr(wanted, name), getattr(said, name)
            assert one.valid == other.valid
            off.append(abs(one.value - other.value) / one.std)
    assert 0.0 < max(off) < 0.02  # not the same numbers, and hardly others
