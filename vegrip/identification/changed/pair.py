"""Two recordings under one model: what both have in common, and by how much the second may differ.

With the unknowns u in common and the differences d, most of them held at nothing,

    ``cost = |r_1(u)|^2 / (2 f_1) + |r_2(u + d)|^2 / (2 f_2) + priors``

r the whitened residuals of either, as in a fit. What a model leaves beyond noise goes together within an
episode, so rows carry less information than their number: f is the variance of the episodes' scores J' r over
that of independent rows, averaged over the unknowns [LiangZeger1986]_, and at least 1.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from vegrip.contact.limit_surface.fast import gauges
from vegrip.identification.diagnosis.candidate_fit import held_out_groups
from vegrip.identification.diagnosis.data_checks import TIP_RADIUS
from vegrip.identification.diagnosis.thresholds import AT_BOUND_STD
from vegrip.identification.fit.problem import AT, Problem
from vegrip.identification.fit.result import Fit
from vegrip.types import Floats

OF_SLIP = ("gain_tangential_force", "gain_torque_z")
LOG_SPAN = 1.0  # prior std of the logarithm of a gain or a radius, and a third of its bound
POWERS = {"K": 1.0, "K/x_ref": 1.0, "x_ref/K": -1.0}  # of K, in what the values of some parameters multiply
LEAST_SHOWN = 0.5  # of a prior std: what is known no better does not show
FREE_STEPS = 3  # of Gauss and Newton, with all differences free
HELD = 1e12  # times the information of a prior, for what is at a bound


class Gauged(Problem):
    """The problem with more unknowns: logarithms of the gains of the sensors, and of the radius of the tip.

    A gain of 1.1 reads a tenth too much; that of the force shows what presses while the contact slides, too.
    """

    def __init__(self, base: Problem, more: Iterable[str]) -> None:
        self.__dict__.update(base.__dict__)  # the same rows, noise and compiled model
        self.gains = {}
        for name in more:
            self.gains[name] = len(self.unknowns.names)
            self.unknowns = self.unknowns.with_one(name, -3.0 * LOG_SPAN, 3.0 * LOG_SPAN, LOG_SPAN)

    def _log(self, name: str, u: Floats) -> float:
        return float(u[self.gains[name]]) if name in self.gains else 0.0

    def parts(self, u: Floats) -> tuple[Floats, tuple[Floats, Floats]]:
        """Return the model's vector, with that radius, and the zeros (n,)."""
        vector, zeros = super().parts(u)
        vector[TIP_RADIUS] *= np.exp(self._log("tip_radius", u))
        return vector, zeros

    def table(self, u: Floats, instead: Mapping[str, float] | None = None) -> Floats:
        """Return the prediction (n, 14) as those sensors show it."""
        out, zero = super().table(u, instead), self.parts(u)[1][1]
        force = self._log("gain_normal_force", u)
        out[:, AT["normal_force"]] += np.expm1(force) * (out[:, AT["normal_force"]] - zero)
        fx, fy, torque = self._loads()
        slides = out[self.measured.sliding, AT["utilisation"]] > 0.0
        rows = self.measured.sliding[slides]
        limit, a, k = (out[rows, AT[n]] for n in ("limit_force", "contact_radius", "pressure_exponent"))
        pull, turn = (np.exp(force - self._log(name, u)) / limit for name in OF_SLIP)
        used = gauges(k, pull * np.hypot(fx, fy)[slides], turn / a * np.abs(torque[slides]))
        out[rows, AT["utilisation"]] = used
        out[:, AT["contact_radius"]] *= np.exp(self._log("gain_contact_radius", u))
        return out


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
    """Both recordings, linearised where they are; the differences have the names of the unknowns.

    A value that is a multiple of K stays in newtons while K differs: another pad is no other adhesion.

    Args:
        first, second: fits of one model; that of the second may have effects that the first has not.

    """

    def __init__(self, first: Fit, second: Fit) -> None:
        a, b = first.problem, second.problem
        at = dict(zip(b.unknowns.names, second.optimum.u, strict=True))
        if "zero_force" in at:
            at["zero_force"] *= b.load / a.load
        b.load = a.load  # so that the zeros of the force are in one unit
        self.first, self.second = a, Gauged(b, _gains(a, b))
        mine, its, gains = a.unknowns, self.second.unknowns, list(self.second.gains)
        more = [name for name in its.names if name not in (*mine.names, *gains)]
        common = {name: j for j, name in enumerate([*mine.names, *more])}
        self.kept = len(common)  # unknowns that are free whatever changed, before the differences
        self.names = (*mine.names, *gains)  # of the differences
        column = {name: self.kept + j for j, name in enumerate(self.names)}
        size = self.kept + len(column)
        self._maps = np.eye(len(mine.names), size), np.zeros((len(its.names), size))
        for row, name in enumerate(its.names):
            self._maps[1][row, [places[name] for places in (common, column) if name in places]] = 1.0
        of = {name: POWERS.get(a.model.parameters[name][1].of) for name in a.symbols}
        self._scaled = [  # row in the second, its power of K, and whether it is a logarithm
            (its.names.index(n), power, bool(mine.log[common[n]])) for n, power in of.items() if power
        ]
        self._K = column.get("K", 0)
        own, rows = ([its.names.index(name) for name in names] for names in (more, gains))
        self._prior = np.r_[mine.prior, its.prior[own], np.zeros(len(column))]
        self._std = np.r_[mine.std, its.std[own], mine.std, its.std[rows]]
        apart = [at[name] - u for name, u in zip(mine.names, first.optimum.u, strict=True)]
        self.root = np.ones(2)  # of f
        self.move(np.r_[first.optimum.u, [at[name] for name in more], apart, np.zeros(len(gains))])
        for _ in range(FREE_STEPS):  # so that no difference that is there counts as noise
            self.move(self.solved(range(len(self.names)))[0])
        ends = ((a, self.side(0, self.w)[0]), (self.second, self.side(1, self.w)[0]))
        self.root = np.sqrt([effective(problem, u) for problem, u in ends])
        self.move(self.w)
        stuck = self.stuck[self.kept :]
        stuck[: len(mine.names)] |= self.stuck[: len(mine.names)]
        each = range(len(self.names))
        shown = [self.std((j,))[0] < LEAST_SHOWN * self._std[self.kept + j] for j in each]
        self.questions = tuple(j for j in each if shown[j] and not stuck[j])
        """Differences that would show: places in ``names``."""

    def side(self, which: int, w: Floats) -> tuple[Floats, Floats]:
        """Return the unknowns of the first problem (0) or the second (1), and their derivative by w."""
        m = self._maps[which].copy()
        u, k = m @ w, (self.first, self.second)[which].unknowns
        for row, power, is_log in self._scaled if which and self._K else ():
            by = 1.0 if is_log else np.exp(-power * w[self._K])
            u[row] = u[row] - power * w[self._K] if is_log else u[row] * by
            m[row] *= by
            m[row, self._K] -= power if is_log else power * u[row]
        return np.clip(u, k.low, k.high), m

    def move(self, w: Floats) -> None:
        """Take the derivatives anew at ``w``: ``cost = w' G w / 2 - h' w`` but for a constant."""
        self.w, P = w, self._std**-2.0
        G, slope = np.diag(P), P * (w - self._prior)
        self.stuck, own = np.zeros((2, w.size), dtype=bool)
        for which, (problem, root) in enumerate(zip((self.first, self.second), self.root, strict=True)):
            u, m = self.side(which, w)
            r, k = problem.residual(u), problem.unknowns
            J = problem.jacobian(u, r) @ m / root
            G, slope = G + J.T @ J, slope + J.T @ r / root
            at_bound = np.minimum(u - k.low, k.high - u) < AT_BOUND_STD * k.std
            self.stuck |= (at_bound @ self._maps[which] > 0.0) & ~own
            own[: len(self.first.unknowns.names)] = True  # of the second, only what it has for itself
        self.G = G + np.diag(np.where(self.stuck, HELD * P, 0.0))
        self.h = self.G @ w - slope

    def solved(self, chosen: Iterable[int]) -> tuple[Floats, float]:
        """Return where the cost is least with only those differences, and that but for a constant [nats]."""
        at = [*range(self.kept), *(self.kept + j for j in chosen)]
        w = np.zeros_like(self.w)
        w[at] = np.linalg.solve(self.G[np.ix_(at, at)], self.h[at])
        return w, -0.5 * float(self.h @ w)

    def cost(self, chosen: Iterable[int]) -> float:
        return self.solved(chosen)[1]

    def std(self, chosen: tuple[int, ...]) -> Floats:
        """Return the standard errors of those differences."""
        at = [*range(self.kept), *(self.kept + j for j in chosen)]
        variance: Floats = np.diag(np.linalg.inv(self.G[np.ix_(at, at)]))[self.kept :]
        return np.sqrt(variance)


def _gains(one: Problem, other: Problem) -> list[str]:
    """Return what else may differ, of what both show."""
    slides = bool(one.measured.sliding.size and other.measured.sliding.size)
    sees = bool(one.measured.seen.size and other.measured.seen.size)
    of_radius = ["gain_contact_radius"] * sees + ["tip_radius"] * (slides or sees)
    return ["gain_normal_force", *OF_SLIP * slides, *of_radius]
