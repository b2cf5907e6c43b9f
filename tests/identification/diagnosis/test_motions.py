"""What one motion shows need not hold in another: each has to agree."""

from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.identification.diagnosis.motions import is_contradicted, motions_of, unproven

STEP = 0.01  # [s]


def press(depth: float, speed: float, hold: float = 0.5) -> np.ndarray:
    """Return the displacement [m] of a press from 0.2 mm above the surface, and back."""
    up = np.arange(-2e-4, depth, speed * STEP)
    return np.concatenate([up, np.full(round(hold / STEP), depth), up[::-1]])


def rig(presses, *, slides=(), tolerance=0.0, one_episode=False):
    """Give what ``motions_of`` reads of a problem."""
    x = np.concatenate(presses)
    episodes = np.concatenate([np.full(one.size, i) for i, one in enumerate(presses)])
    touching = [np.flatnonzero((episodes == i) & (x > 0.0)) for i in slides]
    measured = SimpleNamespace(
        recording=SimpleNamespace(t=STEP * np.arange(x.size)),
        motion=SimpleNamespace(displacement=x),
        sliding=np.concatenate(touching) if touching else np.zeros(0, dtype=int),
        seen=np.zeros(0, dtype=int),
        noise=SimpleNamespace(tolerance=tolerance),
    )
    return SimpleNamespace(
        measured=measured, stiffness=(x > 0.0) * 1.0, episodes=0 * episodes if one_episode else episodes
    )


def numbers(problem, presses) -> list[int]:
    """Return the motion of each press."""
    ends = np.cumsum([one.size for one in presses])
    return [int(motions_of(problem)[end - 1]) for end in ends]


@pytest.mark.parametrize("one_episode", [False, True])
def test_presses_of_one_depth_and_speed_are_one_motion_in_one_episode_or_many(one_episode) -> None:
    rng = np.random.default_rng(3)
    alike = [press(1e-3 * s, 2e-3 / s, 9.0 * s**5) for s in rng.uniform(0.95, 1.05, 12)]
    alike = [one + 2e-6 * rng.normal(size=one.size) for one in alike]
    assert numbers(rig(alike, one_episode=one_episode), alike) == [0] * 12


def test_another_depth_speed_way_or_slide_is_another_motion_and_a_brush_is_none() -> None:
    one, brush = press(1e-3, 2e-3), press(1e-4, 2e-3)
    wave = 7e-4 + 3e-4 * np.cos(np.linspace(0.0, 8.0 * np.pi, 200))
    twice = np.concatenate([one[: np.argmax(one)], wave, one[::-1][np.argmax(one[::-1]) :]])
    presses = [one, press(5e-4, 2e-3), press(1e-3, 8e-3), twice, brush, one, one]
    assert numbers(rig(presses, slides=[5]), presses) == [0, 1, 2, 3, 3, 4, 0]


@pytest.mark.parametrize(("second", "is_so"), [(1.0, False), (0.0, False), (-0.4, True)])
def test_an_effect_is_contradicted_by_a_motion_that_it_makes_worse(linear, second, is_so) -> None:
    """Two motions have an amount of their own; 0 is none, where it makes no difference that it fits."""
    presses = [press(1e-3, 2e-3) for _ in range(3)] + [press(1e-3, 2e-2) for _ in range(3)]
    real = rig(presses)
    rng, number = np.random.default_rng(5), motions_of(real)
    x = rng.normal(size=number.size) * np.where(number == 0, 1.0, abs(np.sign(second)))
    y = x * np.where(number == 0, 1.0, second) + rng.normal(size=number.size)
    firm = np.ones((number.size, 1))

    real.rows = np.arange(number.size)

    def fitted(columns):
        return linear(y, columns, np.full(columns.shape[1], 10.0)).fitted(number)

    base, new = fitted(firm), fitted(np.column_stack([firm, x]))
    assert is_contradicted(base, new, number) == is_so
    assert ("explained worse" in unproven(real, {"lag": (base, new)})) == is_so


def test_one_motion_proves_nothing_within_a_tolerance_and_two_do() -> None:
    one, other = press(1e-3, 2e-3), press(1e-3, 2e-2)

    def said(presses, tolerance: float) -> str:
        return unproven(rig(presses, tolerance=tolerance), {})

    assert "press to another depth" in said([one, one, one], 0.02)
    assert said([one, one, one], 0.0) == ""
    assert said([one, other], 0.02) == ""
