"""What hands put on a CAN bus, and whether it fits: identifiers and sizes are those of the DBC."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.errors import UsageError
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, ModelHealth, NodeStatus, SlipMargin
from vegrip.transport.canbus.frame_time import BitTiming, longest_duration, typical_duration
from vegrip.transport.canbus.schedulability import (
    INFINITE,
    Stream,
    busy_period,
    fifo_response_times,
    response_times,
    utilisation,
)
from vegrip.transport.codec.database import Layout, Part, layouts

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
    """Return load and worst-case response times of ``plan``.

    Args:
        plan: what runs.
        fifo: transmit queues in the order of sending (SocketCAN, the virtual bus); else by identifier.

    """
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
    """Return the frames of ``plan``, most urgent first, still without response times.

    Raises:
        UsageError: more fingers or hands than the identifiers can tell apart.

    """
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
