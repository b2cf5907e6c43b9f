"""A model against a recording: error of every channel, and where it fails."""

import math
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np

from vegrip.displayed import Result
from vegrip.identification.compare.where import EXCESS_STDS, Features, Regime, Residuals, features_of, where
from vegrip.identification.fit.fitting import solve
from vegrip.identification.fit.given import on_recording
from vegrip.identification.fit.noise import Noise, find_pairs
from vegrip.identification.fit.problem import Problem, Zeros
from vegrip.identification.fit.result import ChannelError, channel_errors, loads_at_slip, overall_error
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel
from vegrip.types import Floats


@dataclass(frozen=True)
class Repeated:
    """What of the misfit of the normal force recurs when a motion is repeated: that is not chance.

    Over rows of the same place in two episodes of one motion, z whitened and noise independent,
    ``share = E[z1 z2] / (E[z1^2 + z2^2] / 2 - 1)``: 1 for a misfit that the motion determines, 0 for chance.
    """

    pairs: int  # of replicate episodes
    share: float  # of what is left beyond noise
    std: float

    @property
    def note(self) -> str:
        cause = "the motion determines it" if self.share > 0.5 else "most of it is chance"
        pairs = f"{self.pairs} pair{'s' if self.pairs > 1 else ''} of replicate episodes"
        share = f"{100.0 * self.share:.0f} +- {100.0 * self.std:.0f} %"
        return f"{share} of the misfit of the force recurs in {pairs}: {cause}"

    def as_dict(self) -> dict[str, Any]:
        return asdict(self) | {"note": self.note}


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """A model and a recording, at the coordinates that were compared.

    Attributes:
        model: that was compared.
        recording: with which.
        error: rms of the whitened residuals over all channels; 1 is the noise.
        channels: error by channel, in its unit and over its noise.
        where: regimes in which the model fails, the largest share of the misfit first.
        repeated: what of the misfit recurs where a motion is repeated; None where none is.
        fitted: whether the model was fitted to this recording first.
        problem: both.
        u: coordinates at which they were compared.

    """

    _display: ClassVar[str] = "comparison"

    problem: Problem  # with both
    u: Floats  # coordinates at which they were compared
    fitted: bool  # whether the model was fitted to this recording first

    @property
    def model(self) -> ContactModel:
        return self.problem.model

    @property
    def recording(self) -> Recording:
        return self.problem.measured.recording

    @property
    def channels(self) -> dict[str, ChannelError]:
        return channel_errors(self.problem, self.u)

    @property
    def error(self) -> float:
        """Rms of the whitened residuals over all channels; 1 is the noise."""
        return overall_error(self.problem, self.u)

    @property
    def features(self) -> Features:
        return features_of(self.problem, self.u)

    @property
    def where(self) -> list[Regime]:
        return where(residuals_of(self.problem, self.u), self.features)

    @property
    def repeated(self) -> Repeated | None:
        """None where no episode is repeated, or no more than noise is left there."""
        measured = self.problem.measured
        pairs = find_pairs(measured.recording, measured.noise.displacement)
        if not pairs:
            return None
        one, other = (np.concatenate([getattr(pair, side) for pair in pairs]) for side in ("one", "other"))
        both = self.problem.used[one] & self.problem.used[other]
        z = self.problem.residual(self.u)
        a, b = z[one[both]], z[other[both]]
        left = (a**2 + b**2) / 2.0 - 1.0
        if left.sum() <= EXCESS_STDS * math.sqrt(a.size):
            return None
        share = float(a @ b / left.sum())
        std = math.sqrt(a.size) * float(np.std(a * b - share * left)) / float(left.sum())
        return Repeated(len(pairs), share, std)

    def as_dict(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        repeated = self.repeated
        return {
            "recording": self.problem.measured.recording.name,
            "fitted": self.fitted,
            "error": self.error,
            "channels": {name: asdict(one) for name, one in self.channels.items()},
            "where": [asdict(one) for one in self.where],
            "repeated": repeated.as_dict() if repeated is not None else None,
        }


@on_recording
def compare(
    recording: Recording,
    model: ContactModel | None = None,
    *,
    noise: Noise | None = None,
    zeros: Zeros = "recording",
    report: Report = lambda _: None,
) -> Comparison:
    """Compare ``model`` with ``recording``; only the zeros of the sensors are fitted.

    Without a model the paper's is fitted first.
    """
    problem, found = solve(recording, model, noise=noise, zeros=zeros, report=report, symbols=())
    return Comparison(problem, found.u, fitted=model is None)


def residuals_of(problem: Problem, u: Floats) -> list[Residuals]:
    """Return the residuals by channel, of the rows that count."""
    table = problem.table(u)
    raw = problem.raw(table)
    m = problem.measured
    z = problem.standardised(raw)
    n, k = len(m.recording), m.sliding.size
    used = np.flatnonzero(problem.used)
    out = [Residuals("normal_force", used, raw[0][used], z[used])]
    for name, size, rows in loads_at_slip(problem, table):
        out.append(Residuals(name, m.sliding[rows], (raw[1] * size)[rows], z[n : n + k][rows]))
    if m.seen.size:
        sure = np.isfinite(problem.radius_std)
        out.append(Residuals("contact_radius", m.seen[sure], raw[2][sure], z[n + k :][sure]))
    return out
