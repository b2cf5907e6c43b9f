"""Where an object settles between soft fingers."""

import numpy as np
import pytest

from vegrip.virtual import kernels

SIDE = np.array([1.0, -1.0, -1.0])
NONE = np.zeros(3)
ONES = np.ones(3)


def forces(x, z, past=NONE, before=NONE, p=1.5):
    return [
        kernels.normal_force(past[i], 0.99, before[i], 1.2, 1e-3, p, x[i] + SIDE[i] * z) for i in range(3)
    ]


def settle(x, z=0.0, past=NONE, before=NONE, p=1.5):
    return kernels.balance(
        np.asarray(x, float), SIDE, past, 0.99 * ONES, before, 1.2 * ONES, 1e-3 * ONES, p * ONES, z
    )


@pytest.mark.parametrize("p", [1.0, 1.5, 2.5])
@pytest.mark.parametrize("start", [0.0, -3e-3, 5e-3])
def test_forces_cancel_wherever_the_search_starts(p, start) -> None:
    x = [0.0, 1e-3, 2e-3]
    N = forces(x, settle(x, start, p=p), p=p)
    assert N[0] == pytest.approx(N[1] + N[2], rel=1e-10)
    assert N[0] > 0.0


def test_untouched_object_stays() -> None:
    assert settle([-1e-3, -1e-3, -1e-3], 2e-4) == 2e-4


def test_pushed_object_moves_until_nothing_pushes_any_more() -> None:
    x = [-5e-3, 1e-3, -1e-3]
    z = settle(x, 0.0)
    assert z == pytest.approx(1e-3, abs=1e-6)
    assert sum(forces(x, z)) < 1e-6


def test_memory_of_the_material_shifts_the_balance() -> None:
    x = [0.0, 1e-3, 1e-3]
    relaxed = settle(x, past=np.array([0.0, 0.3, 0.3]), before=np.array([0.0, 0.5, 0.5]))
    assert relaxed < settle(x)
