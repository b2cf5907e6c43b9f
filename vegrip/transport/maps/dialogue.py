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
``wait`` is counted as ``unanswered``.
"""

from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from vegrip.clock import NS
from vegrip.config import build, parameter
from vegrip.errors import ConfigError
from vegrip.transport.codec import Frame
from vegrip.transport.maps.packets import on_bus

MOST_HEARD: Final = 512  # [bytes] in which an answer is looked for
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
    offset: int = parameter(
        0, low=-0x7FF, high=0x7FF, doc="CAN: added to all identifiers, as for another hand"
    )


@dataclass(frozen=True)
class _Entry:
    text: str = parameter("", doc="what is sent")
    data: str = parameter("", doc="what is sent, in hexadecimal")
    zeros: int = parameter(0, low=0, high=64, doc="so many bytes of zero instead")
    identifier: int = parameter(-1, low=-1, high=(1 << 29) - 1, doc="on CAN")
    device: int = parameter(-1, low=-1, high=63, doc="which of the addresses; -1: each")
    answer: str = parameter("", doc="text of the answer")
    expects: str = parameter("", doc="poll: the packet or frame of the answer")
    every: float = parameter(0.0, unit="s", low=0.0, high=3600.0, doc="poll; 0: command.period")
    wait: float = parameter(0.0, unit="s", low=0.0, high=60.0, doc="for the answer, or before the next entry")


class Step(NamedTuple):
    """One thing to say."""

    data: bytes
    identifier: int  # -1: not on CAN
    answer: bytes
    expects: str
    every: int  # [ns]
    wait: int  # [ns]

    @property
    def frame(self) -> Frame:
        return Frame(self.identifier, self.data, len(self.data) > 8)


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
    ) -> None:
        self.opening, self.poll, self.zeroing, self.closing = (
            _steps(entries, device, period, spec.offset if on_can else None, f"{where} [device] {name}")
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
        self.start()

    def start(self) -> None:
        """Begin with the opening: the connection is new."""
        self._said = deque(self.opening)  # and what else is said in order, once
        self._again = bool(self.opening)  # whether what is said is the opening
        self._awaited: Step | None = None
        self._until = 0  # [ns] the end of the present wait
        self._heard = bytearray()
        self._asked: Step | None = None
        self._asked_until = 0
        self._turn = 0
        self._next = [0] * len(self.poll)
        self._has_come = True
        self._silent_at = 0  # [ns]

    @property
    def is_open(self) -> bool:
        return not self._said and self._awaited is None

    def zero(self) -> bool:
        self._said.extend(self.zeroing)
        return bool(self.zeroing)

    def due(self, now: int) -> list[Step]:
        """Return what to say at ``now`` [ns]."""
        found: list[Step] = []
        while now >= self._until and (self._asked is None or self._again):
            if self._awaited is not None and self._awaited.answer:
                self._counts["unanswered"] += 1
                if self._again:
                    self._said = deque(self.opening)
            self._awaited = None
            if not self._said:
                self._again = False
                break
            found.append(self._say(now))
        if self._again or (self._awaited is not None and not self.poll):
            return found
        return found + self._polled(now)

    def hear(self, chunk: bytes, now: int) -> None:
        """Look for the answer that is waited for in what has come."""
        if self._awaited is None or not self._awaited.answer:
            return
        self._heard += chunk
        if self._awaited.answer in self._heard:
            self._awaited = None
            self._until = now
        del self._heard[:-MOST_HEARD]

    def came(self, name: str) -> None:
        self._has_come = True
        if self._asked is not None and self._asked.expects == name:
            self._asked = None

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
        self._heard.clear()
        self._until = now + step.wait
        return step

    def _polled(self, now: int) -> list[Step]:
        if self._asked is not None:
            if now < self._asked_until:
                return []
            self._counts["unanswered"] += 1
            self._asked = None
            self.missed += 1
        found: list[Step] = []
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
        return min(self._next, default=1 << 62)


def _steps(
    entries: Sequence[Any], device: int, period: float, offset: int | None, where: str
) -> tuple[Step, ...]:
    """Return the ``entries`` for ``device``; ``offset`` is that of identifiers, None where there are none."""
    found = []
    for entry in entries:
        if not isinstance(entry, dict):
            raise ConfigError(
                f"{where}: {entry!r} is no entry; write {{ data = '03 00' }}, and on CAN an identifier"
            )
        told = build(_Entry, entry, where)
        try:
            data = bytes.fromhex(told.data) + told.text.encode("latin-1") + bytes(told.zeros)
        except ValueError:
            raise ConfigError(f"{where}: {entry!r} are no bytes; write {{ data = '03 00' }}") from None
        if told.data and told.text:
            raise ConfigError(f"{where}: {entry!r} has 'data' and 'text'; give one of them")
        if offset is not None and not (told.identifier >= 0 and len(data) <= 64):
            raise ConfigError(
                f"{where}: {entry!r} is no frame; write {{ identifier = 0x81, data = '03 00' }}"
            )
        if told.device not in (-1, device):
            continue
        usual = PATIENCE if told.expects else PATIENCE_OPENING if told.answer else 0.0
        identifier = -1 if offset is None else on_bus(told.identifier + offset)
        found.append(
            Step(
                data,
                identifier,
                told.answer.encode("latin-1"),
                told.expects,
                round((told.every or period) * NS),
                round((told.wait or usual) * NS),
            )
        )
    return tuple(found)
