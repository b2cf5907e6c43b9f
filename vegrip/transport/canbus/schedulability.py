"""Worst-case response times of the frames on a CAN bus.

With transmit queues ordered by identifier, the analysis of [DavisBurnsBrilLukkien2007]_: for frame ``m`` with
longest duration ``C``, period ``T``, jitter ``J`` of its queuing, blocked by at most one frame ``B`` of lower
priority,

    w_m(q) = B_m + q C_m + sum over k in hp(m) of ceil((w_m + J_k + tau) / T_k) C_k
    R_m = max over q of J_m + w_m(q) - q T_m + C_m ,

``q`` numbering the instances within the busy period. With queues in the order of sending (SocketCAN, and
the virtual bus), as in [DavisNavet2012]_, a frame queued at ``t`` waits for all that was queued in its node
before, and those for whatever is more urgent than the least urgent of the queue. A frame of another such
queue interferes later than it was queued, by the time for which it waited there, which is added to its
jitter. In any order of queues a frame is gone at the end of the bus's busy period,

    t = sum over all k of ceil((t + J_k) / T_k) C_k ,

and the smaller of both bounds is taken.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

HORIZON: Final = 0.25
"""[s] Whatever takes longer counts as never: no control waits for it."""
MOST_ROUNDS: Final = 10
ROUNDING: Final = 1e-9
INFINITE: Final = math.inf


@dataclass(frozen=True, slots=True)
class Stream:
    """Frames of one identifier that come again and again."""

    priority: int  # the identifier; the lower, the more urgent
    duration: float  # [s] of the longest frame, gap included
    period: float  # [s] shortest time between two
    jitter: float = 0.0  # [s] how much later than its period says it may be queued
    queue: str = ""  # the node that sends it


def utilisation(streams: Iterable[Stream]) -> float:
    """Return the share of time for which the bus is busy if every frame is as long as it can be."""
    return sum(stream.duration / stream.period for stream in streams)


def response_times(streams: Sequence[Stream], bit: float) -> list[float]:
    """Return how late [s] each stream can arrive after its period begins, queues ordered by identifier.

    Infinite where it is longer than ``HORIZON``. ``bit`` is the duration of a bit [s].
    """
    return [_by_priority(stream, streams, bit) for stream in streams]


def fifo_response_times(streams: Sequence[Stream], bit: float) -> list[float]:
    """Return what :func:`response_times` does, for queues in the order of sending."""
    whole = busy_period(streams)
    waits = dict.fromkeys({stream.queue for stream in streams}, 0.0)  # [s] from queuing to arrival
    for _ in range(MOST_ROUNDS):
        before = waits
        waits = {queue: min(_fifo_wait(queue, streams, before, bit), whole) for queue in waits}
        if waits == before:
            break
    else:
        waits = dict.fromkeys(waits, whole)
    return [stream.jitter + waits[stream.queue] for stream in streams]


def busy_period(streams: Sequence[Stream]) -> float:
    """Return for how long [s] the bus can be busy without a gap; no frame waits longer, in any order."""
    if utilisation(streams) >= 1.0:
        return INFINITE
    return _fixed_point(_sum(streams), lambda t: sum(_demand(stream, t) for stream in streams))


def _by_priority(stream: Stream, streams: Sequence[Stream], bit: float) -> float:
    higher = [other for other in streams if other.priority < stream.priority]
    blocking = max((other.duration for other in streams if other.priority > stream.priority), default=0.0)
    if utilisation([*higher, stream]) >= 1.0:
        return INFINITE
    busy = _fixed_point(stream.duration, _interfered(blocking, [*higher, stream], 0.0))
    if busy == INFINITE:
        return INFINITE
    worst = 0.0
    for q in range(max(1, math.ceil((busy + stream.jitter) / stream.period - ROUNDING))):
        start = blocking + q * stream.duration
        wait = _fixed_point(start, _interfered(start, higher, bit))
        worst = max(worst, stream.jitter + wait - q * stream.period + stream.duration)
    return worst


def _fifo_wait(queue: str, streams: Sequence[Stream], waits: Mapping[str, float], bit: float) -> float:
    own = [stream for stream in streams if stream.queue == queue]
    least_urgent = max(stream.priority for stream in own)
    others = [stream for stream in streams if stream.queue != queue]
    higher = [replace(s, jitter=s.jitter + waits[s.queue]) for s in others if s.priority < least_urgent]
    if utilisation([*higher, *own]) >= 1.0 or INFINITE in waits.values():
        return INFINITE
    blocking = max((other.duration for other in others if other.priority > least_urgent), default=0.0)
    busy = _fixed_point(_sum(own), _interfered(blocking, [*higher, *own], 0.0))
    return max(_sent_since(t, own, higher, blocking, bit) for t in _queued_until(busy, own))


def _queued_until(busy: float, own: Sequence[Stream]) -> set[float]:
    """Return the instants [s] at which frames of a queue come, from the start of its busy period on."""
    if busy == INFINITE:
        return {INFINITE}
    return {
        max(0.0, n * stream.period - stream.jitter)
        for stream in own
        for n in range(1 + math.floor((busy + stream.jitter) / stream.period))
    }


def _sent_since(
    t: float, own: Sequence[Stream], higher: Sequence[Stream], blocking: float, bit: float
) -> float:
    """Return how long [s] the last of the frames queued up to ``t`` [s] takes to arrive."""
    if t == INFINITE:
        return INFINITE
    last = min(stream.duration for stream in own)
    ahead = sum((1 + math.floor((t + s.jitter) / s.period + ROUNDING)) * s.duration for s in own)
    start = blocking + ahead - last
    return _fixed_point(start, _interfered(start, higher, bit)) + last - t


def _sum(streams: Iterable[Stream]) -> float:
    return sum(stream.duration for stream in streams)


def _interfered(start: float, higher: Sequence[Stream], bit: float) -> Callable[[float], float]:
    """Return ``w -> start`` and what is more urgent in the time ``w`` and one bit."""
    return lambda w: start + sum(_demand(other, w + bit) for other in higher)


def _demand(stream: Stream, time: float) -> float:
    """Return how much of ``time`` [s] the frames of ``stream`` can take."""
    return math.ceil((time + stream.jitter) / stream.period - ROUNDING) * stream.duration


def _fixed_point(start: float, function: Callable[[float], float]) -> float:
    """Return the smallest ``w >= start`` [s] with ``w = function(w)``; infinite beyond ``HORIZON``."""
    value = start
    while value <= HORIZON:
        following = function(value)
        if following <= value * (1.0 + ROUNDING):
            return value
        value = following
    return INFINITE
