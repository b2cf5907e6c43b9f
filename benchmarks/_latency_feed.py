"""A hand that only plays states and waits for the commands: what it measures is what a hand would feel."""

import time
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.messages import FingertipState, ForceCommand, Message
from vegrip.runtime.statistics import Histogram, LoopStatistics
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.open import Hand, open_endpoint
from vegrip.virtual import HandSettings, VirtualHand

FINGERS = ("thumb", "index", "middle", "ring", "little")
CHANNELS = (
    "normal_force",
    "tangential_force_x",
    "tangential_force_y",
    "torque_z",
    "displacement",
    "temperature",
    "slip",
)
RATE = 500.0  # [Hz] of what was recorded; played slower or faster
GRIP = 3.0  # [N]
UNTIL_HELD = 1.5  # [s]
DEADLINE = 10_000_000  # [ns]
TAIL = 0.05  # [s] to wait for the last commands


@dataclass(frozen=True)
class Feed:
    """One hand on one link, played at several rates one after the other."""

    transport: Mapping[str, Any]
    fingers: int
    hand: int
    namespace: str
    rates: tuple[float, ...]  # [Hz]
    seconds: float  # of each rate that count
    warm: float  # [s] of each rate before them
    states: Path  # of :func:`record`


@dataclass(frozen=True)
class Felt:
    """Latencies of one rate: from a state handed to the link to its command received from it."""

    sent: int
    misses: int  # later than the deadline, or never
    counts: Histogram


def record(path: Path, seconds: float = 2.0) -> None:
    """Simulate a hand that holds an object, and keep its states as an array (time, finger, channel)."""
    hand = VirtualHand(HandSettings(), 1, ())
    forces = dict.fromkeys(FINGERS, GRIP)
    hand.step(UNTIL_HELD, forces)
    rows = [hand.step(1.0 / RATE, forces) for _ in range(round(seconds * RATE))]
    full = [row[: len(FINGERS)] for row in rows if len(row) >= len(FINGERS)]
    np.save(path, [[[getattr(state, name) for name in CHANNELS] for state in row] for row in full])


def feed(task: Feed) -> list[Felt]:
    """Play; may run in a process of its own."""
    names = FINGERS[: task.fingers]
    with closing(open_endpoint(task.transport, Hand(names, task.hand, task.namespace))) as endpoint:
        player = _Player(endpoint, names, _states(task.states))
        player.wait(1.0)  # until those who publish and subscribe have met
        return [player.play(rate, task.warm, task.seconds) for rate in task.rates]


class _Player:
    def __init__(self, endpoint: Endpoint, names: Sequence[str], states: NDArray[np.float64]) -> None:
        self._endpoint, self._names, self._rows = endpoint, names, states.tolist()
        self._seq = 0
        self._statistics = LoopStatistics(DEADLINE, 0)

    def play(self, rate: float, warm: float, seconds: float) -> Felt:
        due = time.monotonic_ns()
        for i in range(round((warm + seconds) * rate)):
            if i == round(warm * rate):
                self._statistics = LoopStatistics(DEADLINE, due)
            self._hear_until(due)
            self._send()
            due += round(NS / rate)
        self.wait(TAIL)
        felt = self._statistics
        never = max(felt.states - felt.commands, 0)
        return Felt(felt.states, felt.deadline_misses + never, felt.latency)

    def wait(self, seconds: float) -> None:
        self._hear_until(time.monotonic_ns() + round(seconds * NS))

    def _send(self) -> None:
        row = self._rows[self._seq % len(self._rows)]
        for name, values in zip(self._names, row, strict=False):
            now = time.monotonic_ns()
            self._statistics.state(name, now)
            measured = dict(zip(CHANNELS, values, strict=True))
            self._endpoint.send(FingertipState(now, name, self._seq, **measured))
        self._seq += 1

    def _hear_until(self, due: int) -> None:
        while (wait := due - time.monotonic_ns()) > 0:
            self._hear(self._endpoint.receive(wait / NS))

    def _hear(self, messages: Sequence[Message]) -> None:
        now = time.monotonic_ns()
        for message in messages:
            if isinstance(message, ForceCommand):
                self._statistics.command(message.finger, now)


@lru_cache(maxsize=1)
def _states(path: Path) -> NDArray[np.float64]:
    states: NDArray[np.float64] = np.load(path)
    return states
