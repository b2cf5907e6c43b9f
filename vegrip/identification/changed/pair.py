"""Two recordings under one model: the values of the first, and by how much those of the second differ.

With the values u and the differences d, most of them held at nothing,

    ``cost = |r_1(u)|^2 / (2 f_1) + |r_2(u + d)|^2 / (2 f_2) + priors``

r the whitened residuals of either, as in a fit. What a model leaves beyond noise goes together within an
episode, so rows carry less information than their number: f is the variance of the episodes' scores J' r over
that of independent rows, averaged over the unknowns [LiangZeger1986]_, and at least 1.
"""

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from vegrip.contact.limit_surface.fast import gauges
from vegrip.identification.diagnosis.candidate_fit import held_out_groups
from vegrip.identification.diagnosis.data_checks import TIP_RADIUS
from vegrip.identification.diagnosis.thresholds import AT_BOUND_STD
from vegrip.identification.fit.problem import AT, Problem, Unknowns
from vegrip.identification.fit.result import Fit
from vegrip.model import ContactModel
from vegrip.parameters import SCALES, in_si
from vegrip.types import Floats

GAINS = ("gain_normal_force", "gain_tangential_force", "gain_torque_z", "gain_contact_radius", "tip_radius")
LOG_SPAN = 1.0  # prior std of the logarithm of a gain or a radius, and a third of its bound
LEAST_SHOWN = 0.5  # of a prior std: what is known no better does not show
FREE_STEPS = 3  # of Gauss and Newton, with all differences free
HELD = 1e12  # times the information of a prior, for what is at a bound


class Gauged(Problem):
    """The problem with more unknowns: logarithms of the gains of the sensors and of the radius of the tip.

    A gain of 1.1 reads a tenth too much; that of the force shows what presses while the contact slides, too.
    Values that are multiples of K are those of one ``K`` [N] instead: a softer pad is no other adhesion.
    """

    def __init__(self, base: Problem, K: float) -> None:
        self.__dict__.update(base.__dict__)  # the same rows, noise and compiled model
        self.K = K
        self.powers = {s: SCALES[p.of][1] for s, (_, p) in base.model.parameters.items() if p.of in SCALES}
        for name in GAINS:  # the last unknowns
            self.unknowns = self.unknowns.with_one(name, -3.0 * LOG_SPAN, 3.0 * LOG_SPAN, LOG_SPAN)

    def parts(self, u: Floats) -> tuple[Floats, tuple[Floats, Floats]]:
        """Return the model's vector, with that radius, and the zeros (n,)."""
        vector, zeros = super().parts(u)
        vector[TIP_RADIUS] *= np.exp(u[-1])
        for symbol, power in self.powers.items():
            vector[self.at(symbol)] *= (self.K / vector[self.at("K")]) ** power
        return vector, zeros

    def table(self, u: Floats, instead: Mapping[str, float] | None = None) -> Floats:
        """Return the prediction (n, 14) as those sensors show it."""
        out, zero = super().table(u, instead), self.parts(u)[1][1]
        of_force, of_pull, of_torque, of_radius, _ = u[-len(GAINS) :]
        out[:, AT["normal_force"]] += np.expm1(of_force) * (out[:, AT["normal_force"]] - zero)
        fx, fy, torque = self._loads()
        slides = out[self.measured.sliding, AT["utilisation"]] > 0.0
        rows = self.measured.sliding[slides]
        limit, a, k = (out[rows, AT[n]] for n in ("limit_force", "contact_radius", "pressure_exponent"))
        pull, turn = (np.exp(of_force - gain) / limit for gain in (of_pull, of_torque))
        used = gauges(k, pull * np.hypot(fx, fy)[slides], turn / a * np.abs(torque[slides]))
        out[rows, AT["utilisation"]] = used
        out[:, AT["contact_radius"]] *= np.exp(of_radius)
        return out


