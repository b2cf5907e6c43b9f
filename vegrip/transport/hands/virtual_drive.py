"""A simulated drive: jaws that close on what is between them, behind the protocol of its maker. Pure.

It answers what any client of that device asks, not only what its map says.
"""

import math
from abc import ABC, abstractmethod
from collections import Counter
from typing import Final

from vegrip.clock import NS
from vegrip.messages import FingertipState
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.maps.checksums import appended

NO_FRAME: Final = 0
"""Bytes that more are needed for, as the size of a request."""


class Simulated(ABC):
    """A device that answers, and sends a sample, ``latency`` [s] late, and is told forces."""

    def __init__(self, latency: float) -> None:
        self.counts: Counter[str] = Counter()
        """Of what it received: ``unknown_request``, and ``zero``, the times that it took its zero."""
        self.forces: dict[str, float] = {}
        """The force that each finger was last commanded [N]."""
        self._fresh: dict[str, float] = {}
        self._latency = round(latency * NS)
        self._received = bytearray()
        self._outbox: list[tuple[int, Frame]] = []

    @abstractmethod
    def take_in(self, frame: Frame, now: int) -> None:
        """Take bytes, and answer the requests that are whole with them."""

    @abstractmethod
    def due(self, now: int) -> list[Frame]:
        """Return what it sends up to ``now`` [ns]; on a byte stream only the data counts."""

    @abstractmethod
    def sense(self, state: FingertipState) -> None:
        """Take what a finger feels."""

    def taken(self) -> list[tuple[str, float]]:
        """Return the forces [N] that it was told since it was last asked."""
        found, self._fresh = list(self._fresh.items()), {}
        return found

    def _press(self, finger: str, force: float) -> None:
        if math.isfinite(force):
            self.forces[finger] = self._fresh[finger] = force

    def _say(self, frame: Frame, now: int) -> None:
        self._outbox.append((now + self._latency, frame))

    def _said_by(self, now: int) -> list[Frame]:
        sent = [frame for at, frame in self._outbox if at <= now]
        if sent:
            self._outbox = [each for each in self._outbox if each[0] > now]
        return sent


class Jaws:
    """Jaws that run to a place, or stop at what is between them.

    Places are counted as the device counts them, rising as the jaws close.
    """

    def __init__(self) -> None:
        self.place = self.target = 0.0
        self.speed = 0.0  # [counts/s]
        self.object_at: float | None = None
        self._then: int | None = None  # [ns]

    @property
    def holds(self) -> bool:
        return self.object_at is not None and self.place >= self.object_at and self.target > self.object_at

    @property
    def moves(self) -> bool:
        return not self.holds and self.place != self.target

    def go(self, now: int) -> None:
        """Move on up to ``now`` [ns]."""
        seconds = 0.0 if self._then is None else max(now - self._then, 0) / NS
        self._then = now
        step = self.speed * seconds
        self.place += min(max(self.target - self.place, -step), step)
        if self.object_at is not None and self.target > self.object_at:
            self.place = min(self.place, self.object_at)


class VirtualDrive(Simulated):
    """A drive that answers ``latency`` [s] late."""

    def __init__(self, plan: Plan, latency: float = 0.0) -> None:
        super().__init__(latency)
        self.jaws = Jaws()
        self.limits = plan.hand.drive
        self._fingers = [finger.name for finger in plan.fingers]

    def take_in(self, frame: Frame, now: int) -> None:
        """Take bytes, and answer the requests that are whole with them."""
        self.go(now)
        self._received += frame.data
        while self._received:
            size, answer = self.answered(bytes(self._received), now)
            if size == NO_FRAME:
                break
            del self._received[:size]
            if answer:
                self._say(Frame(-1, answer, False, now), now)
        for finger in self._fingers:
            self._press(finger, self.pressed())

    def due(self, now: int) -> list[Frame]:
        """Return what it sends up to ``now`` [ns]."""
        self.go(now)
        return self._said_by(now)

    def sense(self, state: FingertipState) -> None:
        """Take what a finger feels: where there is a force, there is an object."""
        if state.normal_force > 0.0 and self.jaws.object_at is None:
            self.jaws.object_at = self.jaws.place
        elif state.normal_force <= 0.0:
            self.jaws.object_at = None

    @abstractmethod
    def go(self, now: int) -> None:
        """Do what it does by itself up to ``now`` [ns]."""

    @abstractmethod
    def answered(self, data: bytes, now: int) -> tuple[int, bytes]:
        """Return how many bytes of ``data`` are done with, :data:`NO_FRAME` to wait, and the answer."""

    @abstractmethod
    def pressed(self) -> float:
        """Return the force that it presses with [N], 0 opened, NaN while it does not obey."""


class FramedDrive(VirtualDrive):
    """One whose messages begin with ``head``, say their length, and end with a checksum of two bytes."""

    head = b""
    length_at = 0  # [bytes] where two bytes have the length
    around = 0  # [bytes] of a message that its length does not count
    checksum = ""

    def answered(self, data: bytes, now: int) -> tuple[int, bytes]:  # noqa: ARG002 (its jaws have gone)
        if not data.startswith(self.head[: len(data)]):
            self.counts["unknown_request"] += 1
            return 1, b""
        size = self.around + int.from_bytes(data[self.length_at : self.length_at + 2], "little")
        if len(data) < self.length_at + 2 or len(data) < size:
            return NO_FRAME, b""
        body = data[: size - 2]
        return size, self.answer(body, is_sound=appended(self.checksum, body) == data[:size])

    @abstractmethod
    def answer(self, body: bytes, *, is_sound: bool) -> bytes:
        """Return what is answered to a message without its checksum."""
