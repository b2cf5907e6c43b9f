"""Counts how often the truth lies within the interval the estimator states."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from validation.estimator_coverage.independent import live_independently
from validation.estimator_coverage.truth import Truth, live
from vegrip.estimator.estimator import ContactEstimator
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.messages import NAN, Estimate, FingertipState
from vegrip.model import ContactModel, paper_model

COVERED_QUANTITIES = ("a", "k", "mu", "N", "limit_radius")
CONFIGURATIONS = ("both", "position", "force")
LOOK_PERIOD_S = 0.25  # [s] between looks
FIRST_LOOK_S = 1.0  # [s] of the first look


@dataclass
class Score:
    """How many looks, and how many of them found the truth inside."""

    inside: int = 0
    count: int = 0

    def add(self, inside: bool) -> None:
        """Count one look."""
        self.count += 1
        self.inside += inside

    @property
    def share(self) -> float:
        """Coverage."""
        return self.inside / self.count if self.count else NAN


def fingertip() -> ContactModel:
    """The prior fingertips are drawn from: 8 mm silicone, known as well as before any fit."""
    return paper_model(8e-3)


def coverage(
    prior: ContactModel, configuration: str, truths: int, seed: int, *, start_in_contact: bool = False
) -> dict[str, Score]:
    """Return the scores of one sensor configuration over ``truths`` random fingertips."""
    noise, settings = SensorNoise(), EstimatorSettings()
    estimator = ContactEstimator(prior, noise, settings)
    scores = {name: Score() for name in COVERED_QUANTITIES}
    for index in range(truths):
        rng = np.random.default_rng([seed, index])
        truth = live(prior, noise, settings, rng, start_in_contact=start_in_contact)
        estimator.reset()
        for name, inside in looks(estimator, truth, configuration):
            scores[name].add(inside)
    return scores


def independent_coverage(configuration: str, truths: int, seed: int) -> dict[str, Score]:
    """Return the same for fingertips of the virtual hand, which shares no code with the estimator."""
    noise, settings = SensorNoise(), EstimatorSettings()
    scores = {name: Score() for name in COVERED_QUANTITIES}
    for index in range(truths):
        model, truth = live_independently(noise, settings, np.random.default_rng([seed, index]))
        for name, inside in looks(ContactEstimator(model, noise, settings), truth, configuration):
            scores[name].add(inside)
    return scores


def looks(estimator: ContactEstimator, truth: Truth, configuration: str) -> Iterator[tuple[str, bool]]:
    """Run the estimator over a truth; yield (quantity, inside) at every look within contact."""
    due = truth.t[0] + FIRST_LOOK_S
    for i, state in enumerate(truth.states):
        estimate = estimator.update(seen(state, configuration))
        if truth.t[i] < due:
            continue
        due += LOOK_PERIOD_S
        if not estimate.in_contact or truth.contact.normal_force[i] <= 0.0:
            continue
        true = truth.contact
        yield "a", within(estimate.contact_radius, true.contact_radius[i])
        yield "k", within(estimate.pressure_exponent, true.pressure_exponent[i])
        yield "mu", within_log(estimate.friction_coefficient, true.friction_coefficient[i])
        yield "N", within(estimate.normal_force, true.normal_force[i])
        if truth.utilisation[i] > 0.3:
            yield "limit_radius", within_log(estimate.limit_radius, truth.limit_radius(i))


def seen(state: FingertipState, configuration: str) -> FingertipState:
    """Return the state as a fingertip with fewer sensors gives it."""
    if configuration == "position":
        return replace(state, normal_force=NAN)
    if configuration == "force":
        return replace(state, displacement=NAN)
    return state


def within(estimate: Estimate, true: float) -> bool:
    """Return whether the truth lies in the 95 % interval."""
    return estimate.valid and abs(estimate.value - true) <= 1.96 * estimate.std


def within_log(estimate: Estimate, true: float) -> bool:
    """Return the same for a product of positive factors, whose logarithm is the normal one."""
    if not (estimate.valid and estimate.value > 0.0):
        return False
    return abs(math.log(estimate.value / true)) <= 1.96 * estimate.std / estimate.value
