"""Run a node over a recording."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import can
import numpy as np

from vegrip.clock import NS, Clock, SimulatedClock
from vegrip.config import read_toml
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.session import merge_states
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import (
    OF_NODES,
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    Message,
    ModelHealth,
    SlipMargin,
)
from vegrip.runtime import NodeContext
from vegrip.runtime.node import NodeBase, find_program
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.can_port import message_of
from vegrip.transport.canbus.bus_events import BusLoad
from vegrip.transport.canbus.frame_time import BitTiming, typical_duration
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.endpoint import Endpoint


@dataclass(slots=True)
class FingerSummary:
    """Counts and extremes of one finger; feed it every message in the order of the bus."""

    samples: int = 0
    commands: int = 0
    contact_time: float = 0.0  # [s]
    duration: float = 0.0  # [s]
    force_error: float = 0.0  # [N^2] sum over contact of (estimate - measurement)^2
    force_count: int = 0
    lowest_bound: float = math.inf
    highest_command: float = -math.inf
    nis_sum: float = 0.0
    nis_count: int = 0
    judged: int = 0  # health reports with a verdict
    consistent: int = 0
    rejected: int = 0
    conditions: Counter[str] = field(default_factory=Counter)
    failing: Counter[str] = field(default_factory=Counter)  # "channel, regime"
    suspects: Counter[str] = field(default_factory=Counter)
    last: ContactEstimate | None = None
    gaps: Sequence[tuple[int, int]] = ()  # [ns] between trials: no input is missing then
    _state: FingertipState | None = None

    def take(self, message: Message) -> None:
        if isinstance(message, FingertipState):
            self._count_state(message)
        elif isinstance(message, ContactEstimate):
            self._count_contact(message)
        elif isinstance(message, SlipMargin):
            if self.last is not None and self.last.in_contact and not math.isnan(message.lower_bound):
                self.lowest_bound = min(self.lowest_bound, message.lower_bound)
        elif isinstance(message, ForceCommand):
            self.commands += 1
            self.highest_command = max(self.highest_command, message.normal_force)
        elif isinstance(message, ModelHealth):
            self._count_health(message)

    def as_dict(self) -> dict[str, Any]:
        last = self.last or ContactEstimate(0, "", 0)
        square = self.force_error / self.force_count if self.force_count else math.nan
        return {
            "samples": self.samples,
            "duration": self.duration,
            "contact_time": self.contact_time,
            "force_rms": _known(math.sqrt(square)),
            "nis": _share(self.nis_sum, self.nis_count),
            "consistent": _share(self.consistent, self.judged),
            "rejected": self.rejected,
            "conditions": dict(self.conditions.most_common()),
            "failing": dict(self.failing.most_common()),
            "suspects": dict(self.suspects.most_common()),
            "lowest_margin_bound": _known(self.lowest_bound),
            "commands": self.commands,
            "highest_command": _known(self.highest_command),
            "pressure_exponent": _estimate(last.pressure_exponent),
            "friction_coefficient": _estimate(last.friction_coefficient),
        }

    def _count_state(self, state: FingertipState) -> None:
        if self._state is not None:
            step = (state.stamp - self._state.stamp) / NS
            self.duration += step
            recorded = not any(begin <= self._state.stamp < end for begin, end in self.gaps)
            if self.last is not None and self.last.in_contact and recorded:
                self.contact_time += step
        self.samples += 1
        self._state = state

    def _count_contact(self, contact: ContactEstimate) -> None:
        self.last = contact
        force = contact.normal_force
        if self._state is None or not contact.in_contact or math.isnan(self._state.normal_force):
            return
        error = force.value - self._state.normal_force
        self.force_error += error * error
        self.force_count += 1

    def _count_health(self, health: ModelHealth) -> None:
        if not any(begin < health.stamp < end for begin, end in self.gaps):
            self.conditions[health.condition.name.lower()] += 1
        self.rejected = health.rejected
        if math.isnan(health.nis) or self.last is None or not self.last.in_contact:
            return
        self.nis_sum += health.nis
        self.nis_count += 1
        if health.consistent:
            self.consistent += 1
        elif health.channel:  # else there is not enough to judge by
            self.failing[f"{health.channel}, {health.regime}"] += 1
            self.suspects[health.suspect or "none"] += 1
        self.judged = self.consistent + self.failing.total()


def _share(part: float, whole: int) -> float | None:
    return _known(part / whole) if whole else None


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _estimate(estimate: Estimate) -> dict[str, Any]:
    return {"value": _known(estimate.value), "std": _known(estimate.std), "valid": estimate.valid}


Keep = Callable[[Message], None]


class RecordedBus(Endpoint):
    """An endpoint that receives a recording and keeps what the node sends.

    Every state is encoded, carried and decoded as on a real bus, so that the node sees what the wire leaves
    of it. What the node sends is encoded too, to count what the wire cannot carry; :attr:`keep` gets it as
    the node said it.
    """

    def __init__(
        self,
        states: Iterable[FingertipState],
        fingers: Sequence[str],
        clock: SimulatedClock,
        keep: Keep,
        *,
        fd: bool = True,
    ) -> None:
        self.arrivals: Sequence[int] = ()
        self._states = iter(states)
        self._next = next(self._states, None)
        self._clock = clock
        self._keep = keep
        self._hand, self._node = CanCodec(fingers, fd=fd), CanCodec(fingers, fd=fd)
        self._timing = BitTiming()
        self._load = BusLoad()
        self.busy = 0  # [ns] for which the bus was busy

    @property
    def finished(self) -> bool:
        return self._next is None

    @property
    def rejected(self) -> Mapping[str, int]:
        clipped = self._hand.clipped + self._node.clipped
        return {**self._node.rejected, **{f"clipped {name}": n for name, n in clipped.items()}}

    def receive(self, timeout: float) -> Sequence[Message]:
        """Move the clock to the next state, at most by ``timeout`` [s]; return what that state became."""
        deadline = self._clock.now() + round(timeout * NS)
        if self._next is None or self._next.stamp > deadline:
            self._clock.sleep_until(deadline)
            return self._arrived([])
        state, self._next = self._next, next(self._states, None)
        self._clock.sleep_until(state.stamp)
        return self._arrived(self._carried(state))

    def send(self, message: Message) -> None:
        for frame in self._node.encode(message):
            self._occupy(frame)
        self._keep(message)

    def bus_load(self) -> float:
        return self._load.share(self._clock.now())

    def close(self) -> None:
        """Nothing to release."""

    def _carried(self, state: FingertipState) -> list[Message]:
        now = self._clock.now()
        decoded = []
        for frame in self._hand.encode(state):
            self._occupy(frame)
            decoded.append(self._node.decode(frame._replace(stamp=now)))
        return [message for message in decoded if message is not None]

    def _arrived(self, messages: list[Message]) -> list[Message]:
        self.arrivals = [self._clock.now()] * len(messages)
        for message in messages:
            self._keep(message)
        return messages

    def _occupy(self, frame: Frame) -> None:
        duration = typical_duration(len(frame.data), frame.fd, self._timing)
        self.busy += duration
        self._load.add(self._clock.now(), duration)


Settings = dict[str, Any]
CHANNELS_OF_NOISE = (
    "normal_force",
    "displacement",
    "tangential_force",
    "torque_z",
    "contact_radius",
    "temperature",
)


def read_settings(path: Path | None) -> Settings:
    """Return the parameters of the node from a TOML file; a relative model file counts from that file."""
    settings = read_toml(path) if path is not None else {}
    tip = settings.get("tip")
    if path is not None and isinstance(tip, dict) and isinstance(tip.get("model"), str) and tip["model"]:
        tip["model"] = str(path.parent / tip["model"])
    return settings


def offline(settings: Mapping[str, Any]) -> Settings:
    """Return ``settings`` without the search for suspects, unless they ask for it.

    Its process answers in its own time: in simulated time that is after the end.
    """
    return {"suspects": False, **settings}


def with_recording(settings: Mapping[str, Any], recordings: Mapping[str, Recording]) -> Settings:
    """Return ``settings`` with what the recordings know of radius and noise, where they do not say it."""
    noise, tips = dict(settings.get("noise", {})), dict(settings.get("tips", {}))
    merged = {**settings, "noise": noise, "tips": tips}
    tip_says = {"radius", "model"} & settings.get("tip", {}).keys()
    for finger, recording in recordings.items():
        for name in CHANNELS_OF_NOISE:
            if name in recording.sensors:
                merged["noise"].setdefault(name, recording.sensors[name])
        radius = recording.fingertip.radius
        own = merged["tips"].get(finger, {})
        if not (math.isnan(radius) or tip_says or {"radius", "model"} & own.keys()):
            merged["tips"][finger] = {**own, "radius": radius}
    return merged


def grasp_node(
    settings: Mapping[str, Any], recordings: Mapping[str, Recording], program: str = "grasp_force"
) -> NodeBase:
    context = NodeContext(program, fingers=tuple(recordings))
    return find_program(program)(with_recording(settings, recordings), context)


LEAD_IN_NS = NS
"""[ns] from the activation of the node to t = 0 of the recording."""
FLUSH_EVERY = 5000  # messages


@dataclass(frozen=True)
class Outcome:
    """What came of a run."""

    fingers: Mapping[str, FingerSummary]
    rejected: Mapping[str, int]  # by the codecs and the node, by name
    bus_load: float  # mean share of the time for which a bus of 1 and 5 Mbit/s would be busy

    def as_dict(self) -> dict[str, Any]:
        fingers = {name: summary.as_dict() for name, summary in self.fingers.items()}
        return {"fingers": fingers, "rejected": dict(self.rejected), "bus_load": self.bus_load}


def gaps_of(recording: Recording, start: int) -> list[tuple[int, int]]:
    """Return when nothing was recorded, before and between trials [ns]; t = 0 is at ``start`` [ns]."""
    stamps = recording.stamps + start
    last = np.flatnonzero(np.diff(recording.episode) != 0)
    return [(0, int(stamps[0])), *((int(stamps[row]), int(stamps[row + 1])) for row in last)]


def run_through(
    node: NodeBase,
    recordings: Mapping[str, Recording],
    *,
    writer: RecordingWriter | None = None,
    fd: bool = True,
    loop: LoopSettings | None = None,
    at_end: Callable[[], None] | None = None,
) -> Outcome:
    """Send ``recordings`` (by finger) over a CAN bus to ``node`` in the loop that serves live data.

    The clock is simulated: the loop, its ticks and the stamps are as in real time, and nothing waits.
    ``writer`` gets every state as the node received it, and everything the node said, at the ``t`` of the
    recordings; ``at_end`` is called
    when the recording is over, while the node still knows what it has learned.
    """
    kept = 0

    def keep(message: Message) -> None:
        nonlocal kept
        if not isinstance(message, OF_NODES):
            summaries[message.finger].take(message)
        if writer is not None:
            writer.write(message)
            kept += 1
            if kept % FLUSH_EVERY == 0:
                writer.flush()

    clock = SimulatedClock()
    start = LEAD_IN_NS - min(int(recording.stamps[0]) for recording in recordings.values())
    summaries = {
        finger: FingerSummary(gaps=gaps_of(recording, start)) for finger, recording in recordings.items()
    }
    if writer is not None:
        writer.begin(start)
    bus = RecordedBus(merge_states(recordings, start), list(recordings), clock, keep, fd=fd)
    runner = Runner(node, bus, clock, loop)
    runner.start()
    while not bus.finished:
        runner.step()
    if at_end is not None:
        at_end()
    runner.change("shutdown")
    rejected = {**bus.rejected, **runner.managed.faults}
    return Outcome(summaries, rejected, bus.busy / max(clock.now(), 1))


def play_frames(
    frames: Iterable[Frame], send: Callable[[can.Message], None], clock: Clock, speed: float = 1.0
) -> int:
    """Send each of ``frames`` when its time has come, by its stamp [ns]; return how many there were.

    A frame that is late is sent at once, so the last comes when it would have.
    """
    count, start, first = 0, 0, 0
    for frame in frames:
        if not count:
            start, first = clock.now(), frame.stamp
        clock.sleep_until(start + round((frame.stamp - first) / speed))
        send(message_of(frame))
        count += 1
    return count
