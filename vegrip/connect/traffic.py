"""Traffic of a foreign hand: its signals over time and just now, and the states that a map makes of it."""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

import numpy as np

from vegrip.clock import NS
from vegrip.connect.guess import guesses
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.recording.report import WARNED_SHARE, LoadReport, gaps_of
from vegrip.messages import FingertipState
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.compiled import Read, compile_reader, groups_of
from vegrip.transport.mapped.plan import Plan, Slot
from vegrip.transport.maps.database import Database
from vegrip.transport.maps.signals import ForeignMessage, Signal
from vegrip.transport.maps.units import SI
from vegrip.types import Floats

MIN_PRESS_STATES: Final = 20  # below which a press does not show the sign of an indentation
OPPOSED: Final = -0.3  # correlation of force and indentation below which one of them has the wrong sign
HIDDEN: Final = ("counter", "checksum", "command")

Row = tuple[str, str, float, str]
"""Finger or message, channel or signal, value, unit."""


@dataclass(frozen=True, slots=True)
class Trace:
    """One signal over time."""

    t: Floats  # [s] from the first frame of the traffic
    value: Floats  # physical, in the unit of the database
    raw: Floats

    def within(self, window: tuple[float, float]) -> Floats:
        """Return the values in ``window`` [s]."""
        return self.value[(self.t >= window[0]) & (self.t <= window[1])]


@dataclass(slots=True)
class Traffic:
    """The frames of a hand by their identifiers."""

    frames: dict[int, list[Frame]] = field(default_factory=lambda: defaultdict(list))
    start: int = 0  # [ns]
    end: int = 0
    short: dict[str, int] = field(default_factory=dict)  # message -> frames without all of its signals
    report: LoadReport = field(default_factory=lambda: LoadReport(place="frame"))

    def add(self, frame: Frame) -> None:
        if not self.frames:
            self.start = frame.stamp
        self.end = max(self.end, frame.stamp)
        self.frames[frame.arbitration_id].append(frame)

    @property
    def duration(self) -> float:
        """[s] from the first to the last frame."""
        return (self.end - self.start) / NS


def rate_of(trace: Trace) -> float:
    """Return how often a signal comes [Hz], 0 when it is unknown."""
    if len(trace.t) < 3 or trace.t[-1] <= trace.t[0]:
        return 0.0
    steps, gaps = np.diff(trace.t), gaps_of(trace.t)
    return float((len(steps) - len(gaps)) / (steps.sum() - steps[gaps].sum()))


def traffic_of(frames: Iterable[Frame], report: LoadReport | None = None) -> Traffic:
    traffic = Traffic()
    traffic.report = report or traffic.report
    for frame in frames:
        traffic.add(frame)
    return traffic


def traces(traffic: Traffic, database: Database) -> dict[str, Trace]:
    """Return every signal that came, by MESSAGE.SIGNAL."""
    found: dict[str, Trace] = {}
    for message in database.messages.values():
        frames = traffic.frames.get(message.identifier, [])
        if not frames:
            continue
        read = _raw_reader(message)
        rows = np.full((len(frames), len(message.signals)), np.nan)
        for row, frame in zip(rows, frames, strict=True):
            values = row.tolist()
            read(frame.data[: message.length].ljust(message.length, b"\0"), values)
            row[:] = values
        if cut := _without_what_is_cut(message, frames, rows):
            traffic.short[message.name] = cut
        t = np.array([(frame.stamp - traffic.start) / NS for frame in frames])
        found |= {
            f"{message.name}.{signal.name}": _trace(signal, t, raw)
            for signal, raw in zip(message.signals.values(), rows.T, strict=True)
            if not np.all(np.isnan(raw))
        }
    return found


def _without_what_is_cut(message: ForeignMessage, frames: Sequence[Frame], rows: Floats) -> int:
    """Make missing in ``rows`` what short ``frames`` do not hold; return of how many frames."""
    sizes = np.array([len(frame.data) for frame in frames])[:, None]
    signals = message.signals
    ends = np.array([signals[name].end for name in signals])
    switched = np.array(
        [signals[one.selected_by].end if one.selected_by in signals else 0 for one in signals.values()]
    )
    is_cut = ~np.isnan(rows) & (sizes < np.maximum(ends, switched))
    rows[is_cut] = np.nan
    return int(np.count_nonzero(is_cut.any(axis=1)))


def measured(trace: Trace, signal: Signal, keys: Mapping[str, Any]) -> Trace:
    """Return ``trace`` without what is no measurement, as ``keys`` of the map and the database say."""
    if keys.get("all_is_measured"):
        return trace
    there = ~np.isin(trace.raw, keys.get("invalid") or signal.invalid)
    if signal.bounds is not None:
        there &= (trace.raw >= signal.bounds[0]) & (trace.raw <= signal.bounds[1])
    return Trace(trace.t[there], trace.value[there], trace.raw[there])


