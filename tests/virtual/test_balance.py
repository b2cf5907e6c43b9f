"""Where an object settles between soft fingers."""

import pytest

from tests.virtual.build import tips_of
from vegrip.virtual import kernels

LIKE = {"side": [1.0, -1.0, -1.0], "instant": 0.99, "F0": 1.2, "d0": 1e-3}


def settle(x, z=0.0, p=1.5, **memory):
    """Return where the object settles, and the forces there."""
    tips = tips_of(3, position=x, p=p, **LIKE, **memory)
    z = kernels.balanced_place(tips, z)
    return z, [kernels.normal_force(tip, tip["position"] + tip["side"] * z) for tip in tips]


@pytest.mark.parametrize("p", [1.0, 1.5, 2.5])
@pytest.mark.parametrize("start", [0.0, -3e-3, 5e-3])
def test_forces_cancel_wherever_the_search_starts(p, start) -> None:
    x = [0.0, 1e-3, 2e-3]
    _, N = settle(x, start, p=p)
    assert N[0] == pytest.approx(N[1] + N[2], rel=1e-10)
    assert N[0] > 0.0


def test_untouched_object_stays() -> None:
    assert settle([-1e-3, -1e-3, -1e-3], 2e-4)[0] == 2e-4


def test_pushed_object_moves_until_nothing_pushes_any_more() -> None:
    x = [-5e-3, 1e-3, -1e-3]
    z, forces = settle(x, 0.0)
    assert z == pytest.approx(1e-3, abs=1e-6)
    assert sum(forces) < 1e-6


def test_memory_of_the_material_shifts_the_balance() -> None:
    x = [0.0, 1e-3, 1e-3]
    relaxed, _ = settle(x, past=[0.0, 0.3, 0.3], before=[0.0, 0.5, 0.5])
    assert relaxed < settle(x)[0]
