"""Nothing that comes in makes the estimator raise, lie about certainty, or stay lost."""

import dataclasses
import math
import os
from collections.abc import Callable

import numpy as np
import pytest

from vegrip.estimator import ContactEstimator
from vegrip.messages import NAN, Channel, ContactEstimate, Estimate, FingertipState
from vegrip.model import ContactModel

Record = Callable[..., list[FingertipState]]
Run = Callable[[ContactEstimator, list[FingertipState]], ContactEstimate]
KNOTS, DEPTHS = [0.0, 0.3, 0.8, 3.0], [-1e-4, -1e-4, 9e-4, 9e-4]
SAMPLES = int(os.environ.get("VEGRIP_FUZZ", "6000"))  # of each seed
CHANNELS = [f.name for f in dataclasses.fields(FingertipState)][3:]
FAR, PATIENCE = 5.0, 20_000_000  # standard deviations, [ns]


def all_estimates(estimate: ContactEstimate) -> list[Estimate]:
    values = (getattr(estimate, f.name) for f in dataclasses.fields(estimate))
    return [value for value in values if isinstance(value, Estimate)]


def hostile(rng: np.random.Generator, stamp: int, sample: FingertipState) -> FingertipState:
    poison = [math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, 0.0, -1.0, 1e9]
    changes = {name: poison[rng.integers(len(poison))] for name in CHANNELS if rng.random() < 0.3}
    return dataclasses.replace(sample, stamp=stamp, **changes)


class Belief:
    """For how long the force has disagreed with its own measurement, less the bias as estimated."""

    def __init__(self, estimator: ContactEstimator) -> None:
        self.estimator = estimator
        self.since: int | None = None
        self.last = self.latest = 0  # stamps
        self.broken: list[tuple[int, float, Estimate]] = []  # stamp, measured force, estimate

    def look(self, state: FingertipState, estimate: ContactEstimate) -> None:
        if estimate.normal_force.age < 0.0 or state.stamp < self.latest:
            self.since = None  # put in its place among earlier ones, which are judged anew
        if state.stamp < self.latest:
            return
        self.latest = state.stamp
        if estimate.channels is Channel.NONE or estimate.normal_force.age < 0.0:
            return
        force, gap = estimate.normal_force, state.stamp - self.last
        self.last = state.stamp
        if gap > self.estimator.settings.longest_gap * 1e9:
            self.since = None  # what lasted before it is not known to have lasted
        if not abs(state.normal_force) < 1e50:  # not measured, or nothing that a sensor measures
            self.since = None
            return
        bias = float(self.estimator.named.section("Y")[-1])
        if abs(state.normal_force - bias - force.value) <= FAR * force.std:
            self.since = None
            return
        self.since = state.stamp if self.since is None else self.since
        if force.valid and state.stamp - self.since > PATIENCE:
            self.broken.append((state.stamp, state.normal_force, force))


