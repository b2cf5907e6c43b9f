"""Samples that come late, twice, or by a clock that was set back: as the estimator alone takes them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.grip.stages import FINGER, KERNELS, MODEL, Stage
from vegrip.clock import NS
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.messages import FingertipState

MS = 1_000_000
STEPS = st.sampled_from([1, 1, 1, 1, 2, 5, -1, -2, -3, -4, 0, -400, 300])


def estimator() -> ContactEstimator:
    return ContactEstimator(MODEL, SensorNoise(), EstimatorSettings(late=FINGER.late, recovery=4))


def sample(number: int, stamp: int, rng: np.random.Generator) -> FingertipState:
    depth = 8e-4 * math.sin(0.05 * number)
    force = max(2.0 * depth / 8e-4, 0.0) + 0.01 * rng.standard_normal()
    return FingertipState(
        stamp, "tip", number, force if number % 7 else math.nan, 0.2, 0.1, 1e-4, depth, slip=0.0
    )


@settings(max_examples=25, deadline=None)
@given(steps=st.lists(STEPS, min_size=5, max_size=40), seed=st.integers(0, 5))
def test_whatever_the_order_of_the_stamps_the_memory_is_that_of_the_estimator(
    steps: list[int], seed: int
) -> None:
    alone, mounted, stage = estimator(), estimator(), Stage()
    mounted.mount(stage.memory, "tip")
    rng, stamp = np.random.default_rng(seed), 10 * NS
    for number, step in enumerate(steps):
        stamp += step * MS
        state = sample(number, stamp, rng)
        alone.assimilate(state)
        stage.put(state)
        with np.errstate(all="ignore"):
            KERNELS.assimilate(stage.f, stage.t)
            KERNELS.note_history(stage.f, stage.t)
        assert mounted.memory.tobytes() == alone.memory.tobytes()
        counts = ("refused", "late", "in_contact")
        assert [getattr(mounted, name) for name in counts] == [getattr(alone, name) for name in counts]
        assert repr(mounted.contact_estimate()) == repr(alone.contact_estimate())
        assert stage.memory["STATE_DISPLACEMENT"] == state.displacement, "the state stays the present one"


def test_a_late_sample_finds_its_place() -> None:
    """In order or late by up to three samples, the same is known at the end."""
    rng = np.random.default_rng(1)
    states = [sample(n, 10 * NS + n * 2 * MS, rng) for n in range(60)]
    known = []
    for order in (range(60), [*range(40), *range(41, 44), 40, *range(44, 60)]):
        one, stage = estimator(), Stage()
        one.mount(stage.memory, "tip")
        for number in order:
            stage.put(states[number])
            with np.errstate(all="ignore"):
                KERNELS.assimilate(stage.f, stage.t)
        known.append(one.state)
        assert one.late == int(list(order) != list(range(60)))
    for name, value in known[0].items():
        assert known[1][name].value == pytest.approx(value.value, rel=1e-9), name


def test_the_first_sample_must_measure_force_or_displacement() -> None:
    one, stage = estimator(), Stage()
    one.mount(stage.memory, "tip")
    stage.put(FingertipState(NS, "tip", 0, math.nan, 1.0, 0.0, 0.0, math.nan))
    KERNELS.assimilate(stage.f, stage.t)
    assert one.contact_estimate().stamp == NS
    assert not one.contact_estimate().normal_force.valid
    assert stage.memory["SAMPLE_BEGUN"] == 0
