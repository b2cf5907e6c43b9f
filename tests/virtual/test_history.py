"""The hereditary integral against closed forms."""

import numpy as np
import pytest

from vegrip.virtual.history import History, power_law, prony

G = prony([0.3], [3.1])


def relaxed(history: History, elastic: np.ndarray) -> np.ndarray:
    """Feed N_e sampled at the ends of the steps (one finger); return N at the same instants."""
    forces, before = [], 0.0
    for now in elastic:
        forces.append(float((history.past() + history.instant * (now - before))[0]))
        history.append(np.array([now - before]))
        before = float(now)
    return np.array(forces)


@pytest.mark.parametrize(
    ("law", "golden"),
    [
        (lambda t: t, 0.7924145933),
        (lambda t: t**2 / 2.0, 0.4169630344),
        (np.expm1, 1.3983996672),
    ],
    ids=["linear", "power", "exponential"],
)
def test_ramp_gives_the_golden_force(law, golden) -> None:
    h = 1e-3
    t = h * np.arange(1, 1001)
    assert relaxed(History([G], h), law(t))[-1] == pytest.approx(golden, rel=1e-6)


def test_error_of_a_ramp_falls_with_the_square_of_the_step() -> None:
    errors = []
    for count in (25, 50, 100):
        t = np.arange(1, count + 1) / count
        errors.append(abs(relaxed(History([G], 1.0 / count), t**2 / 2.0)[-1] - 0.4169630344))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("g", [G, prony([0.2, 0.1], [40.0, 0.25]), power_law(0.5, 0.02, 0.2)])
def test_step_relaxes_as_g(g) -> None:
    h, n = 2e-3, 4000
    history = History([g], h, fine=256, block=16, blocks=512)
    forces = relaxed(history, np.full(n, 2.0))
    t = h * np.arange(n)
    # the step is a ramp over the first interval, so the force is the mean of g over an interval
    mean = np.mean([g(t + part * h) for part in (np.arange(200) + 0.5) / 200], axis=0)
    assert forces == pytest.approx(2.0 * mean, abs=2.0 * float(history.error_bound[0]) + 1e-6)


@pytest.mark.parametrize("g", [prony([0.2, 0.1], [3.1, 0.15]), power_law(0.6, 0.05, 0.3)])
def test_bounded_history_keeps_its_promise_against_the_full_sum(g) -> None:
    rng = np.random.default_rng(0)
    elastic = np.abs(np.cumsum(rng.standard_normal(4000)))
    h = 5e-3
    short = History([g], h, fine=64, block=8, blocks=100)
    error = np.abs(relaxed(short, elastic) - relaxed(History([g], h, fine=5000), elastic))
    variation = np.cumsum(np.abs(np.diff(elastic, prepend=0.0)))
    assert error[-1] > 0.0  # something has really been merged and lumped
    assert np.all(error <= short.error_bound[0] * variation + 1e-9)


def test_default_history_is_exact_to_a_few_thousandths_of_the_load() -> None:
    assert History([prony([0.2, 0.1], [3.1, 0.15])], 1e-3).error_bound[0] < 3e-3


def test_reweighing_with_the_same_function_changes_nothing() -> None:
    history = History([G], 1e-3, fine=32, block=4, blocks=16)
    relaxed(history, np.linspace(0.0, 3.0, 300))
    before = history.past()
    history.reweigh([G])
    assert history.past() == pytest.approx(before, rel=1e-14)


def test_a_cleared_history_is_a_new_one() -> None:
    history = History([G], 1e-3, fine=32, block=4, blocks=16)
    load = np.linspace(0.0, 3.0, 200)
    first = relaxed(history, load)
    history.clear()
    assert np.array_equal(relaxed(history, load), first)
