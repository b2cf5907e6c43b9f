r"""What is said to a device that does not send by itself: an opening, polls, its own zero, a closing. Pure.

::

    [device]
    opening = [{ text = "C", answer = "r,0,C,0", wait = 2.0 }, { data = "0D 0A" }]
    poll = [{ data = "55 AA 09 00", expects = "reading", every = 0.01 }]
    zero = [{ text = "z\n" }]
    closing = [{ text = "s\n" }]

Each entry has ``text``, or ``data`` in hexadecimal; on CAN an ``identifier`` beside it. The next entry of an
opening leaves when the ``answer`` has come, else after ``wait`` [s]; an opening that is not answered begins
anew, as does that of a device that has fallen silent. Polls take turns and never wait for commands; of those
that name the packet or frame that they ``expects`` one is out at a time, and one that is not answered within
``wait`` is counted as ``unanswered``. Commands whose packet names its ``answer`` take turns with polls: one
thing is out at a time, of a command only the newest is kept, and ``silence`` goes before each.

An entry of an opening may depend on conditions (:mod:`vegrip.transport.maps.conditions`)::

    opening = [
        { reads = "status" },
        { write = 0x03E8, data = "0100", unless = "activated", first = true },   # never again while it grips
        { reads = "status", until = "activated", every = 0.05, wait = 10.0 },
    ]
    ready = "activated"                      # without it the device is refused when it is opened
"""

from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from vegrip.clock import NS
from vegrip.config import build, parameter
from vegrip.errors import ConfigError
from vegrip.transport.canbus.frame_time import fd_size
from vegrip.transport.codec import Frame
from vegrip.transport.maps.checksums import APPENDED, appended
from vegrip.transport.maps.packets import on_bus

MOST_RECEIVED: Final = 512  # [bytes] in which an answer is looked for
PATIENCE: Final = 0.1  # [s] for what a poll expects, unless it says
PATIENCE_OPENING: Final = 1.0  # [s] for an answer to an opening
SILENT_AFTER: Final = 2 * NS  # [ns] without a sound packet: the device was reset, or is no longer there


@dataclass(frozen=True)
class DeviceMap:
    """``[device]``: what is said to it; entries as at the head of this module."""

    opening: tuple[Any, ...] = parameter((), doc="once, and again when the connection was lost")
    poll: tuple[Any, ...] = parameter((), doc="again and again")
    zero: tuple[Any, ...] = parameter((), doc="has it take its zero, when asked to (vegrip zero)")
    closing: tuple[Any, ...] = parameter((), doc="at the end")
    silence: float = parameter(0.0, unit="s", low=0.0, high=1.0, doc="of the line before each request")
    ready: str = parameter("", doc="the condition that must hold before it is used")
    patience: float = parameter(2.0, unit="s", low=0.0, high=60.0, doc="for an opening with 'ready'")
    offset: int = parameter(
        0, low=-0x7FF, high=0x7FF, doc="CAN: added to all identifiers, as for another hand"
    )

    @property
    def conditions(self) -> set[str]:
        """The names of those that it asks for."""
        entries = [entry for entry in self.opening if isinstance(entry, dict)]
        asked = [self.ready, *(entry.get(key) for entry in entries for key in ("unless", "until"))]
        return {name for name in asked if name and isinstance(name, str)}


@dataclass(frozen=True)
class _Entry:
    text: str = parameter("", doc="what is sent")
    data: str = parameter("", doc="what is sent, in hexadecimal")
    checksum: str = parameter("", choices=("", *APPENDED), doc="that is put behind it")
    zeros: int = parameter(0, low=0, high=64, doc="so many bytes of zero instead")
    identifier: int = parameter(-1, low=-1, high=(1 << 29) - 1, doc="on CAN")
    device: int = parameter(-1, low=-1, high=63, doc="which of the addresses; -1: each")
    answer: str = parameter("", doc="text of the answer")
    expects: str = parameter("", doc="poll: the packet or frame of the answer")
    every: float = parameter(0.0, unit="s", low=0.0, high=3600.0, doc="poll; 0: command.period")
    wait: float = parameter(0.0, unit="s", low=0.0, high=60.0, doc="for the answer, or before the next entry")
    unless: str = parameter("", doc="opening: left out when this condition holds")
    until: str = parameter("", doc="opening: said every ... until this condition holds")
    first: bool = parameter(False, doc="opening: not again when a connection was lost")


