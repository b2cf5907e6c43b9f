"""Scores of the estimator on lives from outside: coverage, worst errors, lost contacts, one row per style."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from validation.estimator_coverage.lives import Life, drawn, lived, told
from validation.estimator_coverage.outside import Contact
from vegrip.clock import NS
from vegrip.estimator.estimator import ContactEstimator
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.messages import ContactEstimate, Estimate
from vegrip.types import Floats

JUDGED_QUANTITIES = ("N", "indentation", "radius", "k", "mu", "limit radius")
SOLID = 0.3  # [N] from which the contact is looked at
LOOK_PERIOD_S = 0.05  # [s] between two looks
INSIDE_STDS, FAR_STDS = 1.96, 6.0  # standard deviations
FEWEST = 20  # looks at a quantity, to count
LOST_AFTER_S = 0.05  # [s] for which a valid force is far off before the contact counts as lost


@dataclass(frozen=True)
class Result:
    """What one life showed."""

    life: Life
    errors: Floats  # (looks, quantities) in standard deviations; NaN = not valid or not asked
    not_valid: int  # looks
    lost: int  # contacts
    started: tuple[float, ...]  # [s] when they were lost
    worst_at: float  # [s] of the worst error of force or indentation

    @property
    def coverage(self) -> Floats:
        """Share of the looks inside the interval for each quantity; NaN without looks."""
        return coverage_of(self.errors)

    @property
    def worst(self) -> float:
        """Largest error of force or indentation in standard deviations."""
        return float(np.nanmax(self.errors[:, :2], initial=0.0))

    @property
    def far(self) -> float:
        """Share of the looks at which force or indentation is far off."""
        return float(np.mean(np.nanmax(self.errors[:, :2], axis=1, initial=0.0) > FAR_STDS))


def coverage_of(errors: Floats) -> Floats:
    """Return the share inside for each column, NaN with less than FEWEST looks."""
    count = np.sum(np.isfinite(errors), axis=0)
    inside = np.sum(errors < INSIDE_STDS, axis=0)
    return np.where(count >= FEWEST, inside / np.maximum(count, 1), math.nan)


def judge(style: str, life: Life) -> Result:
    """Let the estimator follow one life."""
    noise, settings = SensorNoise(), EstimatorSettings()
    truth, states = lived(style, life, noise, settings)
    estimator = ContactEstimator(told(life), noise, settings)
    rows, times, not_valid, due = [], [], 0, 0.0
    started: list[float] = []
    far_since, counted = math.inf, False
    for i, state in enumerate(states):
        said = estimator.update(state)
        now = state.stamp / NS
        force = said.normal_force
        if not (force.valid and abs(force.value - truth.force[i]) > FAR_STDS * force.std):
            far_since, counted = math.inf, False
        elif not counted:
            far_since = min(far_since, now)
            counted = now - far_since > LOST_AFTER_S
            started += [far_since] * counted
        if truth.force[i] < SOLID or now < due:
            continue
        due = now + LOOK_PERIOD_S
        not_valid += not force.valid
        rows.append(errors_of(said, truth, i, life.friction))
        times.append(now)
    errors = np.array(rows).reshape(-1, len(JUDGED_QUANTITIES))
    top = np.nanmax(errors[:, :2], axis=1, initial=0.0)
    at = times[int(np.argmax(top))] if times else math.nan
    return Result(life, errors, not_valid, len(started), tuple(started), at)


def errors_of(said: ContactEstimate, truth: Contact, i: int, friction: float) -> list[float]:
    """Return the errors of one look in standard deviations."""
    loaded = truth.used[i] > 0.3
    return [
        error(said.normal_force, truth.force[i]),
        error(said.indentation, truth.depth[i]),
        error(said.contact_radius, truth.radius[i]),
        error(said.pressure_exponent, truth.exponent[i]),
        log_error(said.friction_coefficient, friction),
        log_error(said.limit_radius, truth.limit[i]) if loaded else math.nan,
    ]


def error(estimate: Estimate, true: float) -> float:
    """Return the error in standard deviations, NaN where the estimate is not valid."""
    if not estimate.valid:
        return math.nan
    return abs(estimate.value - true) / max(estimate.std, 1e-300)


def log_error(estimate: Estimate, true: float) -> float:
    """Return the same for a product of positive factors, whose logarithm is the normal one."""
    if not (estimate.valid and estimate.value > 0.0 and true > 0.0):
        return math.nan
    return abs(math.log(estimate.value / true)) * estimate.value / max(estimate.std, 1e-300)


def results(style: str, fingers: int, seed: int) -> Iterator[Result]:
    """Judge ``fingers`` fresh lives."""
    for index in range(fingers):
        yield judge(style, drawn(np.random.default_rng([seed, index, sum(style.encode())])))


def header() -> str:
    """Return the first line of the table."""
    names = [*JUDGED_QUANTITIES, "worst", "beyond 6", "least finger", "not valid", "lost"]
    return f"{'style':<7}{'looks':>8}" + "".join(name.rjust(14) for name in names)


def row(style: str, found: Sequence[Result]) -> str:
    """Return one line of the table."""
    errors = np.concatenate([result.errors for result in found])
    looks = max(len(errors), 1)
    cells = [f"{100 * share:.1f}" for share in coverage_of(errors)]
    far = np.mean(np.nanmax(errors[:, :2], axis=1, initial=0.0) > FAR_STDS)
    least = np.array([result.coverage for result in found])
    place = np.unravel_index(np.nanargmin(least), least.shape)
    cells += [f"{max(result.worst for result in found):.1f}", f"{100 * far:.2f} %"]
    cells += [f"{JUDGED_QUANTITIES[place[1]][:6]} {100 * least[place]:.0f}"]
    cells += [f"{100 * sum(result.not_valid for result in found) / looks:.2f} %"]
    cells += [str(sum(result.lost for result in found))]
    return f"{style:<7}{looks:>8}" + "".join(cell.rjust(14) for cell in cells)
