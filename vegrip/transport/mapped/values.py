"""What a map makes of traffic: the range of each channel of each finger, in SI."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from vegrip.clock import NS
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.channels import CHANNELS
from vegrip.messages import FingertipState
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.mapped.traffic_log import Traffic

MIN_PRESS_STATES: Final = 20  # states of a press that tell nothing of its sign
CLEARLY: Final = 0.3  # of a correlation


@dataclass(frozen=True, slots=True)
class Range:
    """Of one channel; NaN where it was never measured."""

    least: float
    last: float
    largest: float


@dataclass(frozen=True, slots=True)
class Values:
    """Of all fingers."""

    states: Mapping[str, list[FingertipState]]
    rejected: Mapping[str, int]

    def of(self, finger: str, channel: str) -> Range:
        """Return the range of one channel."""
        found = np.array([getattr(state, channel) for state in self.states.get(finger, [])])
        found = found[~np.isnan(found)]
        if not len(found):
            return Range(math.nan, math.nan, math.nan)
        return Range(float(found.min()), float(found[-1]), float(found.max()))

    def rate(self, finger: str) -> float:
        """Return the states per second."""
        states = self.states.get(finger, [])
        if len(states) < 2 or states[-1].stamp <= states[0].stamp:
            return math.nan
        return (len(states) - 1) * NS / (states[-1].stamp - states[0].stamp)

    def implausible(self) -> list[str]:
        """Return what cannot be true of contact: an indentation that does not grow with the force."""
        return [sentence for finger in self.states if (sentence := self._backwards(finger))]

    def _backwards(self, finger: str) -> str:
        both = np.array([(s.normal_force, s.displacement) for s in self.states[finger]])
        both = both[~np.isnan(both).any(axis=1)]
        pressing = both[both[:, 0] > 0.2 * both[:, 0].max()] if len(both) else both
        if len(pressing) < MIN_PRESS_STATES or not np.ptp(pressing[:, 0]) or not np.ptp(pressing[:, 1]):
            return ""
        if float(np.corrcoef(pressing.T)[0, 1]) > -CLEARLY:
            return ""
        return (
            f"{finger}: the indentation falls while the normal force grows; turn one round in the map: "
            f"[fingers.{finger}.displacement] sign"
        )

    def recording(self, finger: str) -> Recording:
        """Return the states of a finger as a recording."""
        states = self.states[finger]
        t = np.array([(state.stamp - states[0].stamp) / NS for state in states])
        columns = {name: np.array([getattr(state, name) for state in states]) for name in CHANNELS}
        columns = {name: values for name, values in columns.items() if not np.all(np.isnan(values))}
        return Recording(finger, t, np.zeros(len(t), dtype=np.int64), columns, Fingertip(math.nan, finger))

    def as_dict(self) -> dict[str, Any]:
        """Return it for machines; a channel that was never measured is left out."""
        found: dict[str, Any] = {}
        for finger in self.states:
            ranges = {name: self.of(finger, name) for name in CHANNELS}
            found[finger] = {
                "rate": self.rate(finger),
                **{n: [r.least, r.last, r.largest] for n, r in ranges.items() if not math.isnan(r.last)},
            }
        return found


def values_of(plan: Plan, traffic: Traffic) -> Values:
    """Return what ``plan`` makes of ``traffic``, frame by frame in the order of time."""
    codec = MappedCodec(plan)
    states: dict[str, list[FingertipState]] = {}
    frames = sorted(
        (frame for one in traffic.frames.values() for frame in one), key=lambda frame: frame.stamp
    )
    for frame in frames:
        for state in codec.decode_all(frame):
            states.setdefault(state.finger, []).append(state)
    return Values(states, dict(codec.rejected))
