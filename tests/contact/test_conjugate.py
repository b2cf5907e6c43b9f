"""Conjugate pairs against the convolution that defines them."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from vegrip.contact.prony import Creep, Relaxation, creep_of, relaxation_of
from vegrip.errors import DomainError

PAPER = Relaxation([0.3], [3.1])
TWO = Relaxation([0.3, 0.2], [3.1, 0.25])


@st.composite
def relaxations(draw: st.DrawFn) -> Relaxation:
    shares = draw(st.lists(st.floats(0.01, 1), min_size=2, max_size=5))
    rates = draw(st.lists(st.floats(1e-2, 1e2), min_size=len(shares) - 1, max_size=len(shares) - 1))
    return Relaxation([c / sum(shares) for c in shares[:-1]], rates)


def rate_of(creep: Creep, t: float) -> float:
    return sum(c * nu * np.exp(-nu * t) for c, nu in zip(creep.amplitudes, creep.rates, strict=True))


def convolved(g: Relaxation, j: Creep, t: float) -> float:
    """``int_0^t g(t-s) dj(s)``, the step of ``j`` at zero included."""
    edges = np.unique(
        np.concatenate([[0, t], t - np.minimum(t, 1 / np.array(g.rates)), 3 / np.array(j.rates)])
    )
    edges = edges[edges <= t]
    return float(g(t)) + sum(
        quad(lambda s: float(g(t - s)) * rate_of(j, s), a, b, limit=200)[0] for a, b in pairwise(edges)
    )


def test_one_branch_has_the_closed_form() -> None:
    j = creep_of(PAPER)
    assert j.amplitudes == pytest.approx([0.428571], abs=6e-7)
    assert j.rates == pytest.approx([2.17], abs=1e-12)


def test_two_branches_have_the_golden_digits() -> None:
    j = creep_of(TWO)
    assert j.rates == pytest.approx([0.176672176, 2.193327824], abs=6e-10)
    assert j([0.5, 5, np.inf]) == pytest.approx([1.316173309, 1.751274871, 2], abs=6e-10)


def test_golden_creep_of_the_paper_relaxation() -> None:
    t = [0, 0.05, 0.1, 0.2, 0.5, 1, 2, np.inf]
    j = creep_of(PAPER)(t)
    golden = [1, 1.044066, 1.083601, 1.150895, 1.283756, 1.379638, 1.422984, 1.428571]
    assert j == pytest.approx(golden, abs=6e-7)
    golden = [1, 1.029166, 1.054985, 1.098223, 1.181195, 1.239301, 1.265125, 1.268434]
    assert j ** (2 / 3) == pytest.approx(golden, abs=6e-7)


def test_golden_rates_are_the_eigenvalues_of_the_memory_matrix() -> None:
    nu, c = np.array(TWO.rates), np.array(TWO.amplitudes)
    matrix = np.diag(nu) @ (np.eye(2) - np.outer(np.ones(2), c))
    assert np.sort(np.linalg.eigvals(matrix)) == pytest.approx([0.176672176, 2.193327824], abs=6e-10)


@pytest.mark.parametrize("g", [PAPER, TWO], ids=["one branch", "two branches"])
@pytest.mark.parametrize("t", [0.01, 0.5, 3.0, 20.0])
def test_relaxation_convolved_with_its_creep_is_one(g: Relaxation, t: float) -> None:
    assert convolved(g, creep_of(g), t) == pytest.approx(1, abs=1e-9)


@settings(max_examples=20)
@given(relaxations(), st.floats(0.01, 10))
def test_any_conjugate_pair_convolves_to_one(g: Relaxation, t: float) -> None:
    assert convolved(g, creep_of(g), t) == pytest.approx(1, abs=1e-7)


@given(relaxations(), st.floats(1e-3, 1e3))
def test_laplace_transforms_are_reciprocal(g: Relaxation, s: float) -> None:
    j = creep_of(g)
    s_g = g.equilibrium + sum(c * s / (s + nu) for c, nu in zip(g.amplitudes, g.rates, strict=True))
    s_j = 1 + sum(c * nu / (s + nu) for c, nu in zip(j.amplitudes, j.rates, strict=True))
    assert s_g * s_j == pytest.approx(1, rel=1e-9)


@given(relaxations())
def test_conjugation_undoes_itself(g: Relaxation) -> None:
    times = np.geomspace(1e-3, 1e3, 13)
    assert relaxation_of(creep_of(g))(times) == pytest.approx(g(times), abs=1e-10)


@given(relaxations())
def test_creep_grows_to_the_inverse_of_what_stays(g: Relaxation) -> None:
    j = creep_of(g)
    assert j(np.inf) == pytest.approx(1 / g.equilibrium, rel=1e-9)
    assert min(j.rates) > 0
    assert min(j.amplitudes) >= 0


def test_the_pair_of_the_paper_is_not_conjugate() -> None:
    h = Creep([0.3], [3.1])
    assert convolved(PAPER, h, 20.0) == pytest.approx(0.91, abs=1e-9)
    g = relaxation_of(h)
    assert (g.equilibrium, *g.amplitudes, *g.rates) == pytest.approx((0.769231, 0.230769, 4.03), abs=6e-7)


def test_creep_agrees_with_numerical_laplace_inversion() -> None:
    with mpmath.workdps(20):
        for t, golden in [(0.5, 1.316173309), (5, 1.751274871)]:
            transform = lambda s: 1 / (s * (0.5 + 0.3 * s / (s + 3.1) + 0.2 * s / (s + 0.25)))  # noqa: E731
            assert float(mpmath.invertlaplace(transform, t, method="talbot")) == pytest.approx(
                golden, abs=6e-10
            )


def test_a_fluid_is_refused() -> None:
    with pytest.raises(DomainError, match="falls to zero"):
        creep_of(Relaxation([0.4, 0.6], [1.0, 2.0]))


def test_elastic_contacts_are_their_own_conjugate() -> None:
    assert creep_of(Relaxation([], []))(5.0) == 1
