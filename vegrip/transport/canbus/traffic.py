"""What hands put on a CAN bus, and whether it fits: identifiers and sizes are those of the DBC."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.errors import UsageError
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, ModelHealth, NodeStatus, SlipMargin
from vegrip.transport.canbus.frame_time import BitTiming, longest_duration, typical_duration
from vegrip.transport.codec.database import Layout, Part, layouts

HORIZON: Final = 0.25
"""[s] Whatever takes longer counts as never: no control waits for it."""
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


HAND, NODE = "hand", "grasp force node"
MOST_ROUNDS = 10


@dataclass(frozen=True)
class TrafficPlan:
    """What shall run on one bus."""

    fingers: int = parameter(5, low=1, high=8, doc="of each hand")
    hands: int = parameter(1, low=1, high=8, doc="on this bus, each with a grasp force node")
    fd: bool = parameter(True, doc="CAN FD layout; false: classic")
    rate: float = parameter(500.0, unit="Hz", low=0.1, high=10_000.0, doc="of states, and of commands")
    report_rate: float = parameter(50.0, unit="Hz", low=0.0, high=10_000.0, doc="of margins and estimates")
    health_rate: float = parameter(5.0, unit="Hz", low=0.0, high=10_000.0, doc="of the model's health")
    status_rate: float = parameter(1.0, unit="Hz", low=0.0, high=100.0, doc="of the status of each node")
    state_parts: int = parameter(2, low=1, high=3, doc="classic: frames of a state; 1 = forces only")
    bitrate: int = parameter(1_000_000, unit="bit/s", low=10_000, high=1_000_000, doc="nominal")
    data_bitrate: int = parameter(5_000_000, unit="bit/s", low=10_000, high=10_000_000, doc="of FD data")
    jitter: float = parameter(0.0, unit="s", low=0.0, high=1.0, doc="of the computers that send")

    @property
    def timing(self) -> BitTiming:
        return BitTiming(self.bitrate, self.data_bitrate)


@dataclass(frozen=True, slots=True)
class FrameRow:
    """One frame on the bus."""

    name: str  # as in the DBC
    owner: str  # "hand 0 finger 2", or the node
    identifier: int
    length: int  # [bytes]
    sender: str
    rate: float  # [Hz]
    longest: float  # [s] on the bus
    typical: float  # [s] on the bus
    wait: float = INFINITE  # [s] longest from its queuing to its arrival
    response: float = INFINITE  # [s] longest from the measurement to its arrival
    answers: int = -1  # identifier of the state it answers

    @property
    def fits(self) -> bool:
        return self.wait <= 1.0 / self.rate


@dataclass(frozen=True, slots=True)
class Forecast:
    """What will happen on the bus."""

    load: float  # [-] with data as they usually are
    worst_load: float  # [-] with the longest frames there can be
    rows: tuple[FrameRow, ...]  # most urgent first

    @property
    def fits(self) -> bool:
        return self.worst_load < 1.0 and all(row.fits for row in self.rows)


def forecast_traffic(plan: TrafficPlan, *, fifo: bool = True) -> Forecast:
    """Return load and worst-case response times of ``plan``; without ``fifo`` queues are by identifier."""
    frames = rows(plan)
    plain = [_stream(frame, plan.jitter) for frame in frames]
    # From an idle bus on, a state and the command that answers it go within one busy period.
    most = busy_period(plain) + plan.jitter if fifo else INFINITE
    jitters, responses = _in_turn(frames, plan, most, fifo_response_times if fifo else response_times)
    done = [
        replace(frame, response=response, wait=response - jitter if response < most else most)
        for frame, response, jitter in zip(frames, responses, jitters, strict=True)
    ]
    load = sum(frame.typical * frame.rate for frame in frames)
    return Forecast(load, utilisation(plain), tuple(done))


def _in_turn(
    frames: Sequence[FrameRow],
    plan: TrafficPlan,
    most: float,
    analyse: Callable[[list[Stream], float], list[float]],
) -> tuple[list[float], list[float]]:
    """Return jitter and response time of each frame: a command is queued late when its state comes late."""
    responses = [0.0] * len(frames)
    for _ in range(MOST_ROUNDS):
        came = {frame.identifier: response for frame, response in zip(frames, responses, strict=True)}
        jitters = [plan.jitter + _cause(frame, came) for frame in frames]
        streams = [_stream(frame, jitter) for frame, jitter in zip(frames, jitters, strict=True)]
        before, responses = responses, [min(most, r) for r in analyse(streams, 1.0 / plan.bitrate)]
        if before == responses:
            return jitters, responses
    return [plan.jitter] * len(frames), [most] * len(frames)


def rows(plan: TrafficPlan) -> list[FrameRow]:
    """Return the frames of ``plan``, most urgent first, still without response times."""
    known = layouts()
    if plan.fingers > known.fingers or plan.hands > known.hands:
        raise UsageError(f"the identifiers serve {known.hands} hands of {known.fingers} fingers")
    found = [
        row
        for layout in known.layouts
        if layout.fd == plan.fd
        for hand in range(plan.hands)
        for row in _rows_of(layout, plan, hand, known.hand_stride, known.finger_stride)
    ]
    return sorted(found, key=lambda row: row.identifier)


def _rows_of(
    layout: Layout, plan: TrafficPlan, hand: int, hand_stride: int, finger_stride: int
) -> list[FrameRow]:
    cls = layout.schema.cls
    rate = {
        ForceCommand: plan.rate,
        FingertipState: plan.rate,
        SlipMargin: plan.report_rate,
        ContactEstimate: plan.report_rate,
        ModelHealth: plan.health_rate,
        NodeStatus: plan.status_rate,
    }[cls]
    if rate <= 0.0:
        return []
    parts: Sequence[Part] = layout.parts
    if cls is FingertipState and not plan.fd:
        parts = parts[: plan.state_parts]
    if cls is NodeStatus:  # the finger's bits hold the number of the node
        senders = [(0, NODE), (1, HAND)]
    else:
        senders = [(finger, HAND if cls is FingertipState else NODE) for finger in range(plan.fingers)]
    answers = _last_part(FingertipState, plan) if cls is not FingertipState and cls is not NodeStatus else -1
    made = []
    for number, sender in senders:
        offset = hand * hand_stride + number * finger_stride
        owner = f"hand {hand}" + ("" if cls is NodeStatus else f" finger {number}")
        cause = -1 if answers < 0 else answers + offset
        made += [_row(part, offset, owner, f"{sender} {hand}", rate, plan, cause) for part in parts]
    return made


def _row(
    part: Part, offset: int, owner: str, sender: str, rate: float, plan: TrafficPlan, answers: int
) -> FrameRow:
    identifier = part.base + offset
    longest = longest_duration(identifier, part.length, plan.fd, plan.timing) / NS
    typical = typical_duration(part.length, plan.fd, plan.timing) / NS
    return FrameRow(
        part.name,
        owner,
        identifier,
        part.length,
        sender,
        rate,
        longest,
        typical,
        answers=answers,
    )


def _last_part(cls: type[object], plan: TrafficPlan) -> int:
    """Return the identifier, for finger 0 of hand 0, of the last part of a message of ``plan``."""
    for layout in layouts().layouts:
        if layout.fd == plan.fd and layout.schema.cls is cls:
            last = len(layout.parts) if plan.fd or cls is not FingertipState else plan.state_parts
            return layout.parts[last - 1].base
    raise UsageError(f"the layout has no {cls.__name__}")


def _stream(frame: FrameRow, jitter: float) -> Stream:
    return Stream(frame.identifier, frame.longest, 1.0 / frame.rate, jitter, frame.sender)


def _cause(frame: FrameRow, came: dict[int, float]) -> float:
    """Return how late the frame that ``frame`` answers may be [s]; what never comes delays nothing more."""
    late = came.get(frame.answers, 0.0)
    return late if late < INFINITE else 0.0
