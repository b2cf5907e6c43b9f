"""What remains of a memory after a pause, in closed form."""

import math

import numpy as np
import pytest
from scipy.integrate import quad


@pytest.mark.parametrize("left", [1e-9, 0.1, 0.7, 0.99, 0.9995, 1.0])
def test_the_mean_of_a_decay_is_that_over_any_instant_of_the_pause(kernels, left) -> None:
    mean, square = kernels.mean_decay(left)
    assert mean == pytest.approx(quad(lambda u: left**u, 0.0, 1.0)[0], rel=1e-3)
    assert square == pytest.approx(quad(lambda u: left ** (2.0 * u), 0.0, 1.0)[0], rel=1e-3)


def test_steps_of_a_pause_add_up_to_it_and_grow(kernels) -> None:
    steps = [kernels.gap_step(3.0, i) for i in range(kernels.RECOVERY_STEPS)]
    assert sum(steps) == pytest.approx(3.0)
    assert np.all(np.diff(steps) > 0.0)
    assert steps[0] < 1e-4


def test_after_a_pause_in_the_air_a_memory_is_the_mean_of_what_may_remain(kernels, m, model) -> None:
    """A free surface with one branch recovers with (1 - c) nu, from what it could have become in a hold."""
    z = kernels.Y0 + kernels.EFFECTS
    kernels.put_learned(m, kernels.Y0)
    c, nu = (m[kernels.VALUES0 + list(model.parameters).index(name)] for name in ("c1", "nu1"))
    largest = kernels.largest_memory(m, 0)
    assert largest >= m[z] > 0.0
    before = m[kernels.P0 : kernels.P0 + kernels.N**2].reshape(kernels.N, kernels.N).copy()
    kernels.bridge_gap(m, 2.0, 0.0, -1e-3)
    P = m[kernels.P0 : kernels.P0 + kernels.N**2].reshape(kernels.N, kernels.N)
    zero, mean = kernels.OFFSET, m[z] / largest
    learned, cross = slice(kernels.LEARNED_FROM, kernels.N), before[kernels.EFFECTS, kernels.LEARNED_FROM :]
    assert P[kernels.EFFECTS, learned] == pytest.approx(mean * cross, rel=1e-6)
    assert P[learned, kernels.EFFECTS] == pytest.approx(mean * cross, rel=1e-6)
    assert P[kernels.EFFECTS, kernels.DELTA] == P[kernels.DELTA, kernels.EFFECTS] == -P[kernels.EFFECTS, zero]
    left = math.exp(-(1.0 - c) * nu * 2.0)
    decades = -math.log(left)
    assert m[z] == pytest.approx(largest * (1.0 - left) / decades, rel=0.02)
    square = (1.0 - left**2) / (2.0 * decades)
    spread = largest**2 * (square - ((1.0 - left) / decades) ** 2)
    variance = m[kernels.P0 + kernels.EFFECTS * kernels.N + kernels.EFFECTS]
    assert variance == pytest.approx(spread, rel=0.1)


@pytest.mark.parametrize(
    ("contact", "displacement", "force", "recovers"),
    [
        (0.0, -1e-3, 0.0, True),
        (0.0, math.nan, 0.0, False),
        (0.0, -1e-3, 1.0, False),
        (1.0, -1e-3, 0.0, False),
    ],
)
def test_a_tip_recovers_step_by_step_where_it_was_and_is_in_the_air(
    kernels, m, monkeypatch, contact, displacement, force, recovers
) -> None:
    steps, begun = [], []
    monkeypatch.setattr(kernels, "predict", lambda _m, *given: steps.append(given))
    monkeypatch.setattr(kernels, "begin_motion", lambda _m, place: begun.append(place))
    monkeypatch.setattr(kernels, "begin_contact", lambda *_: None)
    m[kernels.REP_CONTACT], m[kernels.MODE_CORNER] = contact, 7.0
    kernels.bridge_gap(m, 3.0, force, displacement)
    if not recovers:
        assert steps == begun == []
        return
    assert steps == [(kernels.gap_step(3.0, i), -1e-3) for i in range(60)]
    assert begun == [-1e-3]
    assert m[kernels.MODE_CORNER] == 0.0


@pytest.mark.parametrize("known", [0.0, 1.0])
def test_in_contact_after_a_pause_the_zero_is_known_as_it_was(kernels, m, known) -> None:
    m[kernels.MODE_ZERO_KNOWN] = known
    kernels.bridge_gap(m, 3.0, 1.0, m[kernels.Y0 + kernels.OFFSET] + 9e-4)
    assert m[kernels.MODE_ZERO_KNOWN] == known