class Step(NamedTuple):
    """One thing to say."""

    data: bytes
    identifier: int  # -1: not on CAN
    answer: bytes
    expects: str
    every: int  # [ns]
    wait: int  # [ns]
    unless: str = ""
    until: str = ""
    first: bool = False

    @property
    def frame(self) -> Frame:
        """It as CAN carries it."""
        size = len(self.data)
        return Frame(self.identifier, self.data.ljust(fd_size(size), b"\0"), size > 8)


Order = Callable[[int], Sequence[Step]]
"""Makes a command of now [ns], and what is said after it; none when there is nothing to command."""


class Dialogue:
    """What is said to one device of a hand."""

    def __init__(
        self,
        spec: DeviceMap,
        device: int,
        period: float,  # [s] of polls that say none
        counts: Counter[str],
        where: str,
        *,
        on_can: bool = False,
        holds: Callable[[str], bool] = lambda _: False,  # whether a condition does
    ) -> None:
        self._silence = round(spec.silence * NS)
        self._holds = holds
        self._was_open = False
        self.opening, self.poll, self.zeroing, self.closing = (
            steps(entries, device, period, spec.offset if on_can else None, f"{where} [device] {name}")
            for name, entries in (
                ("opening", spec.opening),
                ("poll", spec.poll),
                ("zero", spec.zero),
                ("closing", spec.closing),
            )
        )
        self._counts = counts
        self.missed = 0
        """Polls without an answer: what has come of one is of no use to the next."""
        self.starts = 0
        self.start()

    def start(self) -> None:
        """Begin with the opening: the connection is new."""
        self.starts += 1
        self._begin()
        self._orders: dict[str, Order] = {}
        self._following: deque[Step] = deque()  # what is said after the last order
        self._is_poll_next = False
        self._quiet_until = 0  # [ns] the end of the silence on the line
        self._again = bool(self.opening)  # whether what is said is the opening
        self._awaited: Step | None = None
        self._until = 0  # [ns] the end of the present wait
        self._received = bytearray()
        self._asked: Step | None = None
        self._asked_until = 0
        self._turn = 0
        self._next = [0] * len(self.poll)
        self._has_come = True
        self._silent_at = 0  # [ns]

    def _begin(self) -> None:
        steps = (step for step in self.opening if not (step.first and self._was_open))
        self._said = deque(steps)  # and what else is said in order, once
        self._give_up_at = 0  # [ns] of the present step that waits for a condition

    def order(self, name: str, order: Order) -> None:
        """Say what ``order`` makes of the command ``name`` when it is its turn."""
        self._orders[name] = order

    @property
    def is_open(self) -> bool:
        return not self._said and self._awaited is None

    @property
    def is_begun(self) -> bool:
        """Whether an opening is under way that no condition has stopped yet."""
        return not self.is_open and self._give_up_at == 0

    def zero(self) -> bool:
        self._said.extend(self.zeroing)
        return bool(self.zeroing)

    def due(self, now: int) -> list[Step]:
        """Return what to say at ``now`` [ns]."""
        found: list[Step] = []
        if now < self._quiet_until:
            return found
        while now >= self._until and (self._asked is None or self._again):
            if self._awaited is not None and (self._awaited.answer or self._awaited.expects):
                self._counts["unanswered"] += 1
                if self._again:
                    self._begin()
            self._awaited = None
            while self._said and self._said[0].unless and self._holds(self._said[0].unless):
                self._said.popleft()
            if not self._said:
                self._was_open = self._was_open or self._again
                self._again = False
                break
            found.append(self._say(now))
        if self._again or (self._awaited is not None and not self.poll):
            return found
        return found + self._polled(now)

    def take_in(self, chunk: bytes, now: int) -> None:
        """Look for the answer that is waited for in what has come."""
        self._quiet_until = now + self._silence
        if self._awaited is None or not self._awaited.answer:
            return
        self._received += chunk
        if self._awaited.answer in self._received:
            self._awaited = None
            self._until = now
        del self._received[:-MOST_RECEIVED]

    def came(self, name: str, now: int) -> None:
        """Take note of a sound packet, or a frame."""
        self._has_come = True
        if self._asked is not None and self._asked.expects == name:
            self._asked = None
        awaited = self._awaited
        if awaited is None or not awaited.expects or awaited.expects != name:
            return
        self._awaited, self._until = None, now
        if not awaited.until or self._holds(awaited.until):
            self._give_up_at = 0
            return
        self._give_up_at = self._give_up_at or now + awaited.wait
        self._until += awaited.every
        if now < self._give_up_at:
            self._said.appendleft(awaited)
        else:
            self._counts["unanswered"] += 1
            self._begin()

    def is_silent(self, now: int) -> bool:
        """Whether nothing has come for long; the opening begins anew then, and ``silent`` is counted."""
        if self._has_come or not self.is_open:  # an opening takes its time
            self._has_come, self._silent_at = False, now + SILENT_AFTER
        if now < self._silent_at:
            return False
        self._counts["silent"] += 1
        self.start()
        return True

    def _say(self, now: int) -> Step:
        step = self._said.popleft()
        self._awaited = step
        self._received.clear()
        self._until = now + (round(PATIENCE * NS) if step.until else step.wait)
        return step

    def _polled(self, now: int) -> list[Step]:
        if self._asked is not None:
            if now < self._asked_until:
                return []
            self._counts["unanswered"] += 1
            self._asked = None
            self.missed += 1
        found: list[Step] = []
        is_polling = self._is_poll_next and any(now >= at for at in self._next)
        if self._orders and not (is_polling or self._following):
            self._following.extend(self._orders.pop(next(iter(self._orders)))(now))
        if self._following:
            step = self._following.popleft()
            self._asked, self._asked_until = step, now + step.wait
            self._is_poll_next = not self._following
            return [step]
        self._is_poll_next = False
        for number in (*range(self._turn, len(self.poll)), *range(self._turn)):
            if now < self._next[number]:
                continue
            step = self.poll[number]
            late = now - self._next[number]
            self._next[number] = now + step.every if late > step.every else self._next[number] + step.every
            self._turn = (number + 1) % len(self.poll)
            found.append(step)
            if step.expects:
                self._asked, self._asked_until = step, now + step.wait
                break
        return found

    @property
    def next_at(self) -> int:
        """When something is to be said if nothing comes [ns]; far ahead when nothing ever is."""
        if not self.is_open:
            return self._until
        if self._asked is not None:
            return self._asked_until
        if self._orders or self._following:
            return self._quiet_until
        return max(min(self._next, default=1 << 62), self._quiet_until)


