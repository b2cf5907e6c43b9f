"""A sample that comes late counts as if it had come in time."""

import dataclasses

import numpy as np
import pytest

from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.messages import NAN, FingertipState
from vegrip.model import paper_model

PERIOD = 2_000_000  # [ns]


@pytest.fixture(scope="module")
def given():
    model = paper_model(8e-3)
    t = np.arange(400) * PERIOD * 1e-9
    depth = np.interp(t, [0.1, 0.4], [-1e-4, 1e-3])
    force = model.simulate(t, depth).normal_force + 0.01 * np.random.default_rng(1).standard_normal(t.size)
    return [
        FingertipState(i * PERIOD, "tip", i, force[i], 0.1, 0.0, 1e-4, depth[i], slip=0.0)
        for i in range(t.size)
    ]


def run(samples, **settings):
    estimator = ContactEstimator(paper_model(8e-3), SensorNoise(), EstimatorSettings(**settings))
    for sample in samples:
        estimator.assimilate(sample)
    return estimator


def lasting(estimator):
    """What the next sample depends on."""
    return estimator.memory[: estimator.layout.lasting]


def camera(states, every=20):
    """Contact radii of a camera, between the samples of force and displacement."""
    seen = [state for state in states if state.seq % every == every - 1 and state.normal_force > 0.1]
    return [
        dataclasses.replace(
            state, stamp=state.stamp + 1, normal_force=NAN, displacement=NAN, contact_radius=3.5e-3
        )
        for state in seen
    ]


def merged(states, images, delay):
    """The images ``delay`` samples later than they were taken."""
    return sorted([*states, *images], key=lambda s: s.stamp + (delay * PERIOD if s in images else 0))


def test_the_order_of_arrival_makes_no_difference(given):
    images = camera(given[:-20])
    assert len(images) > 5
    in_time, late = run(merged(given, images, 0)), run(merged(given, images, 7))
    assert late.late == len(images)
    assert late.refused == 0
    np.testing.assert_array_equal(lasting(late), lasting(in_time))
    assert late.contact_estimate() == in_time.contact_estimate()
    without = run(given)
    assert late.contact_estimate().contact_radius != without.contact_estimate().contact_radius


def test_samples_in_any_order_within_the_window_give_the_same(given):
    rng = np.random.default_rng(5)
    order = np.argsort(np.arange(len(given)) + rng.uniform(0.0, 8.0, len(given)), kind="stable")
    order = np.concatenate([[0], order[order != 0]])  # what begins cannot come late
    mixed = run([given[i] for i in order])
    assert mixed.late > 100
    np.testing.assert_array_equal(lasting(mixed), lasting(run(given)))


def test_what_is_older_than_the_window_is_refused(given):
    late = given[100]
    samples = [*given[:100], *given[101:130], late, *given[130:]]
    estimator = run(samples, late=16)
    assert (estimator.late, estimator.refused) == (0, 1)
    np.testing.assert_array_equal(lasting(estimator), lasting(run([s for s in given if s is not late])))


def test_a_sample_taken_twice_is_refused_once(given):
    estimator = run([*given[:50], given[45], *given[50:]])
    assert (estimator.late, estimator.refused) == (0, 1)
    np.testing.assert_array_equal(lasting(estimator), lasting(run(given)))


@pytest.mark.other_model
def test_without_a_window_every_late_sample_is_refused(given):
    estimator = run([*given[:50], given[51], given[50], *given[52:]], late=0)
    assert (estimator.late, estimator.refused) == (0, 1)
