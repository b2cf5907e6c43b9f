"""A long silence: nothing was measured, the contact went on recovering."""

import dataclasses

import pytest

from vegrip.effects import effect
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.model import paper_model

PRESSED = ([0.0, 0.3, 0.5, 2.0, 2.2, 2.6], [-2e-4, -2e-4, 1.1e-3, 1.1e-3, -2e-4, -2e-4])


@pytest.mark.parametrize("gap", [1.0, 30.0, 1000.0])
@pytest.mark.parametrize("slow", [False, True])
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
            assert abs(foreseen.value - force) < 0.05 + 4.0 * foreseen.std
    assert estimator.health().rejected == 0
