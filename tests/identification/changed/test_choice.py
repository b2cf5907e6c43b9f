"""The choice among sets, on costs that are known: what is sure, what is not, and how many of which."""

import math
from typing import Any

import numpy as np
import pytest

from vegrip.identification.changed.choice import Choice, chance, choose


class Known:
    """A pair of which the differences are seen directly, some only in sum: ``cost = |A d - y|^2 / 2``."""

    def __init__(self, A: list[list[float]], y: list[float]) -> None:
        self.A, self.y = np.array(A), np.array(y)
        self.questions = tuple(range(self.A.shape[1]))
        self.w, self.G, self.h = np.zeros(self.A.shape[1]), self.A.T @ self.A, self.A.T @ self.y

    def solved(self, chosen: tuple[int, ...]) -> tuple[Any, float]:
        w = np.zeros(self.w.size)
        if chosen:
            w[list(chosen)] = np.linalg.lstsq(self.A[:, chosen], self.y, rcond=None)[0]
        return w, 0.5 * float(np.sum((self.A @ w - self.y) ** 2) - self.y @ self.y)

    def cost(self, chosen: tuple[int, ...]) -> float:
        return self.solved(chosen)[1]

    def move(self, w: Any) -> None:
        self.w = w


def chosen(A: list[list[float]], y: list[float]) -> Choice:
    return choose(Known(A, y))  # type: ignore[arg-type]


def test_noise_chooses_nothing() -> None:
    y = np.random.default_rng(0).standard_normal(6)
    found = chosen(np.eye(6).tolist(), y.tolist())
    assert (found.best, found.rivals, found.unsure) == ((), ((),), [])


def test_what_is_seen_by_itself_is_sure() -> None:
    found = chosen(np.eye(3).tolist(), [0.3, 20.0, -9.0])
    assert found.best == found.sure == (1, 2)


def test_two_that_do_the_same_are_one_set_beside_what_is_sure() -> None:
    found = chosen([[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [20.0, 15.0])
    assert found.sure == (2,)
    assert found.unsure == [(1, (0, 1))]


def test_two_sets_of_which_each_has_one_stay_apart() -> None:
    found = chosen([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]], [20.0, 15.0])
    assert found.sure == ()
    assert found.unsure == [(1, (0, 1)), (1, (2, 3))]


def test_of_three_that_any_two_explain_two_are_said_to_be_there() -> None:
    found = chosen([[1.0, 0.0, 1.0], [0.0, 1.0, -1.0]], [20.0, 15.0])  # as stiffness, friction and a gain
    assert found.unsure == [(2, (0, 1, 2))]


def test_two_that_hide_each_other_show_together() -> None:
    almost = [[1.0, 1.0, 0.0], [0.1, -0.1, 0.0], [0.0, 0.0, 1.0]]
    found = chosen(almost, [0.0, 8.0, 0.0])  # each by itself makes ten times what it explains
    assert found.best == (0, 1)


def test_the_chance_is_that_of_chi_square_over_all_questions() -> None:
    assert chance(0.5 * 3.841459, 1, 1) == pytest.approx(0.05, rel=1e-5)  # the table's 95 % of one
    assert chance(3.0, 2, 1) == pytest.approx(math.exp(-3.0))  # of two it is exponential
    assert chance(3.0, 2, 5) == pytest.approx(5.0 * math.exp(-3.0))
    assert chance(0.0, 1, 7) == 1.0
