"""Reduced relaxation and creep as written in the paper."""

import numpy as np
import pytest

from vegrip.contact.prony import Creep, Relaxation
from vegrip.errors import DomainError

# t, g, h with c = 0.3, nu = 3.1 1/s
GOLDEN = np.array(
    [
        (0, 1, 1),
        (0.05, 0.956925, 1.043075),
        (0.1, 0.920034, 1.079966),
        (0.2, 0.861383, 1.138617),
        (0.5, 0.763674, 1.236326),
        (1, 0.713515, 1.286485),
        (2, 0.700609, 1.299391),
        (np.inf, 0.7, 1.3),
    ]
)


def test_relaxation_and_creep_have_the_golden_digits() -> None:
    t, g, h = GOLDEN.T
    assert Relaxation([0.3], [3.1])(t) == pytest.approx(g, abs=6e-7)
    assert Creep([0.3], [3.1])(t) == pytest.approx(h, abs=6e-7)


def test_any_number_of_branches_adds_up() -> None:
    c, nu = [0.1, 0.25, 0.05], [40.0, 2.0, 0.01]
    t = np.linspace(0, 50, 11).reshape(1, 11)
    written_out = 0.6 + sum(ci * np.exp(-ni * t) for ci, ni in zip(c, nu, strict=True))
    assert Relaxation(c, nu)(t) == pytest.approx(written_out, rel=1e-13)
    assert Relaxation(c, nu).equilibrium == pytest.approx(0.6)
    assert Creep(c, nu).equilibrium == pytest.approx(1.4)


def test_without_branches_the_contact_is_elastic() -> None:
    assert np.all(Relaxation([], [])(np.array([0.0, 1.0])) == 1)


@pytest.mark.parametrize(
    ("c", "nu"), [([0.3], []), ([-0.1], [1.0]), ([0.3], [0.0]), ([0.3], [np.inf]), ([0.6, 0.6], [1.0, 2.0])]
)
def test_a_relaxation_that_no_material_has_is_refused(c: list[float], nu: list[float]) -> None:
    with pytest.raises(DomainError):
        Relaxation(c, nu)


def test_time_before_the_step_is_refused() -> None:
    with pytest.raises(DomainError):
        Creep([0.3], [3.1])(-1e-3)


def test_amplitudes_may_sum_to_one_but_for_rounding() -> None:
    assert Relaxation([0.3, 0.7 + 5e-13], [1.0, 2.0]).equilibrium == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(DomainError, match="more than 1"):
        Relaxation([0.3, 0.7 + 1.5e-12], [1.0, 2.0])
