"""Alarms as lines of a log: one when an alarm begins, one when it is over."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, field

from vegrip.messages import ContactEstimate, ForceCommand, ModelHealth, SlipMargin
from vegrip.runtime.monitor.board import Board
from vegrip.runtime.monitor.watch import Watch
from vegrip.web.live.alarms import Alarm, Alarms, Level, alarms_of

LEVELS = {Level.BAD: "error", Level.WARN: "warning", Level.CALM: "info"}


@dataclass(frozen=True, slots=True)
class LogLine:
    """A line of the log."""

    level: str  # of foxglove.Log
    name: str  # finger or node
    text: str


@dataclass
class AlarmLog:
    """What begins and ends; an alarm stays two seconds after its cause, so that it does not flicker."""

    _alarms: Alarms = field(default_factory=Alarms)
    _reported: dict[str, Alarm] = field(default_factory=dict)

    def update(self, active: list[Alarm], now: int) -> Iterator[LogLine]:
        """Yield what has changed at ``now`` [ns]."""
        self._alarms.update(active, now)
        held = {alarm.key: alarm for alarm in self._alarms.held}
        for key, alarm in held.items():
            if key not in self._reported or self._reported[key].level is not alarm.level:
                yield LogLine(LEVELS[alarm.level], alarm.finger, alarm.text)
        for key, alarm in self._reported.items():
            if key not in held:
                yield LogLine("info", alarm.finger, f"over: {alarm.text}")
        self._reported = held


class AlarmSource:
    """Hears the nodes, from the first :meth:`read` on, and says what is wrong with them."""

    def __init__(self) -> None:
        self._watch: Watch | None = None

    def read(self) -> list[LogLine]:
        """Return what has changed within some hundredths of a second."""
        if self._watch is None:
            self._watch = Watch((SlipMargin, ForceCommand), (ContactEstimate, ModelHealth), waits=True)
            self._board, self._log = Board(time.monotonic_ns()), AlarmLog()
        self._watch.step(self._board)
        now = time.monotonic_ns()
        self._board.refresh(now)
        return list(self._log.update(alarms_of(self._board, now), now))

    def rest(self) -> None:
        """Leave the nodes alone."""
        if self._watch is not None:
            self._watch.close()
            self._watch = None
