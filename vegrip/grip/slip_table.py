"""Parameters of the margin grip from one number with a plain meaning: a slip in so many disturbed seconds.

``grip.slip_every`` is looked up in a table that was measured: how many seconds in which something acts on the
object pass for each slip, over the probability that the grip is asked for, with the other parameters as
they stand in :data:`MEASURED_WITH`. Between its rows ln(seconds) goes straight with the quantile of the
probability. A grasp of two fingers and one of more have their own tables.

The numbers are those of the scenarios of :mod:`vegrip.trials.closed_loop`: drives of 12 Hz, a
slip flag that is 20 ms late, objects whose friction is not known. Slower drives, faces that are more slippery
and rougher loads slip more often. ``python -m validation.controllers.slip_rate`` measures the rows.
They rest on few slips (36 of the pinch at 0.5 and 1 at 0.95 in 595 s; 2 and none of the hand in 240 s), and
are right within a factor of some three. Beyond the last row nothing was measured; its probability is taken.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from statistics import NormalDist
from typing import Any, Final

from vegrip.grip.policies.margin_grip import GripSettings

Row = tuple[float, float]
"""Probability [-], disturbed seconds for each slip [s]."""

PINCH: Final[Sequence[Row]] = ((0.5, 16.0), (0.7, 63.0), (0.8, 79.0), (0.9, 397.0), (0.95, 397.0))
HAND: Final[Sequence[Row]] = ((0.5, 96.0), (0.7, 160.0), (0.8, 160.0), (0.9, 480.0), (0.95, 480.0))
MOST_OF_A_PINCH = 2  # fingers

MEASURED_WITH: Final = {"wanted_margin": 0.15, "release_time": 0.3, "settle_time": 0.1}
"""Parameters that are taken with the probability; the package's defaults."""

DEFAULTS: Final = GripSettings()


def table_of(fingers: int) -> Sequence[Row]:
    return PINCH if fingers <= MOST_OF_A_PINCH else HAND


def probability_for(seconds: float, rows: Sequence[Row]) -> float:
    """Return the probability that gives a slip in so many disturbed ``seconds``, within what was measured."""
    quantile = NormalDist().inv_cdf
    before = rows[0]
    if seconds <= before[1]:
        return before[0]
    for row in rows[1:]:
        if seconds <= row[1]:
            part = math.log(seconds / before[1]) / math.log(row[1] / before[1])
            low, high = quantile(before[0]), quantile(row[0])
            return NormalDist().cdf(low + part * (high - low))
        before = row
    return before[0]


def derive_grip(grip: GripSettings, fingers: int) -> GripSettings:
    """Return ``grip`` with what ``slip_every`` asks for; what is not at its default there stays."""
    if grip.slip_every <= 0.0:
        return grip
    derived = MEASURED_WITH | {"probability": probability_for(grip.slip_every, table_of(fingers))}
    taken: dict[str, Any] = {
        name: value for name, value in derived.items() if getattr(grip, name) == getattr(DEFAULTS, name)
    }
    return replace(grip, **taken)


def describe_derived(grip: GripSettings, fingers: int) -> str:
    """Return what ``slip_every`` has given for so many fingers, in a sentence; "" where it is not set."""
    if grip.slip_every <= 0.0:
        return ""
    used, rows = derive_grip(grip, fingers), table_of(fingers)
    names = ("probability", *MEASURED_WITH)
    said = ", ".join(f"{name} {getattr(used, name):.3g}" for name in names)
    own = [name for name in names if getattr(grip, name) != getattr(DEFAULTS, name)]
    if own:
        said += f" ({', '.join(own)} as configured, so the number means less)"
    if not rows[0][1] <= grip.slip_every <= rows[-1][1]:
        said += f"; measured are {rows[0][1]:.0f} to {rows[-1][1]:.0f} s"
    return f"one slip in {grip.slip_every:g} disturbed seconds: {said}"
