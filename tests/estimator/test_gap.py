"""A long silence: nothing was measured, the contact went on recovering."""

import dataclasses

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import paper_model
from vegrip.types import Floats

PRESSED = ([0.0, 0.3, 0.5, 2.0, 2.2, 2.6], [-2e-4, -2e-4, 1.1e-3, 1.1e-3, -2e-4, -2e-4])


@pytest.mark.parametrize("gap", [1.0, 30.0, 1000.0])
@pytest.mark.parametrize("slow", [False, pytest.param(True, marks=pytest.mark.other_model)])
def test_a_free_fingertip_comes_out_of_a_gap_as_recovered_as_it_is(press, gap, slow) -> None:
    """What the filter foresees of the next touch is what the model says of the whole history."""
    model = paper_model(8e-3)
    if slow:
        model = model.with_effect(effect("second_relaxation")).with_value("c2", 0.3).with_value("nu2", 0.2)
    estimator = ContactEstimator(model, SensorNoise())
    before = press(model, *PRESSED)
    for state in before:
        estimator.assimilate(state)
    t = [s.stamp * 1e-9 for s in before]
    later = [t[-1] + gap + time for time in t]
    depth = [s.displacement for s in before]
    truth = model.simulate([*t, *later], [*depth, *depth]).normal_force[len(t) :]
    for state, time, force in zip(before, later, truth, strict=True):
        estimator.assimilate(
            dataclasses.replace(state, stamp=round(time * 1e9), seq=state.seq + 10**6, normal_force=force)
        )
        foreseen = estimator.normal_force
        if state.displacement > 1e-4:
            assert abs(foreseen.value - force) < 0.005 + 4.0 * foreseen.std
    assert estimator.health().rejected == 0


@pytest.mark.parametrize("seed", range(3))
def test_a_rate_told_wrong_is_no_surer_of_the_memory_after_a_pause_than_before(press, seed) -> None:
    """A surface that is still dented touches later: a memory wrongly sure puts the zero off by many std."""
    model = paper_model(8e-3).with_value("c1", 0.25).with_value("nu1", 0.08)
    estimator = ContactEstimator(
        model.with_value("nu1", 0.04).with_value("c1", 0.38).with_value("p", 1.4), SensorNoise()
    )
    one, lengths = ([0.0, 0.2, 0.3, 2.5, 2.8, 3.0], [-2e-4, -2e-4, 8e-4, 8e-4, -2e-4, -2e-4]), 12
    t, depth = (
        np.concatenate(column) for column in zip(*(moved(*one, 8.0 * i) for i in range(lengths)), strict=True)
    )
    truth = model.simulate(t, depth)
    rng, worst = np.random.default_rng(seed), 0.0
    noise = SensorNoise()
    for i, (time, true, force) in enumerate(zip(t, depth, truth.normal_force, strict=True)):
        said = estimator.update(
            FingertipState(
                round(time * 1e9) + 1,
                "tip",
                i,
                force + noise.normal_force * rng.standard_normal(),
                displacement=true + noise.displacement * rng.standard_normal(),
            )
        )
        if force > 0.2:
            worst = max(worst, abs(said.indentation.value - true) / said.indentation.std)
    assert worst < 4.5


def moved(knots: list[float], depths: list[float], start: float) -> tuple[Floats, Floats]:
    """Return the times [s] and indentations [m] of one trial at 200 Hz."""
    t = np.arange(int(knots[-1] * 200.0)) / 200.0
    return t + start, np.interp(t, knots, depths)


def test_without_a_displacement_a_force_that_is_felt_again_is_known_to_its_noise() -> None:
    """What is not known of the stiffness is no part of what is not known of the memory."""
    estimator = ContactEstimator(paper_model(9e-3), SensorNoise())
    for k in range(1000):
        t = 0.01 * k
        if not 5.0 < t < 6.0:
            force = 30.0 * min(t, 1.0)
            estimator.assimilate(FingertipState((k + 1) * 10_000_000, "index", k, force, 0.0, 0.0))
            if t > 1.0:
                assert estimator.normal_force.std < 0.05
                assert estimator.normal_force.value == pytest.approx(force, abs=0.05)
