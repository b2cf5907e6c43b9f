"""A part of the load that vanishes at once and alone is doubted: it teaches nothing and lowers no force."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest

from vegrip.estimator import ContactEstimator
from vegrip.estimator.layout import PER_PART
from vegrip.messages import FingertipState
from vegrip.model import ContactModel

Record = Callable[..., list[FingertipState]]
KNOTS, DEPTHS = [0.0, 0.3, 0.8, 6.5], [-1e-4, -1e-4, 1.8e-3, 1.8e-3]
TORQUE, NOISE = 2e-3, 1e-4  # [N m]
FAULT = 3.5  # [s] at which something happens; the load is held from 0.8 s on


@pytest.fixture(scope="module")
def held(model: ContactModel, press: Record) -> list[FingertipState]:
    """Return a contact that is held under a tangential force and a torque."""
    noise = NOISE * np.random.default_rng(5).standard_normal(len(press(model, KNOTS, DEPTHS)))
    states = press(model, KNOTS, DEPTHS, share=0.4)
    return [
        dataclasses.replace(s, torque_z=TORQUE + n) if s.stamp > 0.8e9 else s
        for s, n in zip(states, noise.tolist(), strict=True)
    ]


def altered(states: list[FingertipState], begin: float, end: float, **given: float) -> list[FingertipState]:
    """Return the states with values that are ``given`` between ``begin`` and ``end`` [s]; noise stays."""

    def one(state: FingertipState) -> FingertipState:
        if not begin <= state.stamp / 1e9 < end:
            return state
        changes = {k: v + (state.torque_z - TORQUE if k == "torque_z" else 0.0) for k, v in given.items()}
        return dataclasses.replace(state, **changes)  # type: ignore[arg-type]

    return [one(state) for state in states]


def feel(estimator: ContactEstimator, states: list[FingertipState], until: float) -> None:
    estimator.reset()
    for state in states:
        if state.stamp < until * 1e9:
            estimator.assimilate(state)


def doubts(estimator: ContactEstimator) -> bool:
    """Whether a part of the load is doubted."""
    return bool(estimator.named.section("PART")[PER_PART.index("LOST") :: len(PER_PART)].max() > 0.0)


def taught(estimator: ContactEstimator, states: list[FingertipState], slip: float) -> float:
    """By how much ln mu moves in a slide of 0.1 s that begins at ``slip`` [s]."""
    slipping = altered(states, slip, slip + 0.1, slip=1.0)
    feel(estimator, slipping, slip)
    before = estimator.friction[0]
    feel(estimator, slipping, slip + 0.1)
    return abs(estimator.friction[0] - before)


def test_a_slip_while_the_torque_is_gone_at_once_and_alone_teaches_nothing(
    estimator: ContactEstimator, held: list[FingertipState]
) -> None:
    lost = altered(held, FAULT, FAULT + 1.0, torque_z=0.0)
    assert taught(estimator, held, FAULT + 0.5) > 0.1
    assert taught(estimator, lost, FAULT + 0.5) < 1e-12
    assert taught(estimator, lost, FAULT + 1.0) == pytest.approx(
        taught(estimator, held, FAULT + 1.0), rel=0.2
    )


def test_the_least_force_does_not_fall_while_a_part_of_the_load_is_doubted(
    estimator: ContactEstimator, held: list[FingertipState]
) -> None:
    feel(estimator, held, FAULT)
    wanted = estimator.least_force(0.1)
    for channel in ("torque_z", "tangential_force_x"):
        feel(estimator, altered(held, FAULT, FAULT + 1.0, **{channel: 0.0}), FAULT + 0.5)
        assert estimator.least_force(0.1) > 0.9 * wanted
        assert doubts(estimator)


def test_a_part_that_stays_away_counts_as_gone(
    estimator: ContactEstimator, held: list[FingertipState]
) -> None:
    lost = altered(held, FAULT, math.inf, torque_z=0.0)
    feel(estimator, held, FAULT)
    wanted = estimator.least_force(0.1)
    feel(estimator, lost, FAULT + 1.2)
    assert estimator.least_force(0.1) < 0.8 * wanted
    assert taught(estimator, lost, FAULT + 1.2) > 0.1


def test_a_load_that_goes_as_a_whole_is_gone_at_once(
    estimator: ContactEstimator, held: list[FingertipState]
) -> None:
    feel(estimator, altered(held, FAULT, math.inf, torque_z=0.0, tangential_force_x=0.1), FAULT + 0.05)
    assert not doubts(estimator)


@pytest.mark.parametrize("duration", [0.002, 0.02, 1.0])
def test_the_end_of_a_load_that_was_far_too_large_raises_no_doubt(
    estimator: ContactEstimator, held: list[FingertipState], duration: float
) -> None:
    feel(estimator, held, FAULT + duration + 0.01)
    wanted = estimator.least_force(0.1)
    feel(estimator, altered(held, FAULT, FAULT + duration, torque_z=1.9), FAULT + duration + 0.01)
    assert estimator.least_force(0.1) == pytest.approx(wanted, rel=0.05)
    assert not doubts(estimator)


def test_a_load_that_fades_over_several_samples_raises_no_doubt(
    estimator: ContactEstimator, held: list[FingertipState]
) -> None:
    fading = [
        dataclasses.replace(
            s, torque_z=s.torque_z - TORQUE * (1.0 - math.exp(-(s.stamp / 1e9 - FAULT) / 0.02))
        )
        if s.stamp > FAULT * 1e9
        else s
        for s in held
    ]
    for until in np.arange(FAULT, FAULT + 0.3, 0.02):
        feel(estimator, fading, until)
        assert not doubts(estimator)