def steps(
    entries: Sequence[Any], device: int, period: float, offset: int | None, where: str
) -> tuple[Step, ...]:
    """Return the ``entries`` for ``device``; ``offset`` is that of identifiers, None where there are none."""
    found = []
    for entry in entries:
        if not isinstance(entry, dict):
            raise ConfigError(
                f"{where}: {entry!r} is no entry; write {{ data = '03 00' }}, and on CAN an identifier"
            )
        given = build(_Entry, entry, where)
        try:
            data = bytes.fromhex(given.data) + given.text.encode("latin-1") + bytes(given.zeros)
        except ValueError:
            raise ConfigError(f"{where}: {entry!r} are no bytes; write {{ data = '03 00' }}") from None
        data = appended(given.checksum, data) if given.checksum else data
        if given.data and given.text:
            raise ConfigError(f"{where}: {entry!r} has 'data' and 'text'; give one of them")
        if offset is not None and not (given.identifier >= 0 and len(data) <= 64):
            raise ConfigError(
                f"{where}: {entry!r} is no frame; write {{ identifier = 0x81, data = '03 00' }}"
            )
        if given.device not in (-1, device):
            continue
        usual = PATIENCE if given.expects else PATIENCE_OPENING if given.answer else 0.0
        identifier = -1 if offset is None else on_bus(given.identifier + offset)
        found.append(
            Step(
                data,
                identifier,
                given.answer.encode("latin-1"),
                given.expects,
                round((given.every or period) * NS),
                round((given.wait or usual) * NS),
                given.unless,
                given.until,
                given.first,
            )
        )
    return tuple(found)
