"""The solver by itself, on a law with a known answer that overflows a long step away from it."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from vegrip.identification.fit import solve
from vegrip.identification.fit.problem import AT, Problem, Unknowns
from vegrip.identification.fit.solve import Optimum, covariance, refine_optimum, scaled, starting_points
from vegrip.types import Floats

X = np.linspace(0.0, 1.0, 50)
RATE = 3.0


class Exponential(Problem):
    """y = exp(exp(u) x): a full step from the flat side of it ends beyond 1e200."""

    def __init__(self) -> None:
        self.unknowns = Unknowns(
            names=("rate",),
            log=np.array([True]),
            place=np.array([0]),
            start=np.array([-2.0]),
            low=np.array([-9.0]),
            high=np.array([9.0]),
            prior=np.array([0.0]),
            std=np.array([10.0]),
        )
        self.largest = 0.0

    def residual(self, u: Floats) -> Floats:
        with np.errstate(over="ignore"):
            r = np.exp(np.minimum(np.exp(u[0]) * X, 500.0)) - np.exp(RATE * X)
        self.largest = max(self.largest, float(np.abs(r).max()))
        return np.asarray(r, dtype=np.float64)


def test_a_step_into_overflow_is_refused_and_the_optimum_is_found_all_the_same() -> None:
    problem = Exponential()
    found = refine_optimum(problem, problem.unknowns.start, 60)
    assert problem.largest > 1e160  # the step was taken, and its cost overflows
    assert abs(np.exp(found.u[0]) - RATE) < 0.01


RNG = np.random.default_rng(6)


def unknowns(low, high, std, names=("a", "b", "c"), start=0.0, prior=0.1) -> Unknowns:
    n = len(names)
    return Unknowns(names, np.zeros(n, bool), np.arange(n), np.full(n, start), np.full(n, low),
                    np.full(n, high), np.full(n, prior), np.array(std))  # fmt: skip


@pytest.mark.parametrize("bound", [9.0, 0.3, 0.05])
def test_a_step_without_damping_is_that_of_bounded_least_squares(bound) -> None:
    k, J, r = unknowns(-bound, bound, [0.5, 1.0, 2.0]), RNG.normal(size=(20, 3)), RNG.normal(size=20)
    u = np.clip([0.02, -0.05, 0.04], -bound, bound)
    step, foretold = solve._step(k, u, J.T @ r, J.T @ J, 0.0)
    wide = np.vstack([J, np.diag(1.0 / k.std)])
    left = np.append(r, (u - k.prior) / k.std)
    exact = lsq_linear(wide, -left, (k.low - u - 1e-15, k.high - u + 1e-15), tol=1e-14)
    assert step == pytest.approx(exact.x, abs=1e-6)
    assert foretold == pytest.approx(0.5 * (left @ left) - exact.cost, abs=1e-6)


def test_damping_shortens_a_step_by_the_diagonal() -> None:
    k, J, r = unknowns(-9.0, 9.0, [0.5, 1.0, 2.0]), RNG.normal(size=(20, 3)), RNG.normal(size=20)
    A, g = J.T @ J + np.diag(k.std**-2.0), J.T @ r - 0.1 / k.std**2
    step, foretold = solve._step(k, np.zeros(3), J.T @ r, J.T @ J, 0.7)
    assert step == pytest.approx(-np.linalg.solve(A + 0.7 * np.diag(np.diag(A)), g))
    assert foretold == pytest.approx(-g @ step - 0.5 * step @ A @ step)


class Line(Problem):
    """Residuals that are linear but for one bend, and that count how often they are asked for."""

    def __init__(self, bend: float) -> None:
        self.unknowns, self.bend, self.asked, self.derived = unknowns(-9.0, 9.0, [9.0] * 3), bend, 0, 0
        self.columns, self.y = RNG.normal(size=(30, 3)), RNG.normal(size=30)

    def residual(self, u):
        self.asked += 1
        return self.y - self.columns @ u + self.bend * np.sin(3.0 * u[0]) * self.columns[:, 0]

    def jacobian(self, u, _residual=None, known=None):
        self.derived += 1
        out = -self.columns.copy()
        out[:, 0] += 3.0 * self.bend * np.cos(3.0 * u[0]) * self.columns[:, 0]
        for j, name in enumerate(self.unknowns.names):
            if known is not None and name in known:
                out[:, j] = known[name]
        return out


@pytest.mark.parametrize("bend", [0.0, 0.2])
@pytest.mark.parametrize("known", [False, True])
def test_the_optimum_has_no_gradient_and_its_own_residual_cost_and_derivatives(bend, known) -> None:
    problem = Line(bend)
    given = {"b": -1.3 * problem.columns[:, 1]} if known else None  # as it was elsewhere
    found = refine_optimum(problem, np.full(3, 0.5), 60, given)
    k = problem.unknowns
    assert found.residual == pytest.approx(problem.residual(found.u))
    exact = problem.jacobian(found.u)
    assert found.jacobian.T @ found.jacobian == pytest.approx(exact.T @ exact, rel=0.2, abs=0.5)
    assert exact.T @ found.residual + (found.u - k.prior) / k.std**2 == pytest.approx(np.zeros(3), abs=0.02)
    away = (found.u - k.prior) / k.std
    assert found.cost == pytest.approx(0.5 * (found.residual @ found.residual + away @ away))
    if not bend and not known:
        assert problem.derived <= 3  # of which one is of this test
        assert problem.asked <= 6


@pytest.mark.parametrize("bend", [0.0, 0.2])
def test_a_fit_that_can_come_below_what_is_asked_is_as_if_nothing_were_and_another_given_up_at_once(
    bend,
) -> None:
    problem, start = Line(bend), np.full(3, 0.5)
    free = refine_optimum(problem, start, 60)
    asked = problem.asked
    reached = refine_optimum(problem, start, 60, least=free.cost)
    assert (reached.u == free.u).all()
    assert (reached.jacobian == free.jacobian).all()
    problem.asked = 0
    given_up = refine_optimum(problem, start, 60, least=-1e9)
    assert given_up.cost > -1e9
    assert problem.asked < asked


@pytest.mark.parametrize("scale", [1.0, 1e6, 1e150])
def test_a_correction_of_the_derivatives_corrects_their_square_though_most_of_it_cancels(scale) -> None:
    J, along = RNG.normal(size=(20, 3)), np.array([1.0, 0.0, 0.5])
    far = J + np.outer(scale * np.ones(20), along)
    new, square = solve._corrected(far, far.T @ far, -scale * np.ones(20), along)
    assert new == pytest.approx(far - scale * np.outer(np.ones(20), along))
    assert square == pytest.approx(new.T @ new, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("size", [1.0, 3.0])
def test_the_covariance_is_wider_where_more_than_noise_is_left(size) -> None:
    """By the misfit of what counts, and never narrower."""
    J, r = RNG.normal(size=(40, 3)), np.r_[size * np.ones(30), np.zeros(10)]
    k = unknowns(-9.0, 9.0, [0.5, 1.0, 2.0])
    problem = SimpleNamespace(unknowns=k, counted=np.arange(40) < 30)
    told = covariance(problem, Optimum(np.zeros(3), r, J, 0.0))
    assert told == pytest.approx(np.linalg.inv(J.T @ J / max(size**2, 1.0) + np.diag(k.std**-2.0)))
    small = covariance(problem, Optimum(np.zeros(3), 0.1 * r, J, 0.0))
    assert small == pytest.approx(np.linalg.inv(J.T @ J + np.diag(k.std**-2.0)))


def stiff(factor: float, names=("K", "nu1", "c")):
    """Return a problem whose force is K times a shape, and measured so many times as large."""
    shape = RNG.uniform(0.5, 1.5, 20)

    def table(u):
        out = np.zeros((20, len(AT)))
        out[:, AT["normal_force"]] = np.exp(u[0]) * shape
        return out

    force = factor * shape
    force[3] = np.nan
    k = unknowns(-3.0, 3.0, [1.0] * len(names), names)
    return SimpleNamespace(unknowns=k, measured=SimpleNamespace(force=force), table=table)


def test_a_fit_begins_with_forces_as_large_as_measured_and_rates_a_decade_apart() -> None:
    problem = stiff(2.5)
    assert scaled(problem, np.array([0.4, 1.0, 1.0])) == pytest.approx([np.log(2.5), 1.0, 1.0])
    assert scaled(stiff(-2.5), np.zeros(3)) == pytest.approx([0.0, 0.0, 0.0])  # of the wrong sign
    assert scaled(stiff(2.5, ("p", "nu1", "c")), np.zeros(3)) == pytest.approx([0.0] * 3)
    starts = starting_points(problem)
    assert [one[1] for one in starts] == pytest.approx([-np.log(10.0), 0.0, np.log(10.0)])
    assert [one[0] for one in starts] == pytest.approx([np.log(2.5)] * 3)
    assert len(starting_points(stiff(2.5, ("K", "p", "c")))) == 1
    assert starting_points(stiff(1e9))[0][0] == 3.0  # within the bounds


def test_the_cost_is_that_of_the_residual_even_after_a_start_that_nearly_overflows() -> None:
    found = refine_optimum(Exponential(), np.array([5.1]), 60)
    assert found.cost >= 0.5 * float(found.residual @ found.residual) > 0.0
