"""The zero of a sensor that jumps at one moment: a fault of the recording, which effects would imitate.

Of a jump at row ``k`` the whitened residual has the derivative ``z_k``, that of the zero from ``k`` on.
Beside what all other unknowns ``J`` can make up for, it gains

    ``(z_k' r)^2 / (2 z_k' P z_k)``,   ``P = 1 - J (J' J + S)^-1 J'``

at an optimum, where ``J' r`` is next to nothing; sums over the rows give it for every ``k`` at once.
"""

from dataclasses import dataclass, replace

import numpy as np

from vegrip.identification.diagnosis.candidate_fit import EVALUATIONS, CandidateFit
from vegrip.identification.fit.problem import FREE_ZERO, Problem
from vegrip.identification.fit.solve import refine_optimum
from vegrip.identification.recording import Recording
from vegrip.types import Floats

LEAST_ROWS = 100  # before and after a jump
LEAST_OWN_SHARE = 1e-4  # of a jump's derivative, for which nothing else can make up
STEPS = (10, 1)  # rows by which the moment is looked for, and how many of them to either side
AROUND = 10
NEAR = 10  # rows within which the recorded values say better where it is
SUDDEN = 4.0  # times the step before and after


@dataclass(frozen=True)
class Jump:
    """The zero of ``channel`` is ``size`` [SI] more from ``row`` on, which gains so much [nats]."""

    channel: str
    row: int
    at: float  # [s], of that row
    size: float
    gain: float

    def removed(self, recording: Recording) -> Recording:
        later = recording.t >= self.at
        column = recording.columns[self.channel] - self.size * later
        return replace(recording, columns={**recording.columns, self.channel: column})

    def __str__(self) -> str:
        name, unit = ("force", "N") if self.channel == "normal_force" else ("displacement", "m")
        return f"the zero of the {name} jumps by {self.size:.2g} {unit} at {self.at:.4g} s"


class Jumped(Problem):
    """The problem with one unknown more, the last: by how much the zero jumps, in its unit."""

    def __init__(self, base: Problem, channel: str, row: int) -> None:
        self.__dict__.update(base.__dict__)
        self.unknowns = base.unknowns.with_one("jump", -FREE_ZERO, FREE_ZERO, FREE_ZERO)
        self.scale = base.depth if channel == "displacement" else base.load
        self._later = self.scale * (np.arange(base.episodes.size) >= row)
        self._is_force = channel == "normal_force"

    def parts(self, u: Floats) -> tuple[Floats, tuple[Floats, Floats]]:
        """Return the model's vector and the zeros (n,) with the jump."""
        vector, (displacement, force) = super().parts(u)
        jump = u[-1] * self._later
        return vector, (displacement, force + jump) if self._is_force else (displacement + jump, force)


def find_jump(base: CandidateFit, least: float) -> Jump | None:
    """Return the jump of a zero that explains most of what ``base`` leaves, if it gains ``least`` [nats]."""
    channels = {"displacement": "zero_displacement", "normal_force": "zero_force"}
    names, J, r = base.problem.unknowns.names, base.optimum.jacobian, base.optimum.residual
    A = J.T @ J + np.diag(base.problem.unknowns.std**-2.0)
    own = {channel: [name.startswith(zero) for name in names] for channel, zero in channels.items()}
    gain, row, channel = max((*best_step(base.problem, J[:, own[c]].sum(axis=1), r, J, A), c) for c in own)
    if gain <= least:
        return None
    start = np.append(base.optimum.u, 0.0)
    u = refine_optimum(Jumped(base.problem, channel, row), start, EVALUATIONS).u
    for step in STEPS:  # for the derivative above is that of a zero which was never another
        last = base.problem.episodes.size - 1
        near = (min(max(row + step * i, 1), last) for i in range(-AROUND, AROUND + 1))
        row = min(near, key=lambda at: float(np.sum(Jumped(base.problem, channel, at).residual(u) ** 2)))
    row = _snapped(base.problem.measured.recording, channel, row)
    if any(one.begin - NEAR <= row <= one.end + NEAR for one in base.problem.measured.events):
        return None  # the contact slipped or tore there, which is reported by itself
    problem = Jumped(base.problem, channel, row)
    best = refine_optimum(problem, u, EVALUATIONS)
    gain = base.optimum.cost - best.cost
    at, size = float(base.problem.measured.recording.t[row]), float(best.u[-1]) * problem.scale
    return Jump(channel, row, at, size, gain) if gain > least else None


def best_step(problem: Problem, z: Floats, r: Floats, J: Floats, A: Floats) -> tuple[float, int]:
    """Return the most that ``z`` (rows,) gains [nats] from one row on, and that row."""
    order = np.argsort(problem.rows, kind="stable")
    rows, z = problem.rows[order], z[order]

    def later(values: Floats) -> Floats:
        return np.cumsum(values[::-1], axis=0)[::-1]

    power = later(z * z)
    left = power.copy()
    for along in np.linalg.inv(np.linalg.cholesky(A)):
        left -= later(z * (J @ along)[order]) ** 2  # one at a time: all take as much memory as J
    is_possible = (left > LEAST_OWN_SHARE * power[0]) & (rows >= LEAST_ROWS)
    is_possible &= rows < problem.episodes.size - LEAST_ROWS
    is_possible[1:] &= rows[1:] > rows[:-1]
    gain = np.where(is_possible, 0.5 * later(z * r[order]) ** 2 / np.where(is_possible, left, 1.0), 0.0)
    return float(gain.max()), int(rows[np.argmax(gain)])


def _snapped(recording: Recording, channel: str, row: int) -> int:
    """Return the row near ``row`` before which the values step as nowhere about it, else ``row`` itself."""
    low = max(row - NEAR, 1)
    steps = np.abs(np.nan_to_num(np.diff(recording.columns[channel][low - 1 : row + NEAR + 1])))
    at = int(np.argmax(steps))
    others = np.delete(steps, at)
    return low + at if others.size and steps[at] > SUDDEN * float(others.max()) else row