def vanishing(model: ContactModel, unknowns: Unknowns) -> tuple[Floats, Floats]:
    """Return the bounds, lower and upper, at which effects vanish; infinite where none does."""
    nulls = {symbol: parameter.null for symbol, (_, parameter) in model.parameters.items()}
    values = [(model.values.get(name), nulls.get(name)) for name in unknowns.names]
    is_least = [value is not None and value.low == null for value, null in values]
    is_most = [value is not None and value.high == null for value, null in values]
    return np.where(is_least, unknowns.low, -np.inf), np.where(is_most, unknowns.high, np.inf)


def effective(problem: Problem, u: Floats) -> float:
    """Return f, by how much less information the rows carry than their number."""
    r, groups = problem.residual(u), held_out_groups(problem)
    J = problem.jacobian(u, r)
    H = J.T @ J
    each = np.stack([J[groups == one].T @ r[groups == one] for one in np.unique(groups)])
    inverse = np.linalg.inv(H + np.diag(problem.unknowns.std**-2.0))
    scores = float(np.sum((each @ inverse) * each)) * len(each) / max(len(each) - 1, 1)
    return max(scores / float(np.sum(inverse * H)), 1.0)


class Pair:
    """Both recordings, linearised at ``w = (u - origin, d)``; what is not free is held at 0.

    Args:
        first, second: fits of one model.
        absent: of effects that the second shows alone: coordinates at which the first has none of them.

    """

    def __init__(self, first: Fit, second: Fit, absent: Mapping[str, float]) -> None:
        K = first.model.values["K"].value
        self.first, self.second = (Gauged(one.problem, K) for one in (first, second))
        self.second.load = self.first.load  # so that the zeros of the force are in one unit
        self.model, self.unknowns = second.problem.model, self.second.unknowns
        k = self.unknowns
        self.least, self.most = vanishing(self.model, k)
        self.names = ["zero_normal_force" if name == "zero_force" else name for name in k.names]
        self.comparable = [name for name in self.names if name not in absent]
        is_new, is_gain = (np.isin(k.names, list(some)) for some in (absent, GAINS))
        self.free = np.flatnonzero(np.r_[~is_new & ~is_gain, is_new])  # places in w, whatever changed
        here, there = (np.r_[one.optimum.u, np.zeros(len(GAINS))] for one in (first, second))
        here = np.array([absent.get(name, at) for name, at in zip(k.names, here, strict=True)])
        self.origin = here
        self._prior = np.r_[k.prior - here, np.where(is_new, k.prior - here, 0.0)]
        self._std = np.r_[k.std, k.std]
        self.root = np.ones(2)  # of f
        self.move(np.r_[0.0 * here, there - here])
        for _ in range(FREE_STEPS):  # so that no difference that is there counts as noise
            self.move(self.solved(self.comparable)[0])
        self.root = np.sqrt([effective(problem, u) for problem, u in self.sides(self.w)])
        self.move(self.w)
        self.questions = [name for name in self.comparable if self._shows(name)]

    def sides(self, w: Floats) -> list[tuple[Problem, Floats]]:
        """Return both problems, each with its unknowns."""
        u, d = np.split(w, 2)
        low, high = self.unknowns.low, self.unknowns.high
        both = (self.first, u), (self.second, u + d)
        return [(problem, np.clip(self.origin + step, low, high)) for problem, step in both]

    def move(self, w: Floats) -> None:
        """Take the derivatives anew at ``w``: ``cost = w' G w / 2 - h' w`` but for a constant."""
        self.w, P, k = w, self._std**-2.0, self.unknowns
        G, slope = np.diag(P), P * (w - self._prior)
        self.left = 0.0  # [nats]
        self.felt, self.stuck, gone = np.empty((3, 2, len(self.names)), dtype=bool)
        for i, ((problem, u), root) in enumerate(zip(self.sides(w), self.root, strict=True)):
            r = problem.residual(u)
            J = problem.jacobian(u, r) / root
            self.left += float(np.sum(problem.log_scale) + 0.5 * np.sum(r**2))
            self.felt[i] = J.any(axis=0)
            self.stuck[i] = np.minimum(u - k.low, k.high - u) < AT_BOUND_STD * k.std
            gone[i] = np.minimum(u - self.least, self.most - u) < AT_BOUND_STD * k.std
            J = np.hstack([J, i * J])  # the first knows of no difference
            G, slope = G + J.T @ J, slope + J.T @ r / root
        self.stuck &= self.stuck.all(axis=0) | ~gone.any(axis=0)  # what one alone shows is compared
        self.G = G + np.diag(np.where(self.stuck.ravel(), HELD * P, 0.0))
        self.h = self.G @ w - slope

    def _shows(self, name: str) -> bool:
        """Whether a difference would show in both."""
        j = self.names.index(name)
        is_known = bool(self.std([name])[0] < LEAST_SHOWN * self.unknowns.std[j])
        return is_known and bool(self.felt[:, j].all()) and not self.stuck[:, j].any()

    def _at(self, chosen: Iterable[str]) -> list[int]:
        return [*self.free, *(len(self.names) + self.names.index(name) for name in chosen)]

    def solved(self, chosen: Iterable[str]) -> tuple[Floats, float]:
        """Return where the cost is least with only those differences, and that but for a constant [nats]."""
        at, pinned = self._at(chosen), np.zeros(self.stuck.shape, dtype=bool)
        w = self._pinned(at, pinned)
        while (beyond := self._beyond(w) & ~pinned).any():
            pinned |= beyond
            w = self._pinned(at, pinned)
        return w, float(0.5 * w @ self.G @ w - self.h @ w)

    def _beyond(self, w: Floats) -> NDArray[np.bool_]:
        """Return which amounts of either (2, n) would be less than nothing."""
        every = self.origin + np.cumsum(np.split(w, 2), axis=0)
        is_less: NDArray[np.bool_] = (every < self.least) | (every > self.most)
        return is_less

    def _pinned(self, at: list[int], pinned: NDArray[np.bool_]) -> Floats:
        """Return where the cost is least with amounts of either (2, n) pinned at nothing."""
        w, n, G, h = np.zeros_like(self.w), len(self.names), self.G.copy(), self.h.copy()
        nothing = np.where(np.isfinite(self.least), self.least, self.most) - self.origin
        for i, j in np.argwhere(pinned):
            places, weight = [j, n + j][: i + 1], HELD * self._std[j] ** -2.0
            G[np.ix_(places, places)] += weight
            h[places] += weight * nothing[j]
        w[at] = np.linalg.solve(G[np.ix_(at, at)], h[at])
        for i, j in np.argwhere(pinned):
            w[i * n + j] = nothing[j] - i * w[j]  # exactly
        return w

    def cost(self, chosen: Iterable[str]) -> float:
        return self.solved(chosen)[1]

    def std(self, chosen: Iterable[str]) -> Floats:
        """Return the standard errors of those differences."""
        at = self._at(chosen)
        variance: Floats = np.diag(np.linalg.inv(self.G[np.ix_(at, at)]))[self.free.size :]
        return np.sqrt(variance)

    def is_log(self, name: str) -> bool:
        """Whether its coordinate is a logarithm, and each value a multiple of another."""
        return name in GAINS or bool(self.unknowns.log[self.names.index(name)])

    def in_si(self, name: str, coordinates: Floats) -> tuple[Floats, str]:
        """Return values in SI, and their unit; a gain is over that of the first."""
        problem, model = self.first, self.model
        units = {"zero_displacement": (problem.depth, "m"), "zero_normal_force": (problem.load, "N")}
        units["tip_radius"] = model.tip_radius, "m"
        if name in model.parameters:
            _, p = model.parameters[name]
            units[name] = in_si(p, 1.0, problem.K, model.reference_depth) or (1.0, p.unit)
        scale, unit = units.get(name, (1.0, "1"))
        return scale * (np.exp(coordinates) if self.is_log(name) else coordinates), unit