@pytest.mark.parametrize("seed", range(4))
def test_random_poison_never_raises_and_never_comes_out(
    estimator: ContactEstimator, model: ContactModel, press: Record, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    states = press(model, KNOTS, DEPTHS, share=0.4, seed=seed)
    stamp, belief = 0, Belief(estimator)
    for i in range(SAMPLES):
        stamp += int(rng.choice([2_000_000, 1, 0, -5_000_000, 40_000_000, 3_000_000_000, 10**15], p=[
            0.9, 0.02, 0.02, 0.02, 0.02, 0.01, 0.01]))  # fmt: skip
        sample = states[i % len(states)]
        given = (
            hostile(rng, stamp, sample) if rng.random() < 0.5 else dataclasses.replace(sample, stamp=stamp)
        )
        estimate = estimator.update(given)
        belief.look(given, estimate)
        for one in all_estimates(estimate):
            assert not one.valid or (math.isfinite(one.value) and 0.0 < one.std < math.inf)
        if i % 97 == 0:
            margin = estimator.slip_margin()
            assert not margin.margin.valid or margin.lower_bound <= margin.margin.value <= 1.0
            estimator.health()
            estimator.least_force(0.3)
            P = estimator.covariance
            scale = np.sqrt(np.maximum(np.diag(P), 1e-300))
            assert np.linalg.eigvalsh(P / np.outer(scale, scale)).min() > -1e-9
    assert not belief.broken


def test_it_finds_back_after_poison(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    rng = np.random.default_rng(9)
    states = press(model, KNOTS, DEPTHS, share=0.4)
    for i, state in enumerate(states[:300]):
        estimator.update(hostile(rng, state.stamp if i % 3 else state.stamp + 1, state))
    e = run(estimator, states[300:])
    assert e.normal_force.valid
    assert e.normal_force.value == pytest.approx(states[-1].normal_force, abs=0.05)


def test_stamps_that_do_not_advance_are_refused_and_counted(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    states = press(model, KNOTS, DEPTHS)
    run(estimator, states[:500])
    before = estimator.covariance
    again = estimator.update(states[499])
    assert not again.normal_force.valid
    assert estimator.refused == 1
    np.testing.assert_array_equal(estimator.covariance, before)


def test_a_sender_that_starts_its_clock_anew_is_followed(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    states = press(model, KNOTS, DEPTHS)
    run(estimator, states)
    e = run(estimator, states)
    assert e.normal_force.valid
    assert estimator.refused == estimator.settings.recovery


@pytest.mark.parametrize("jump", [-1e4, -10.0, -0.5])
def test_a_clock_that_jumps_back_while_something_is_held_takes_nothing_of_what_is_known(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run, jump: float
) -> None:
    """Met in its middle, this contact asks for twice as much."""
    states, recovery = press(model, KNOTS, DEPTHS, share=0.4), estimator.settings.recovery
    run(estimator, states[:1000])
    undisturbed = [(estimator.update(s), estimator.least_force(0.15))[1] for s in states[1000:1200]]
    estimator.reset()
    run(estimator, states[:1000])
    after = [dataclasses.replace(s, stamp=s.stamp + round(jump * 1e9)) for s in states[1000:1200]]
    assert not run(estimator, after[: recovery - 1]).normal_force.valid
    for state, asked in zip(after[recovery - 1 :], undisturbed[recovery - 1 :], strict=True):
        assert estimator.update(state).normal_force.valid
        assert estimator.least_force(0.15) == pytest.approx(asked, rel=0.02)
    assert estimator.health().rejected == 0


@pytest.mark.parametrize("ahead", [1.0, 3600.0])
def test_one_stamp_far_ahead_does_not_keep_the_samples_after_it_from_counting(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run, ahead: float
) -> None:
    """They find their place before it, as late ones do, for ever."""
    states = press(model, KNOTS, DEPTHS, share=0.4)
    undisturbed = [estimator.update(s) for s in states][-1]
    estimator.reset()
    wrong = dataclasses.replace(states[500], stamp=states[500].stamp + round(ahead * 1e9))
    e = run(estimator, [*states[:500], wrong, *states[501:]])
    assert estimator.late < estimator.settings.recovery
    assert e.stamp == undisturbed.stamp
    assert e.normal_force.valid
    assert e.normal_force.age >= 0.0
    assert e.normal_force.value == pytest.approx(undisturbed.normal_force.value, abs=0.03)


def test_a_clock_that_starts_anew_with_nothing_measured_makes_nothing_valid(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    run(estimator, press(model, KNOTS, DEPTHS, share=0.4))
    blind = [FingertipState(i * 2_000_000, "tip", i) for i in range(40)]
    e = run(estimator, blind)
    assert estimator.refused == estimator.settings.recovery
    assert not e.normal_force.valid
    assert math.isnan(estimator.least_force(0.15))


def test_single_outliers_are_refused_and_do_no_harm(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    states = press(model, KNOTS, DEPTHS)
    clean = run(estimator, states)
    estimator.reset()
    for i in range(700, 1500, 50):
        states[i] = dataclasses.replace(states[i], displacement=states[i].displacement + 2e-4)
        states[i - 25] = dataclasses.replace(states[i - 25], normal_force=states[i - 25].normal_force + 0.5)
    dirty = run(estimator, states)
    assert estimator.health().rejected >= 20
    assert abs(dirty.indentation.value - clean.indentation.value) < clean.indentation.std
    assert abs(dirty.normal_force.value - clean.normal_force.value) < clean.normal_force.std


def test_a_displacement_whose_zero_has_moved_is_not_believed_and_then_learned_anew(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    knots, depths = [0.0, 0.5, 1.0, 2.0, 2.5, 8.0], [-1e-4, -1e-4, 5e-4, 5e-4, -1e-4, -1e-4]
    states = press(model, [*knots, 8.5, 10.0], [*depths, 5e-4, 5e-4])
    moved = [
        dataclasses.replace(s, displacement=s.displacement + 1e-3) if s.stamp > 1_500_000_000 else s
        for s in states
    ]
    valid = [run(estimator, [state]).normal_force.valid for state in moved]
    by_time = {round(s.stamp / 1e9, 3): known for s, known in zip(moved, valid, strict=True)}
    assert by_time[1.4]
    assert not any(known for t, known in by_time.items() if 1.55 < t < 2.0)
    assert by_time[8.5]
    e = estimator.contact_estimate()
    assert e.normal_force.valid
    assert abs(e.indentation.value - 5e-4) < 5e-4, "half of the millimetre by which the zero has moved"


def test_a_number_that_is_not_finite_any_more_is_counted_and_begins_everything_anew(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    states = press(model, KNOTS, DEPTHS)
    run(estimator, states[:500])
    assert estimator.named["COUNT_OVERFLOWS"] == 0
    estimator.numbers[estimator.layout.places()["Y"][1] - 1] = math.inf
    run(estimator, states[500:502])
    assert estimator.named["COUNT_OVERFLOWS"] == 1
    assert np.isfinite(estimator.covariance).all()
    estimator.reset()
    assert estimator.named["COUNT_OVERFLOWS"] == 0


def test_uncertainty_grows_without_measurements(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    states = press(model, KNOTS, DEPTHS, share=0.4)
    known = run(estimator, states)
    last = states[-1]
    stds = []
    for i in range(1, 6):
        blind = FingertipState(last.stamp + i * 100_000_000, "tip", i)
        e = estimator.update(blind)
        stds.append(e.normal_force.std)
    assert stds == sorted(stds)
    assert stds[0] > known.normal_force.std
    assert not e.normal_force.valid  # older than the longest gap
    assert e.normal_force.age == pytest.approx(0.5)


def test_missing_tangential_force_makes_the_margin_invalid(
    estimator: ContactEstimator, model: ContactModel, press: Record
) -> None:
    for state in press(model, KNOTS, DEPTHS, share=0.4):
        estimator.update(dataclasses.replace(state, tangential_force_y=NAN))
    margin = estimator.slip_margin()
    assert not margin.margin.valid
    assert math.isnan(margin.lower_bound)
    assert math.isnan(estimator.least_force(0.3))


def test_nothing_is_valid_before_the_first_usable_sample(estimator: ContactEstimator) -> None:
    e = estimator.update(FingertipState(0, "tip", 0, tangential_force_x=1.0))
    assert not any(one.valid for one in all_estimates(e))
    assert not estimator.slip_margin().margin.valid
    assert math.isnan(estimator.least_force(0.3))


@pytest.mark.parametrize("frequency", [1.0, 3.0, 10.0])
@pytest.mark.parametrize("size", [0.1, 0.3])
def test_a_force_that_the_model_cannot_explain_widens_the_interval_and_stays_valid(
    estimator: ContactEstimator, model: ContactModel, press: Record, size: float, frequency: float
) -> None:
    """An oscillation of the force that no displacement shows; all the time after 0.5 s of it."""
    begin, widths = 1.5, []
    for state in press(model, [0.0, 0.3, 0.8, 4.0], [-1e-4, -1e-4, 1.8e-3, 1.8e-3], share=0.3):
        t = state.stamp / 1e9 - begin
        shaken = state.normal_force + (size * math.sin(2.0 * math.pi * frequency * t) if t > 0.0 else 0.0)
        force = estimator.update(dataclasses.replace(state, normal_force=shaken)).normal_force
        if t > 0.5:
            assert force.valid
            widths.append(force.std)
    assert np.median(widths) > 0.4 * size
