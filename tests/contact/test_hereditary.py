"""The recursion against the hereditary integral: by adaptive quadrature, and as a differential equation."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from vegrip.contact.creep import elastic_force, paper_indentation
from vegrip.contact.elastic import PowerStiffness
from vegrip.contact.hereditary import advance, drive, filtered, hereditary_force
from vegrip.contact.prony import Creep, Relaxation
from vegrip.errors import DomainError

G = Relaxation([0.2, 0.15, 0.1], [30.0, 2.0, 0.05])


@st.composite
def histories(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Times with steps from 10 us to 10 s, some of them zero (jumps), and elastic forces."""
    steps = draw(st.lists(st.one_of(st.just(0.0), st.floats(1e-5, 10)), min_size=1, max_size=12))
    forces = draw(st.lists(st.floats(0, 20), min_size=len(steps) + 1, max_size=len(steps) + 1))
    return np.cumsum([3.0, *steps]), np.array(forces)


def integral(g: Relaxation | Creep, t: np.ndarray, x: np.ndarray) -> float:
    """``int g(T-s) dx(s)`` at the last time ``T``: quadrature over each straight piece, jumps added."""
    end = t[-1]
    total = x[0] * float(g(end - t[0]))
    for (t0, t1), (x0, x1) in zip(pairwise(t), pairwise(x), strict=True):
        if t1 == t0:
            total += (x1 - x0) * float(g(end - t0))
        else:
            mean, _ = quad(lambda s: float(g(end - s)), t0, t1, epsabs=1e-12, limit=200)
            total += (x1 - x0) / (t1 - t0) * mean
    return total


@settings(max_examples=40)
@given(histories())
def test_recursion_equals_the_hereditary_integral(history: tuple[np.ndarray, np.ndarray]) -> None:
    t, x = history
    assert hereditary_force(t, x, G)[-1] == pytest.approx(integral(G, t, x), rel=1e-9, abs=1e-9)


@settings(max_examples=20)
@given(histories())
def test_paper_creep_equals_its_integral(history: tuple[np.ndarray, np.ndarray]) -> None:
    t, x = history
    h = Creep([0.3, 0.1], [3.1, 0.2])
    crept = paper_indentation(t, x, PowerStiffness(1.0, 0.0), h)
    assert crept[-1] == pytest.approx(integral(h, t, x), rel=1e-9, abs=1e-9)


@given(histories())
def test_memories_solve_their_differential_equation(history: tuple[np.ndarray, np.ndarray]) -> None:
    t, x = history
    memory = np.zeros(3)
    for (t0, t1), (x0, x1) in zip(pairwise(t), pairwise(x), strict=True):
        before = memory.copy()
        advance(memory, x0, x1, t1 - t0, np.array(G.amplitudes), np.array(G.rates))
        for rate, z0, z1 in zip(G.rates, before, memory, strict=True):
            if 0 < rate * (t1 - t0) < 5:
                slope = (x1 - x0) / (t1 - t0)
                exact = x1 - slope / rate + (z0 - x0 + slope / rate) * np.exp(-rate * (t1 - t0))
                assert z1 == pytest.approx(exact, rel=1e-7, abs=1e-7 * abs(slope) / rate + 1e-9)


def test_recursion_equals_a_stiff_solver_on_a_smooth_history() -> None:
    t = np.linspace(0, 4, 4001)
    N_e = 2 + np.sin(2 * t) - 2 * np.cos(t)
    rates = np.array(G.rates)
    start = np.zeros(3)
    exact = solve_ivp(
        lambda s, z: rates * (2 + np.sin(2 * s) - 2 * np.cos(s) - z),
        (0, 4),
        start,
        t_eval=t,
        rtol=1e-10,
        atol=1e-12,
    )
    assert hereditary_force(t, N_e, G) == pytest.approx(N_e - np.array(G.amplitudes) @ exact.y, abs=2e-6)


@given(histories(), st.integers(2, 7))
def test_more_samples_of_the_same_line_change_nothing(history: tuple[np.ndarray, np.ndarray], n: int) -> None:
    t, x = history
    t, first = np.unique(t, return_index=True)  # jumps cannot be resampled
    x = x[first]
    fine = np.unique(np.concatenate([np.linspace(a, b, n) for a, b in pairwise(t)] or [t]))
    resampled = hereditary_force(fine, np.interp(fine, t, x), G)
    assert resampled[np.searchsorted(fine, t)] == pytest.approx(hereditary_force(t, x, G), rel=1e-8, abs=1e-8)


@given(histories(), st.floats(1e-6, 1e6))
def test_the_recursion_is_linear_in_the_history(history: tuple[np.ndarray, np.ndarray], scale: float) -> None:
    t, x = history
    assert hereditary_force(t, scale * x, G) == pytest.approx(scale * hereditary_force(t, x, G), rel=1e-11)


@given(histories())
def test_time_has_no_origin(history: tuple[np.ndarray, np.ndarray]) -> None:
    t, x = history
    exact_shift = 2.0**20
    t = np.round(t * 2**20) / 2**20
    assert np.array_equal(hereditary_force(t + exact_shift, x, G), hereditary_force(t, x, G))


@given(histories(), st.floats(0, 50))
def test_drive_undoes_advance(history: tuple[np.ndarray, np.ndarray], wanted: float) -> None:
    t, x = history
    c, nu = np.array(G.amplitudes), np.array(G.rates)
    memory = np.array([1.0, 0.3, 0.1])
    x1 = drive(memory, x[0], wanted, t[1] - t[0], c, nu)
    assert advance(memory, x[0], x1, t[1] - t[0], c, nu) == pytest.approx(wanted, abs=1e-10)


@settings(max_examples=20)
@given(histories())
def test_imposed_load_equals_the_integral_over_the_conjugate(history: tuple[np.ndarray, np.ndarray]) -> None:
    t, N = history
    j = Creep([3 / 7], [2.17])  # closed form for one branch
    g = Relaxation([0.3], [3.1])
    assert elastic_force(t, N, g)[-1] == pytest.approx(integral(j, t, N), rel=1e-9, abs=1e-9)


def test_steps_far_below_and_far_above_the_relaxation_time_keep_their_digits() -> None:
    for dt in (1e-12, 1e12):
        t = np.array([0, dt])
        force = hereditary_force(t, [0.0, 1.0], Relaxation([0.3], [1.0]))[1]
        assert force == pytest.approx(1 if dt < 1 else 0.7, abs=1e-11)


def test_many_contacts_are_filtered_at_once() -> None:
    t = np.linspace(0, 1, 20)
    x = np.random.default_rng(5).uniform(0, 1, (2, 3, 20))
    together = hereditary_force(t, x, G)
    assert together.shape == x.shape
    assert np.array_equal(together[1, 2], hereditary_force(t, x[1, 2], G))


@pytest.mark.parametrize(
    ("t", "x"),
    [
        ([0, 1, 0.5], [0, 1, 2]),
        ([0, 1], [0, np.nan]),
        ([0, np.inf], [0, 1]),
        ([0, 1], [1, 2, 3]),
        ([[0, 1]], [0, 1]),
        ([[0, 1], [2, 3]], [0, 1]),
    ],
)
def test_a_history_that_cannot_be_is_refused(t: list[float], x: list[float]) -> None:
    with pytest.raises(DomainError):
        filtered(t, x, [0.3], [1.0])
