"""The events of the live page: whole for a page that has just come, and what is new for the others."""

import json
import threading
from collections import deque
from typing import Any

from vegrip.web.live.columns import COLUMN_COUNT, Column
from vegrip.web.live.view import LAYOUT, LiveView, Wishes


class EventLog:
    """Turns a view into events, one for each :meth:`tick`; pages read from any thread.

    Args:
        view: that is shown; only the thread that ticks may change it.

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

    def tick(self, now: int, wishes: Wishes) -> None:
        """Close the columns and make the event of ``now`` [ns]."""
        snapshot = json.dumps(self.view.snapshot(now, wishes), separators=(",", ":"), allow_nan=False)
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
