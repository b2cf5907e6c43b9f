"""Run a node over a recording."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vegrip.clock import NS, SimulatedClock
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.session import merge_states
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import Message, NodeStatus
from vegrip.runtime.node import Node
from vegrip.runtime.replay.bus import RecordedBus
from vegrip.runtime.replay.summary import FingerSummary
from vegrip.runtime.runner import LoopSettings, Runner

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
    node: Node,
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
        if not isinstance(message, NodeStatus):
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
