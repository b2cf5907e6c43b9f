"""A soft pad under an imposed indentation, with the exact recursion of its relaxation.

``N(t) = int g(t-s) dN_e(s)``, ``N_e = F0 (delta/d0)^p``, ``g = 1 - sum c_i (1 - exp(-nu_i t))``
([TiezziKao2007]_, eqs. (15) and (20)). With N_e linear in time within a step of dt, each branch
``q_i = c_i int exp(-nu_i (t-s)) dN_e(s)`` goes on exactly as

    ``q_i <- exp(-nu_i dt) q_i + c_i phi_i dN_e``,   ``phi_i = (1 - exp(-nu_i dt)) / (nu_i dt)``,
    ``N = (1 - sum c_i) N_e + sum q_i`` .

While the indentation stands still a step may be as long as one likes.
"""

import math
from dataclasses import dataclass

import numpy as np

TOTAL_SHARE = (0.3, 0.6)
"""Sum of the c_i [-] of the pads, as of the silicone, meat and skin of ``python -m validation.measured``."""
RATES = (0.01, 10.0)
"""Of the branches [1/s]."""
BRANCHES = 3
REFERENCE_DEPTH_M = 1e-3
HERTZ_EXPONENT = 2.0
"""Pressure exponent k: a held indentation keeps the profile of a fresh contact."""


@dataclass(frozen=True)
class Pad:
    """Shape and material of one pad."""

    radius: float  # [m] of its face
    stiffness: float  # [N] F0, the elastic force at REFERENCE_DEPTH_M
    exponent: float  # [-] p
    shares: tuple[float, ...]  # [-] c_i
    rates: tuple[float, ...]  # [1/s] nu_i
    friction: float  # [-] mu on this object

    def elastic_force(self, depth: float) -> float:
        """Return N_e [N] at an indentation [m]."""
        return float(self.stiffness * (max(depth, 0.0) / REFERENCE_DEPTH_M) ** self.exponent)

    def elastic_depth(self, force: float) -> float:
        """Return the indentation [m] at which N_e is ``force`` [N]."""
        return float(REFERENCE_DEPTH_M * (force / self.stiffness) ** (1.0 / self.exponent))

    def contact_radius(self, depth: float) -> float:
        """Return a [m] at an indentation [m]."""
        return math.sqrt(2.0 * self.radius * max(depth, 0.0))

    def left_after(self, time: float) -> float:
        """Return g(time) [-]."""
        return 1.0 + sum(c * math.expm1(-nu * time) for c, nu in zip(self.shares, self.rates, strict=True))


def draw_pad(rng: np.random.Generator) -> Pad:
    """Draw a pad of a material that no controller knows."""
    total, parts = rng.uniform(*TOTAL_SHARE), rng.dirichlet(np.ones(BRANCHES))
    rates = np.exp(rng.uniform(math.log(RATES[0]), math.log(RATES[1]), BRANCHES))
    return Pad(
        radius=float(rng.uniform(8e-3, 15e-3)),
        stiffness=math.exp(rng.uniform(0.0, math.log(4.0))),
        exponent=float(rng.uniform(1.4, 1.9)),
        shares=tuple(float(c) for c in total * parts),
        rates=tuple(float(nu) for nu in rates),
        friction=float(rng.uniform(0.45, 1.0)),
    )


class PressedPad:
    """A pad that is pressed, in the course of time."""

    def __init__(self, pad: Pad) -> None:
        self.pad = pad
        self.depth = 0.0  # [m]
        self._elastic = 0.0  # [N]
        self._fixed = 1.0 - sum(pad.shares)
        self._branches = [0.0] * len(pad.rates)  # [N]

    @property
    def force(self) -> float:
        """Normal force [N]; a pad does not pull."""
        return max(self._fixed * self._elastic + sum(self._branches), 0.0)

    def press(self, depth: float, dt: float) -> None:
        """Bring the indentation to ``depth`` [m] within ``dt`` [s]."""
        elastic = self._elastic if depth == self.depth else self.pad.elastic_force(depth)
        self._branches = self._after(elastic, dt)
        self.depth, self._elastic = depth, elastic

    def force_after(self, depth: float, dt: float) -> float:
        """Return the force [N] that :meth:`press` would lead to."""
        elastic = self.pad.elastic_force(depth)
        return max(self._fixed * elastic + sum(self._after(elastic, dt)), 0.0)

    def _after(self, elastic: float, dt: float) -> list[float]:
        gained, pad = elastic - self._elastic, self.pad
        return [
            math.exp(-nu * dt) * q - c * gained * math.expm1(-nu * dt) / (nu * dt)
            for q, c, nu in zip(self._branches, pad.shares, pad.rates, strict=True)
        ]
