"""Traffic of a foreign hand over time: what a log or a live bus brought, as arrays of each signal."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from vegrip.clock import NS
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.compiled import compile_reader, groups_of
from vegrip.transport.mapped.database import Database, ForeignMessage, Signal
from vegrip.transport.mapped.plan import Slot
from vegrip.types import Floats


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
    """All frames that were heard, by identifier."""

    frames: dict[int, list[Frame]] = field(default_factory=lambda: defaultdict(list))
    start: int = 0  # [ns]
    end: int = 0
    order: list[int] = field(default_factory=list)  # identifiers as they came, of the first frames
    short: dict[str, int] = field(default_factory=dict)  # message -> frames shorter than the database says

    def add(self, frame: Frame) -> None:
        """Take in a frame."""
        if not self.frames:
            self.start = frame.stamp
        self.end = max(self.end, frame.stamp)
        self.frames[frame.arbitration_id].append(frame)
        if len(self.order) < 20_000:
            self.order.append(frame.arbitration_id)

    @property
    def duration(self) -> float:
        """[s] from the first to the last frame."""
        return (self.end - self.start) / NS


def rate_of(trace: Trace) -> float:
    """Return how often a signal comes [Hz], 0 when it is unknown."""
    if len(trace.t) < 3 or trace.t[-1] <= trace.t[0]:
        return 0.0
    return float((len(trace.t) - 1) / (trace.t[-1] - trace.t[0]))


def traffic_of(frames: Iterable[Frame]) -> Traffic:
    """Return the traffic that ``frames`` are."""
    traffic = Traffic()
    for frame in frames:
        traffic.add(frame)
    return traffic


def traces(traffic: Traffic, database: Database) -> dict[str, Trace]:
    """Return every signal that came, by MESSAGE.SIGNAL."""
    found: dict[str, Trace] = {}
    for message in database.messages.values():
        frames = [f for f in traffic.frames.get(message.identifier, []) if len(f.data) >= message.length]
        short = len(traffic.frames.get(message.identifier, [])) - len(frames)
        if short:
            traffic.short[message.name] = short
        if frames:
            found |= _of_message(message, frames, traffic.start)
    return found


def _of_message(message: ForeignMessage, frames: list[Frame], start: int) -> dict[str, Trace]:
    signals = list(message.signals.values())
    slots = [Slot(number, message.name, s.name, s, 1.0, 0.0) for number, s in enumerate(signals)]
    read = compile_reader(message, groups_of(message, slots), 0)
    rows = np.full((len(frames), len(slots)), np.nan)
    for row, frame in zip(rows, frames, strict=True):
        values: list[float] = [float("nan")] * len(slots)
        read(frame.data[: message.length], values)
        row[:] = values
    t = np.array([(frame.stamp - start) / NS for frame in frames])
    return {
        f"{message.name}.{signal.name}": _trace(signal, t, rows[:, number])
        for number, signal in enumerate(signals)
        if not np.all(np.isnan(rows[:, number]))
    }


def _trace(signal: Signal, t: Floats, raw: Floats) -> Trace:
    there = ~np.isnan(raw)
    return Trace(t[there], raw[there] * signal.scale + signal.offset, raw[there])
