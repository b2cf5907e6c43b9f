"""The gates before a candidate is named. More evidence alone names something on every recording.

1. the evidence pays for its parameters: ``ln Z`` grows by more than 8 nats,
2. episodes that were held out agree: their scores grow in sum, what some lose is little, and the gain is not
   that of one episode alone,
3. the regimes of the misfit get smaller, unless it takes most of what is left, and so does the plain error,
4. its amount is more than the sensors resolve: three standard errors at the shape that was found, and three
   standard deviations of the displacement for a backlash, a third of a millisecond for a lag,
   and it is not an effect with fewer parameters, as a softening that heals in hours,
5. it drives no parameter of the base model onto a bound that it was not near before,
6. what acts in the air too is seen there: in contact alone it would be a law of the contact,
7. it gains what another form of the accepted effects, in channels that did not determine them, does not gain.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from vegrip.effects import Effect
from vegrip.identification.diagnosis import thresholds
from vegrip.identification.diagnosis.candidate_fit import CandidateFit
from vegrip.identification.diagnosis.score_tests import Candidate
from vegrip.identification.fit.problem import AT, FIRM
from vegrip.model import BASE
from vegrip.types import Floats

OF_EPISODES = ("held-out episodes", "one episode only")  # the gate 2
FORM = "form of what is accepted"  # the gate 7


@dataclass(frozen=True)
class Verdict:
    """Gains of a candidate, and the gates that it ``failed``."""

    gain: float  # of evidence [nats]
    heldout: float  # of held-out score [nats]
    failed: tuple[str, ...]

    @property
    def is_passed(self) -> bool:
        return not self.failed


def judge_candidate(
    candidate: Candidate,
    base: CandidateFit,
    new: CandidateFit,
    regimes: tuple[float, float],
    pays: float = thresholds.MIN_GAIN_NATS,
    left: float = math.inf,
    form: Floats | None = None,
) -> Verdict:
    """Judge a candidate.

    ``regimes`` are the chi-squares per regime of the misfit before and after, ``pays`` and ``left`` [nats]
    what it has to gain and what there is to be gained, ``form`` that of accepted effects in other channels.
    """
    gain = new.evidence - base.evidence
    change = new.heldout - base.heldout
    failed = []
    if not gain > max(pays, candidate.effect.min_gain):
        failed.append("evidence")
    up, down = float(change[change > 0.0].sum()), -float(change[change < 0.0].sum())
    before, after = (one > thresholds.MAX_NOISE_CHI2 for one in regimes)
    takes_most = gain >= thresholds.MOST_OF_LEFT_SHARE * left > 0.0
    may_lose = thresholds.MAX_LOST_SHARE_OF_MOST if takes_most and before else thresholds.MAX_LOST_SHARE
    if not (up > down and down <= may_lose * up + thresholds.CHANCE_NATS):
        failed.append(OF_EPISODES[0])
    if change.size > 2 and not float(change.sum() - change.max()) > 0.0:
        failed.append(OF_EPISODES[1])
    # among regimes that all are noise it is chance which has the lesser misfit
    if not (regimes[1] < regimes[0] or (takes_most and before >= after)):
        failed.append("regimes")
    if not new.error < base.error:
        failed.append("error")
    if not is_resolved(candidate, new):
        failed.append("resolution")
    if drives_onto_bound(candidate, base, new):
        failed.append("bounds")
    if candidate.effect.in_air and not gain_in_air(base, new) > thresholds.CHANCE_NATS:
        failed.append("air")
    if form is not None and form.size and gain_beside(base, new, form) < thresholds.MIN_LATER_GAIN_NATS:
        failed.append(FORM)
    return Verdict(gain, float(change.sum()), tuple(failed))


def form_directions(accepted: Iterable[Effect], fitted: CandidateFit) -> Floats:
    """Return what a fit and the forms of its effects can do (rows and priors, directions), orthonormal.

    The form of ``accepted`` effects is what they may do in channels that did not show them; nothing is
    returned where they have none. An effect is known by its name in the channel that shows it. How it
    spreads to pulls, to twists and to the radius is the form of a law: as much per share of the force, or
    of the friction, that it changes. There it may do nothing or twice as much, but hardly tenfold:
    ``FORM_STD`` is the prior of its share, as the unknowns of the fit have theirs.
    """
    problem, u = fitted.problem, fitted.optimum.u
    m, n = problem.measured, len(problem.measured.recording)
    there = problem.table(u)
    load = np.maximum(there[:, AT["contact_force"]], FIRM * m.noise.normal_force)
    limits = there[:, (AT["limit_force"], AT["limit_torque"])]
    pulls, twists = (
        np.nan_to_num(there[:, AT[name]] / np.maximum(limits[:, i], 1e-300))[m.sliding] ** 2
        for i, name in enumerate(("tangential_force", "torque_z"))
    )
    twist = twists / np.maximum(pulls + twists, 1e-300)
    blocks = slice(n, n + m.sliding.size), slice(n + m.sliding.size, None)
    out: list[Floats] = []
    for one in accepted:
        absent = {p.symbol: p.null for p in one.parameters if p.null is not None}
        apart = there - problem.table(u, absent)
        force = apart[:, AT["normal_force"]] / load
        friction = np.nan_to_num(apart[:, AT["friction_coefficient"]] / there[:, AT["friction_coefficient"]])
        for block, values, std in (
            (blocks[0], force[m.sliding] * (1.0 - twist), problem.slip_std),
            (blocks[0], force[m.sliding] * twist, problem.slip_std),
            (blocks[0], friction[m.sliding] * twist, problem.slip_std),
            (blocks[1], force[m.seen] * there[m.seen, AT["contact_radius"]], problem.radius_std),
        ):
            column = np.zeros(fitted.optimum.residual.size)
            column[block] = np.nan_to_num(values) / std
            if column.any():
                out.append(column)
    if not out:
        return np.zeros((fitted.optimum.residual.size, 0))
    stds = np.r_[problem.unknowns.std, np.full(len(out), thresholds.FORM_STD)]
    free = np.column_stack([fitted.optimum.jacobian, *out])
    basis: Floats = np.linalg.qr(np.vstack([free, np.diag(1.0 / stds)]))[0]
    return basis


def gain_beside(base: CandidateFit, new: CandidateFit, form: Floats) -> float:
    """Return what the change that ``new`` makes gains [nats] beside ``form``, see :func:`form_directions`."""
    rows, priors = base.optimum.residual, np.zeros(form.shape[0] - base.optimum.residual.size)
    left, change = (
        one - form @ (form.T @ one) for one in (np.r_[rows, priors], np.r_[base.whitened(new) - rows, priors])
    )
    along = -float(change @ left)
    return max(along, 0.0) ** 2 / (2.0 * max(float(change @ change), 1e-300))


def gain_in_air(base: CandidateFit, new: CandidateFit) -> float:
    """Return what the rows without a contact gain [nats]."""
    air = np.flatnonzero(base.problem.stiffness == 0.0)
    before, after = base.optimum.residual[air], base.whitened(new)[air]
    return 0.5 * float(before @ before - after @ after)


def drives_onto_bound(candidate: Candidate, base: CandidateFit, new: CandidateFit) -> bool:
    """Whether the candidate drives a parameter of the base model onto its bound.

    Such a fit describes one recording and no other. A parameter that was near a bound by itself shows nothing
    about the candidate, nor does one of a law that it is confounded with and takes the place of; and effects
    that were added may well end at a bound, which is one of the laws that they can be.
    """
    firm = [e for e in base.problem.model.effects if e.name in BASE]
    own = {p.symbol for e in firm if e.name not in candidate.effect.confounded for p in e.parameters}
    there = _at_bounds(base, thresholds.NEAR_BOUND_STD)
    return bool((_at_bounds(new, thresholds.AT_BOUND_STD) - there) & own)


def _at_bounds(fitted: CandidateFit, within: float) -> set[str]:
    k, u = fitted.problem.unknowns, fitted.optimum.u
    near = within * k.std
    return {n for n, at in zip(k.names, (u - k.low < near) | (k.high - u < near), strict=True) if at}


def is_resolved(candidate: Candidate, new: CandidateFit) -> bool:
    """Whether any amount of the effect is more than the sensors resolve, and it is no simpler effect.

    Amounts that stand for each other, as those of a layer and of its core, are resolved together.
    """
    least_count, exceeding = candidate.effect.beyond_simpler
    if sum(new.value(symbol) > value for symbol, value in exceeding) < least_count:
        return False
    problem, noise = new.problem, new.problem.measured.noise
    amounts, noises = dict(candidate.effect.min_amounts), dict(candidate.effect.min_displacement_noises)
    places, away = [], []
    for p in candidate.effect.parameters:
        if p.null is None:
            continue
        j = problem.unknowns.names.index(p.symbol)
        least = amounts.get(p.symbol, 0.0)
        if p.symbol in noises:
            least = noises[p.symbol] * noise.displacement / problem.depth
        if abs(new.value(p.symbol) - p.null) > least:
            places.append(j)
            away.append(float(new.optimum.u[j]) - (math.log(p.null) if p.transform == "log" else p.null))
    if not places:
        return False
    covariance, amount = amount_covariance(candidate, new)[np.ix_(places, places)], np.array(away)
    return float(amount @ np.linalg.solve(covariance, amount)) > thresholds.MIN_STANDARD_ERRORS**2


def amount_covariance(candidate: Candidate, new: CandidateFit) -> Floats:
    """Return the covariance of the coordinates, what only shapes the effect held.

    A rate and an amplitude of which only the product is known have no standard errors of their own, but the
    effect is there.
    """
    names = new.problem.unknowns.names
    shapes = {p.symbol for p in candidate.effect.parameters if p.null is None}
    free = [j for j, name in enumerate(names) if name not in shapes]
    out = np.zeros((len(names), len(names)))
    out[np.ix_(free, free)] = np.linalg.inv(new.information[np.ix_(free, free)])
    return out


def misfit_by_regime(residual: Floats, regimes: Floats, weights: Floats | None = None) -> float:
    """Return chi-square per regime of the summed whitened residuals: 1 is noise.

    ``regimes`` (rows,) numbers them, negative where there is none. Sums, because noise averages out of them
    and a misfit does not. ``weights`` (rows,) of the residuals, 1 when not given.
    """
    keep = regimes >= 0
    numbers, w = regimes[keep].astype(np.int64), np.ones(residual.size) if weights is None else weights
    total = np.bincount(numbers, weights=(w * residual)[keep])
    power = np.bincount(numbers, weights=(w * w)[keep])
    there = np.bincount(numbers) >= 10
    return float(np.mean(total[there] ** 2 / power[there])) if there.any() else 1.0
