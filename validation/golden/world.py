"""The time that the endpoints of a case see: it moves from one arrival to the next, and nothing waits.

``time.monotonic`` and its like, ``time.sleep`` and ``select.select`` ask :data:`WORLD` while a case runs, so
that endpoints run as they are, whatever they look at.
"""

import select
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Final, NamedTuple

NS = 1_000_000_000


class Item(NamedTuple):
    """What arrives at ``now`` [ns], or what happens to the node then."""

    now: int
    thing: Any
    happens: bool = False


class World:
    """Arrivals in their order, and a clock.

    Args:
        items: what arrives, or happens to the node: that is told by :meth:`happening`.
        deliver: gets each thing as it arrives.

    """

    def __init__(self, items: Sequence[Item], deliver: Callable[[Item], None]) -> None:
        self.time = 1_000_000  # [ns]
        self._items = deque(items)
        self._deliver = deliver
        self._happenings = deque[Item]()
        self.stands = False  # while a node is started: to compile takes time of this machine, not of the case

    def now(self) -> int:
        """Return the time [ns]."""
        return self.time

    def sleep_until(self, deadline: int) -> None:
        """Let the time pass up to ``deadline`` [ns]."""
        while self._items and self._items[0].now <= deadline:
            item = self._items[0]
            self.time = max(self.time, item.now)
            self._items.popleft()
            if item.happens:
                self._happenings.append(item)
            else:
                self._deliver(item)
        self.time = max(self.time, deadline)

    def wait(self, seconds: float) -> None:
        """Let the time pass up to the next arrival, by ``seconds`` at most."""
        if seconds <= 0.0:
            return
        deadline = self.time + max(
            1, round(seconds * NS)
        )  # else a rest below 1 ns would be waited for for ever
        if self._items and self._items[0].now <= deadline:
            deadline = max(self._items[0].now, self.time)
        self.sleep_until(deadline)

    def happening(self) -> Item | None:
        """Return what happens now, once."""
        return self._happenings.popleft() if self._happenings else None

    def drop(self, until: int) -> None:
        """Let the time pass to ``until`` [ns]; what arrives meanwhile is lost."""
        while self._items and self._items[0].now < until and not self._items[0].happens:
            self._items.popleft()
        self.time = max(self.time, until)


_worlds: list[World] = []
_threads: list[int] = []  # of the loops: what runs beside them has the time of this machine
_select: Final = select.select


def _told(function: Callable[..., Any], scripted: Callable[[World], Any]) -> Callable[..., Any]:
    return lambda: scripted(_worlds[-1]) if _is_scripted() else function()


def _is_scripted() -> bool:
    return bool(_worlds) and _threads[-1] == threading.get_ident()


def _passes() -> bool:
    """Return whether waiting lets the time of a world pass."""
    return _is_scripted() and not _worlds[-1].stands


def _sleep(seconds: float, _function: Callable[[float], None] = time.sleep) -> None:
    if _passes():
        _worlds[-1].sleep_until(_worlds[-1].time + round(seconds * NS))
    else:
        _function(seconds)


def _scripted_select(readable: Any, writable: Any, failed: Any, timeout: float | None = None) -> Any:
    if not _passes():
        return _select(readable, writable, failed, timeout)
    found = _select(readable, writable, failed, 0.0)
    if any(found) or timeout is None:
        return found
    _worlds[-1].wait(timeout)
    return _select(readable, writable, failed, 0.0)


def install() -> None:
    """Let ``time`` and ``select`` ask the world; before vegrip is imported, which keeps some of them."""
    time.monotonic = _told(time.monotonic, lambda world: world.time / NS)
    time.monotonic_ns = _told(time.monotonic_ns, lambda world: world.time)
    time.time_ns = _told(time.time_ns, lambda world: world.time)
    time.sleep = _sleep  # type: ignore[assignment]
    select.select = _scripted_select


def now() -> int:
    """Return the time of the present world [ns]."""
    return _worlds[-1].time


def wait(seconds: float) -> None:
    """Let the time of the present world pass up to the next arrival."""
    _worlds[-1].wait(seconds)


@contextmanager
def present(world: World) -> Iterator[World]:
    """Let all that asks for the time see ``world``."""
    _worlds.append(world)
    _threads.append(threading.get_ident())
    try:
        yield world
    finally:
        _worlds.pop()
        _threads.pop()