def _raw_reader(message: ForeignMessage) -> Read:
    signals = enumerate(message.signals.values())
    slots = [Slot(number, message.name, each.name, each, 1.0, 0.0) for number, each in signals]
    return compile_reader(message, groups_of(message, slots), 0)


def _trace(signal: Signal, t: Floats, raw: Floats) -> Trace:
    there = ~np.isnan(raw)
    return Trace(t[there], raw[there] * signal.scale + signal.offset, raw[there])


def without_what_is_none(
    received: Mapping[str, Trace], database: Database, keys: Mapping[str, Mapping[str, Any]]
) -> tuple[dict[str, Trace], dict[str, int]]:
    """Return the traces without values that are no measurement, and how many of each signal those are.

    ``keys`` are those of the map, by signal.
    """
    found = {
        name: measured(trace, database.signal(name), keys.get(name, {})) for name, trace in received.items()
    }
    lost = {name: len(received[name].t) - len(trace.t) for name, trace in found.items()}
    there = {name: trace for name, trace in found.items() if len(trace.t)}
    return there, {name: count for name, count in lost.items() if count}


class SignalsNow:
    """The signals of a database that may be of a fingertip, in its units."""

    def __init__(self, database: Database) -> None:
        wanted = [
            (one.message, one.signal)
            for one in guesses(database)
            if one.channel not in HIDDEN and not database.messages[one.message].asked
        ]
        messages = [
            database.messages[name] for name in database.messages if any(name == m for m, _ in wanted)
        ]
        self._wanted = wanted
        self._values = {
            each.identifier: (each, _raw_reader(each), [math.nan] * len(each.signals)) for each in messages
        }

    def update(self, frame: Frame) -> None:
        if frame.arbitration_id not in self._values:
            return
        message, read, values = self._values[frame.arbitration_id]
        if len(frame.data) >= message.length:
            read(frame.data[: message.length], values)

    def rows(self) -> list[Row]:
        return [
            (message.name, signal.name, raw * signal.scale + signal.offset, signal.unit)
            for message, _, values in self._values.values()
            for signal, raw in zip(message.signals.values(), values, strict=True)
            if (message.name, signal.name) in self._wanted
        ]


class MappedNow:
    """The channels of a map, in SI; a hand on a network has none here."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._codec = None if plan.hand.format else MappedCodec(plan)
        self._last: dict[str, FingertipState] = {}

    def update(self, frame: Frame) -> None:
        if self._codec is not None:
            self._last |= {state.finger: state for state in self._codec.decode_all(frame)}

    def rows(self) -> list[Row]:
        return [
            (finger.name, name, getattr(self._last.get(finger.name), name, math.nan), SI[name])
            for finger in self._plan.fingers
            for name in sorted(finger.measured)
        ]


Now: TypeAlias = SignalsNow | MappedNow


@dataclass(frozen=True, slots=True)
class Range:
    """The values of one channel; NaN where it was never measured."""

    least: float
    last: float
    largest: float


@dataclass(frozen=True, slots=True)
class Values:
    """The states of all fingers in some traffic, and what was refused of it."""

    states: Mapping[str, list[FingertipState]]
    rejected: Mapping[str, int]

    def of(self, finger: str, channel: str) -> Range:
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

    def absent(self, plan: Plan) -> dict[str, float]:
        """Return by a sentence which share of its states a channel is missing in, where it is too much."""
        found = {f"no state of {one.name} came": 1.0 for one in plan.fingers if one.name not in self.states}
        for finger in plan.fingers:
            states = self.states.get(finger.name, [])
            for channel in sorted(finger.measured - {"slip", "slip_speed"}) if states else ():
                there = np.isfinite([getattr(state, channel) for state in states])
                share = 1.0 - float(np.mean(there))
                if share > WARNED_SHARE:
                    count = np.count_nonzero(~there)
                    found[f"{finger.name}: {channel} has no value in {count} of {len(states)} states"] = share
        return found

    def implausible(self, *, is_by_options: bool) -> list[str]:
        """Return what contradicts itself; the remedy as options, or as keys of a map."""
        remedy = (
            "--set fingers.{0}.displacement.sign" if is_by_options else "sign of [fingers.{0}.displacement]"
        )
        return [
            sentence + remedy.format(finger)
            for finger in self.states
            if (sentence := self._backwards(finger))
        ]

    def _backwards(self, finger: str) -> str:
        both = np.array([(s.normal_force, s.displacement) for s in self.states[finger]])
        both = both[~np.isnan(both).any(axis=1)]
        pressing = both[both[:, 0] > 0.2 * both[:, 0].max()] if len(both) else both
        if len(pressing) < MIN_PRESS_STATES or not np.ptp(pressing[:, 0]) or not np.ptp(pressing[:, 1]):
            return ""
        if float(np.corrcoef(pressing.T)[0, 1]) > OPPOSED:
            return ""
        return f"{finger}: the indentation falls while the normal force grows; turn one round: "

    def recording(self, finger: str) -> Recording:
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
    return Values(states, {name: count for name, count in codec.rejected.items() if count})
