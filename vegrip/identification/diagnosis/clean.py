"""Where the known physics holds: the widest range of one variable in which one set of numbers leaves noise.

A fit to all rows pays for a missing force with what it has: a zero, another exponent, a relaxation. So the
model is fitted to the rows on one side of a depth, an instant, a speed or a time in contact by themselves,
with the air that pins the zeros, and the side is widened until the numbers stop to hold. The range with most
rows in contact is reported: its numbers are what the others were before they were bent.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.compare.where import features_of, format_span
from vegrip.identification.diagnosis import thresholds
from vegrip.identification.diagnosis.candidate_fit import EVALUATIONS, CandidateFit, Weighted
from vegrip.identification.fit.result import rms
from vegrip.identification.fit.solve import refine_optimum, scaled
from vegrip.types import Floats

VARIABLES = ("indentation", "time", "speed", "time_in_contact")
SHARES = (0.15, 0.3, 0.5, 0.7, 0.85)  # of the rows in contact, on one side
OUTSIDE = 1e-3  # weight of what is left out
AT_SURFACE = 0.15  # of the greatest depth, to which air is near enough to feel the surface


@dataclass(frozen=True)
class Clean:
    """Range of a ``variable`` [its unit] in which the model holds, and what it is there."""

    variable: str
    low: float | None
    high: float | None
    share: float  # of the rows in contact
    error: float  # over the noise within, and
    beyond: float  # outside, with the same numbers
    parameters: dict[str, float]

    @property
    def note(self) -> str:
        return (
            f"one set of values holds {format_span(self.variable, self.low, self.high)} "
            f"({self.share:.0%} of the contact, {self.error:.2f} times the noise); "
            f"beyond, it leaves {self.beyond:.3g} times the noise"
        )

    def as_dict(self) -> dict[str, Any]:
        return asdict(self) | {"note": self.note}


def find_clean(fitted: CandidateFit) -> Clean | None:
    """Return the widest range in which the model of ``fitted`` holds; None where there is none."""
    problem = fitted.problem
    values = features_of(problem, fitted.optimum.u).values
    depth = values["indentation"]
    touching = (problem.stiffness > 0.0) & problem.used
    if not touching.any():
        return None
    clear = ~touching & (depth < -AT_SURFACE * float(np.nanmax(depth)))
    anew = scaled(problem, problem.unknowns.start)
    best: Clean | None = None
    for variable in VARIABLES:
        x = values[variable]
        for is_low in (True, False):
            u = fitted.optimum.u
            for share in SHARES:
                if best is not None and share <= best.share:
                    continue
                edge = float(np.quantile(x[touching], share if is_low else 1.0 - share))
                within = (x <= edge) if is_low else (x >= edge)
                kept, inside = clear | (within & touching), within & touching
                found = _fitted(fitted, u, kept, inside) or _fitted(fitted, anew, kept, inside)
                if found is None:
                    break
                u, error, beyond = found
                low, high = (None, edge) if is_low else (edge, None)
                best = Clean(
                    variable, low, high, float(np.mean(within[touching])), error, beyond, _named(fitted, u)
                )
    return best


def _fitted(
    fitted: CandidateFit, u: Floats, kept: NDArray[np.bool_], inside: NDArray[np.bool_]
) -> tuple[Floats, float, float] | None:
    problem, n = fitted.problem, kept.size
    weights = np.where(np.append(kept, np.zeros(problem.counted.size - n, dtype=bool)), 1.0, OUTSIDE)
    u = refine_optimum(Weighted(problem, weights), u, EVALUATIONS, near=0.5).u
    force = problem.residual(u)[:n]
    error, beyond = rms(force[inside]), rms(force[~kept & problem.used])
    return (u, error, beyond) if error <= thresholds.MAX_ERROR_BY_REGIME else None


def _named(fitted: CandidateFit, u: Floats) -> dict[str, float]:
    k = fitted.problem.unknowns
    return {
        name: float(np.exp(value) if log else value)
        for name, value, log in zip(k.names, u, k.log, strict=True)
    }
