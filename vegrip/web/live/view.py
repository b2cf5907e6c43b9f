"""The live page's view of everything: takes messages, gives plain values for JSON. Pure; time is passed in.

Ages, presence and the log are those of :class:`~vegrip.runtime.monitor.board.Board`, as in the terminal.
"""

import json
import math
import threading
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

from vegrip import messages
from vegrip.clock import NS
from vegrip.runtime.monitor.board import MOST_FINGERS, Board
from vegrip.runtime.monitor.rows import NodeRow, Presence, Present
from vegrip.web.live.alarms import Alarm, Alarms, Level, alarms_of, states_of
from vegrip.web.live.finger_view import finger_view, finite

COLUMN_PERIOD_S = 0.04  # [s] of one column
SPAN = 30.0  # [s] that are kept
COLUMN_COUNT = round(SPAN / COLUMN_PERIOD_S)
COLUMN_NAMES = (
    "margin",  # [-]
    "bound",  # [-] lower bound of the margin
    "normal_force",  # [N]
    "contact_radius",  # [m]
    "pressure_exponent",  # [-]
    "friction_coefficient",  # [-]
    "command",  # [N]
)
BANDS = ("normal_force", "contact_radius", "pressure_exponent", "friction_coefficient")
"""Quantities that are kept with their standard deviation."""

Column = list[float | None]
"""[least, greatest, newest] of each of ``COLUMN_NAMES``, then the newest std of each of ``BANDS``."""


@dataclass
class Columns:
    """The columns of one finger, oldest first."""

    closed: deque[Column] = field(default_factory=lambda: deque(maxlen=COLUMN_COUNT))
    _open: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    _stds: dict[str, float] = field(default_factory=dict)

    def add(self, name: str, value: float, std: float = math.nan) -> None:
        """Take a value of the open column; one that is not finite is none."""
        if not math.isfinite(value):
            return
        least, greatest, _ = self._open.get(name, (value, value, value))
        self._open[name] = (min(least, value), max(greatest, value), value)
        self._stds[name] = std

    def close(self) -> Column:
        """End the open column, keep and return it; what was not received in it is None."""
        column: Column = []
        for name in COLUMN_NAMES:
            column += [_short(v) for v in self._open.get(name, (math.nan,) * 3)]
        column += [_short(self._stds.get(name, math.nan)) for name in BANDS]
        self.closed.append(column)
        self._open, self._stds = {}, {}
        return column


def _short(value: float) -> float | None:
    return float(f"{value:.4g}") if math.isfinite(value) else None


MOST_LEARNED = 32  # parameters of one finger
PERCENTILES = ("latency_p50", "latency_p99", "latency_max", "lateness_max")


Wanted = Callable[[str], float | None]
"""Margin that a node keeps, by its name; None = not known."""


@dataclass
class LiveView:
    """A board with the last half minute of every finger."""

    board: Board
    columns: dict[str, Columns] = field(default_factory=dict)
    _learned: dict[str, dict[str, messages.LearnedParameter]] = field(default_factory=dict)
    _alarms: Alarms = field(default_factory=Alarms)
    _states: Alarms = field(default_factory=Alarms)

    def receive(self, message: messages.Message, now: int, node: str = "") -> None:
        """Take a message that came at ``now`` [ns] from ``node``."""
        if isinstance(
            message, messages.FingertipState
        ):  # what a node received is no sign of life of that node
            if (row := self.board.rows.get(message.finger)) is not None:
                row.put(message, now)
            return
        self.board.receive(message, now, node)
        finger = getattr(message, "finger", "")
        if finger not in self.board.rows:
            return
        if isinstance(message, messages.LearnedParameter):
            learned = self._learned.setdefault(finger, {})
            if message.symbol in learned or len(learned) < MOST_LEARNED:
                learned[message.symbol] = message
            return
        self._track(self.columns.setdefault(finger, Columns()), message)

    def attend(self, present: Iterable[Present], now: int) -> None:
        self.board.attend(present, now)

    def history(self) -> dict[str, list[Column]]:
        return {finger: list(columns.closed) for finger, columns in self.columns.items()}

    def close_columns(self) -> dict[str, Column]:
        for finger in self.board.rows:
            self.columns.setdefault(finger, Columns())
        return {finger: columns.close() for finger, columns in self.columns.items()}

    def snapshot(self, now: int, wanted: Wanted) -> dict[str, Any]:
        """Return everything as of ``now`` [ns] but the columns."""
        self.board.refresh(now)
        board = self.board
        alarms = self._alarms.update(alarms_of(board, now), now)
        worst = {one.finger: one for one in sorted(self._alarms.held, key=lambda one: one.level is Level.BAD)}
        return {
            "time": round((now - board.start) / NS, 2),
            "fingers": {
                name: {"source": row.source, "alarm": _label(worst.get(name))}
                | finger_view(
                    row,
                    now,
                    wanted=wanted(row.source),
                    learned=self._learned.get(name, {}) if self._is_received(row.source) else {},
                )
                for name, row in board.rows.items()
            },
            "nodes": {name: _node(row, now) for name, row in board.nodes.items()},
            "alarms": alarms,
            "states": self._states.update(states_of(board, now), now),
            "log": [
                {"time": round(line.time, 1), "text": line.text, "style": line.style} for line in board.log
            ],
        }

    def _is_received(self, node: str) -> bool:
        return node in self.board.nodes and self.board.nodes[node].presence is Presence.RUNNING

    @staticmethod
    def _track(columns: Columns, message: messages.Message) -> None:
        if isinstance(message, messages.SlipMargin):
            columns.add("margin", message.margin.value)
            columns.add("bound", message.lower_bound)
        elif isinstance(message, messages.ForceCommand):
            columns.add("command", message.normal_force)
        elif isinstance(message, messages.ContactEstimate):
            for name in BANDS:
                estimate = getattr(message, name)
                columns.add(name, estimate.value, estimate.std)


