"""Where a model fails: the regimes that hold most of what noise cannot explain, each as a sentence.

The misfit of a row is ``z^2 - 1``, z the residual over its standard deviation: zero on average where the
model is right. A regime is a phase, a third of a variable, or both; those are told that hold a large share
of the misfit in few rows, one after the other, each without the rows of those before.
"""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.compare.features import PHASES, Features
from vegrip.identification.compare.words import format_height, format_quantity, format_span
from vegrip.types import Floats

MAX_REGIMES = 6
LEAST_SHARE = 0.03
MIN_REGIME_ROWS = 10
OUT_OF_CONTACT = "out of contact"
EVERYWHERE = "everywhere"
SURE = 5.0  # standard deviations of a sum of squares of noise

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Regime:
    """A regime in which the model fails.

    Attributes:
        channel: whose residual.
        regime: short name.
        share: of all misfit of the recording.
        offset: mean of measured less model, in the unit of the channel.
        rms: of the residual there.
        rows: how many.
        note: a sentence.

    """

    channel: str
    regime: str
    share: float
    offset: float
    rms: float
    rows: int
    note: str

    def as_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of one channel: rows of the recording, in its unit, standardised."""

    channel: str
    rows: NDArray[np.int64]
    raw: Floats
    z: Floats


def where(residuals: list[Residuals], features: Features, most: int = MAX_REGIMES) -> list[Regime]:
    """Return the regimes that hold the misfit, largest share first; none where all is noise."""
    excess = [r.z**2 - 1.0 for r in residuals]
    sums = [float(e.sum()) for e in excess]
    total = sum(s for s, e in zip(sums, excess, strict=True) if s > SURE * math.sqrt(2.0 * max(e.size, 1)))
    count = sum(e.size for e in excess)
    if total <= 0.0:
        return []
    left = [np.ones(e.size, dtype=bool) for e in excess]
    found: list[Regime] = []
    candidates = [list(_candidates(r, features)) for r in residuals]
    while len(found) < most:
        best: tuple[float, int, str, Mask] | None = None
        for i, regimes in enumerate(candidates):
            for name, mask in regimes:
                here = mask & left[i]
                n = int(np.count_nonzero(here))
                if n < MIN_REGIME_ROWS:
                    continue
                share = float(excess[i][here].sum()) / total
                if share < LEAST_SHARE or share * total < SURE * math.sqrt(2.0 * n):
                    continue
                score = share * math.log(max(share, 1e-9) * count / n) if share * count > n else 0.0
                if best is None or score > best[0]:
                    best = (score, i, name, here)
        if best is None:
            break
        _, i, name, here = best
        found.append(_regime(residuals[i], name, here, float(excess[i][here].sum()) / total))
        left[i] &= ~here
    return sorted(found, key=lambda one: -one.share)


def _candidates(residuals: Residuals, features: Features) -> Iterator[tuple[str, Mask]]:
    """Yield names and rows: phases, thirds of each variable, and thirds within each phase."""
    phase = features.phase[residuals.rows]
    yield EVERYWHERE, np.ones(phase.size, dtype=bool)
    present = [p for p in range(len(PHASES)) if np.count_nonzero(phase == p) >= MIN_REGIME_ROWS]
    for p in present:
        yield PHASES[p], phase == p
    if (
        features.sticking is not None
        and np.count_nonzero(features.sticking[residuals.rows]) >= MIN_REGIME_ROWS
    ):
        yield "sticking", features.sticking[residuals.rows]
    for name, values in features.values.items():
        here = values[residuals.rows]
        for group in (None, *present):
            rows = np.ones(phase.size, dtype=bool) if group is None else phase == group
            for text, mask in _thirds(name, here, rows, is_away=group == PHASES.index(OUT_OF_CONTACT)):
                yield (text if group is None else f"{PHASES[group]} {text}"), mask


def _thirds(name: str, values: Floats, rows: Mask, *, is_away: bool) -> Iterator[tuple[str, Mask]]:
    said = format_height if is_away and name == "indentation" else partial(format_span, name)
    low, high = (float(q) for q in np.quantile(values[rows], (1.0 / 3.0, 2.0 / 3.0)))
    if values[rows].max() <= values[rows].min():
        return
    if low > values[rows].min():
        yield said(None, low), rows & (values <= low)
    if high > low > values[rows].min() and format_quantity(name, high) != format_quantity(name, low):
        yield said(low, high), rows & (values > low) & (values <= high)
    if high < values[rows].max() and format_quantity(name, high) != format_quantity(
        name, float(values[rows].max())
    ):
        yield said(high, None), rows & (values > high)


def _regime(residuals: Residuals, name: str, here: Mask, share: float) -> Regime:
    raw = residuals.raw[here]
    name = "elsewhere" if name == EVERYWHERE and here.size > np.count_nonzero(here) else name
    offset, rms = float(np.mean(raw)), math.sqrt(float(np.mean(raw**2)))
    if abs(offset) > 0.5 * rms:
        amount = format_quantity(residuals.channel, abs(offset))
        fails = f"the model reads {amount} {'low' if offset > 0 else 'high'}"
    else:
        fails = f"the model is {format_quantity(residuals.channel, rms)} off, now above and now below"
    if name.startswith(OUT_OF_CONTACT) and residuals.channel == "normal_force" and offset < -0.5 * rms:
        fails += " (a pull that it lacks)"
    note = f"{residuals.channel}, {name}: {fails}, {100.0 * share:.0f} % of the misfit"
    return Regime(residuals.channel, name, share, offset, rms, int(np.count_nonzero(here)), note)
