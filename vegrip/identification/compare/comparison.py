"""A model against a recording: error of every channel, and where it fails."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from vegrip.identification.compare.where import Features, Regime, Residuals, features_of, where
from vegrip.identification.fit.fitting import solve
from vegrip.identification.fit.noise import Noise
from vegrip.identification.fit.problem import Problem, Zeros
from vegrip.identification.fit.result import ChannelError, channel_errors, loads_at_slip, overall_error
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel
from vegrip.types import Floats


@dataclass(frozen=True, eq=False)
class Comparison:
    """A model and a recording, at the coordinates that were compared."""

    problem: Problem  # with both
    u: Floats  # coordinates at which they were compared
    fitted: bool  # whether the model was fitted to this recording first

    @property
    def channels(self) -> dict[str, ChannelError]:
        return channel_errors(self.problem, self.u)

    @property
    def error(self) -> float:
        """Rms of the whitened residuals over all channels; 1 is the noise."""
        return overall_error(self.problem, self.u)

    @property
    def features(self) -> Features:
        return features_of(self.problem, self.problem.table(self.u))

    @property
    def where(self) -> list[Regime]:
        return where(residuals_of(self.problem, self.u), self.features)

    def as_dict(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        return {
            "recording": self.problem.measured.recording.name,
            "fitted": self.fitted,
            "error": self.error,
            "channels": {name: asdict(one) for name, one in self.channels.items()},
            "where": [asdict(one) for one in self.where],
        }


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

    Raises:
        RecordingError: the recording lacks what a comparison needs; says what.

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