LAYOUT: dict[str, Any] = {
    "names": COLUMN_NAMES,
    "bands": BANDS,
    "period": COLUMN_PERIOD_S,
    "count": COLUMN_COUNT,
    "most_fingers": MOST_FINGERS,
}
"""How the columns are to be read."""


def _label(alarm: Alarm | None) -> dict[str, str] | None:
    return {"level": alarm.level.value, "label": alarm.label} if alarm is not None else None


def _node(row: NodeRow, now: int) -> dict[str, Any]:
    status = row.status
    shown: dict[str, Any] = {
        "presence": row.presence.value,
        "age": finite(row.age(now), 3),
        "overdue": row.is_overdue(now),
        "late": finite(row.late, 3),
        "late_share": finite(row.late_share, 3),
        "refused": row.refusals(now),
    }
    if status is None:
        return shown
    return shown | {
        "state": status.state.name.lower(),
        "rate_in": finite(status.rate_in),
        "rate_out": finite(status.rate_out),
        "misses": status.deadline_misses,
        "dropped": status.dropped,
        **{name: finite(getattr(status, name)) for name in PERCENTILES},
    }


class EventLog:
    """Turns a view into events, one for each :meth:`add_event`; pages read from any thread.

    Args:
        view: that is shown; only the thread that adds events may change it.

    """

    def __init__(self, view: LiveView) -> None:
        self.view = view
        self._lock = threading.Lock()
        self._recent: deque[tuple[int, dict[str, Column]]] = deque(maxlen=COLUMN_COUNT)
        self._number = 0
        self._snapshot = "{}"

    @property
    def number(self) -> int:
        return self._number

    def add_event(self, now: int, wanted: Wanted) -> None:
        """Close the columns and make the event of ``now`` [ns]."""
        snapshot = json.dumps(self.view.snapshot(now, wanted), separators=(",", ":"), allow_nan=False)
        with self._lock:
            self._number += 1
            self._recent.append((self._number, self.view.close_columns()))
            self._snapshot = snapshot

    def first(self) -> tuple[int, str]:
        """Return number and text of the event for a page that has just come: all columns that are kept."""
        with self._lock:
            return self._number, self._whole()

    def since(self, number: int) -> tuple[int, str]:
        """Return number and text of the event with what is new since the event ``number``."""
        with self._lock:
            if self._number - number > len(self._recent):  # the page slept for longer than is kept
                return self._number, self._whole()
            new = [columns for at, columns in self._recent if at > number]
            return self._number, _event(self._snapshot, {"columns": new})

    def _whole(self) -> str:
        return _event(self._snapshot, {"layout": LAYOUT, "history": self.view.history()})


def _event(snapshot: str, more: dict[str, Any]) -> str:
    rest = json.dumps(more, separators=(",", ":"), allow_nan=False)
    return f"{snapshot[:-1]},{rest[1:]}" if len(snapshot) > 2 else rest
