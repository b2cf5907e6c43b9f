"""The hereditary integral, summed directly over the stored history of the load.

``N(t) = int_0^t g(t-s) dN_e(s)`` ([TiezziKao2007]_, eq. (20)). With N_e linear inside each step of length h,

    ``N_n = sum_j w_j (N_e[n-j] - N_e[n-j-1])``,   ``w_j = (1/h) int_{jh}^{(j+1)h} g(s) ds``

is exact. Nothing about g is used but its values, so a power law costs what an exponential costs.

The cost of one step is bounded: the last ``fine`` increments are kept one by one; older ones are merged into
blocks whose sum is taken at both ends of a block and interpolated; what is older than ``blocks`` blocks is
lumped at the last weight. :attr:`History.error_bound` states what that can cost.
"""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import kernels
from vegrip.virtual.kernels import Memory

Relaxation = Callable[[Floats], Floats]
"""Time since the step [s] -> share of the force that is left [-], element by element."""


def prony(amplitudes: Sequence[float], rates: Sequence[float]) -> Relaxation:
    """Return ``g(t) = 1 - sum_i c_i (1 - e^{-nu_i t})`` for amplitudes c_i [-] and rates nu_i [1/s]."""
    c, nu = np.asarray(amplitudes, float), np.asarray(rates, float)

    def g(t: Floats) -> Floats:
        left: Floats = 1.0 + np.expm1(-np.multiply.outer(t, nu)) @ c
        return left

    return g


def power_law(amplitude: float, time: float, exponent: float) -> Relaxation:
    """Return ``g(t) = 1 - A + A (1 + t/tau)^{-alpha}``: straight in log t for a small exponent alpha [-]."""

    def g(t: Floats) -> Floats:
        left: Floats = 1.0 - amplitude + amplitude * (1.0 + t / time) ** -exponent
        return left

    return g


class History:
    """The increments of N_e of n fingertips, and their relaxed sum.

    Args:
        relaxations: one g per fingertip.
        step: duration of a step [s].
        fine: increments kept one by one.
        block: increments merged into one block.
        blocks: blocks kept before lumping.

    """

    def __init__(
        self,
        relaxations: Sequence[Relaxation],
        step: float,
        fine: int = 1024,
        block: int = 32,
        blocks: int = 4096,
    ) -> None:
        self._step, self.fine, self.block = step, fine, block
        n = len(relaxations)
        self.recent = np.zeros((n, fine + block))
        self.filled = 0
        self._merged = np.zeros((n, blocks))  # newest block first
        self._lumped = np.zeros(n)
        self.memory = Memory(
            self.recent, np.zeros((n, fine + block - 1)), np.zeros(n), np.zeros(n), np.array([fine, block])
        )
        """What the compiled steps look at."""
        self.reweigh(relaxations)

    def reweigh(self, relaxations: Sequence[Relaxation]) -> None:
        """Take other relaxation functions for the same history (a warmer material relaxes faster)."""
        length, step = self.recent.shape[1], self._step
        self._weights = np.stack([_means(g, 0.0, step, length) for g in relaxations])
        self.memory.weights[:] = self._weights[:, :0:-1]
        start, long = (self.fine + 1) * step, self.block * step  # where the newest block begins
        blocks = self._merged.shape[1]
        self._block_weights = np.stack([_means(g, start, long, blocks + 1) for g in relaxations])
        never = np.array([1e300])
        self._final = np.array([float(g(never)[0]) for g in relaxations])
        self._sum_blocks()

    @property
    def instant(self) -> Floats:
        """Share of the increment of the present step that is felt at its end [-]; (n,)."""
        felt: Floats = self._weights[:, 0]
        return felt

    @property
    def error_bound(self) -> Floats:
        """Largest error per unit of total variation of N_e [-], for a g that falls and is convex; (n,)."""
        w = self._block_weights
        bound: Floats = 2.0 * (w[:, 0] - w[:, 1]) + (w[:, -1] - self._final)
        return bound

    def past(self) -> Floats:
        """Return what all earlier increments contribute at the end of the present step [N]; (n,)."""
        return kernels.summed_past(self.memory, self.filled)

    def append(self, increment: Floats) -> None:
        """Close the present step with the increment of N_e it brought [N]; (n,)."""
        self.recent[:, self.filled] = increment
        self.grow(1)

    @property
    def room(self) -> int:
        """How many steps may be written into ``recent`` before :meth:`grow` is called."""
        return self.recent.shape[1] - self.filled

    def grow(self, steps: int) -> None:
        """Count ``steps`` that were written into ``recent``; merge the oldest when it is full."""
        self.filled += steps
        if self.filled == self.recent.shape[1]:
            self._merge()

    def clear(self) -> None:
        """Forget everything: a fully recovered material."""
        for store in (self.recent, self._merged, self._lumped, self.memory.older, self.memory.newer):
            store[:] = 0.0
        self.filled = 0

    def _merge(self) -> None:
        oldest = self.recent[:, : self.block].sum(axis=1)
        left = self.filled - self.block
        self.recent[:, :left] = self.recent[:, self.block : self.filled].copy()
        self.filled = left
        self._lumped += self._block_weights[:, -1] * self._merged[:, -1]
        self._merged[:, 1:] = self._merged[:, :-1].copy()
        self._merged[:, 0] = oldest
        self._sum_blocks()

    def _sum_blocks(self) -> None:
        w = self._block_weights
        self.memory.older[:] = np.vecdot(self._merged, w[:, :-1]) + self._lumped
        self.memory.newer[:] = np.vecdot(self._merged, w[:, 1:]) + self._lumped


def _means(g: Relaxation, start: float, width: float, count: int) -> Floats:
    """Return the mean of g over ``count`` intervals of ``width`` [s] that follow ``start`` [s]."""
    x, weights = gauss_legendre(4)
    times = start + width * (np.arange(count)[:, None] + x)
    means: Floats = g(times) @ weights
    return means


@cache
def gauss_legendre(points: int) -> tuple[Floats, Floats]:
    """Return nodes and weights on 0..1, exact for polynomials of degree ``2 points - 1``."""
    x, w = np.polynomial.legendre.leggauss(points)
    return (x + 1.0) / 2.0, w / 2.0
