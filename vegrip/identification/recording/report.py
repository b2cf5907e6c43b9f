"""The report on a table that was read: every row left out and every doubt, with line numbers."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Final

from vegrip.clock import NS
from vegrip.messages import FingertipState

SILENCE_S: Final = 0.5  # [s] after which a counter may go on anywhere, because its sender has started again
LIKE: Final = 0.1  # part of the states of a silence by which counter and time may differ
MISSING: Final = "missing_states"
"""Key in ``[source]`` of ``recording.toml``."""


class MissingStates:
    """Counts them; a longer silence counts when the counter has moved on as time has."""

    def __init__(self) -> None:
        self.count = 0
        self._first: FingertipState | None = None
        self._last: FingertipState | None = None

    def take(self, state: FingertipState) -> None:
        """Take the next state that came."""
        first, last = self._first, self._last
        if first is None or last is None:
            self._first = self._last = state
            return
        step, silence = state.seq - last.seq, state.stamp - last.stamp
        if step <= 0:  # it was overtaken, and has been counted
            self.count -= self.count > 0
            return
        self._last = state
        expected = silence * (last.seq - first.seq) / max(last.stamp - first.stamp, 1)
        if silence < SILENCE_S * NS or abs(step - expected) <= LIKE * expected:
            self.count += step - 1


def told(count: int) -> str:
    return f"{count} states were sent and are not in it: the recorder was too slow, or the bus lost them"


SHOWN = 8
"""Line numbers kept of each finding; all of them are counted."""


class Kind(Enum):
    """Kinds of trouble with a row; ``lost`` says whether the row had to be left out."""

    CUT = ("the last line is cut", True)
    FIELDS = ("wrong number of fields", True)
    NUMBER = ("not a number", True)
    INFINITE = ("infinite value", True)
    NO_TIME = ("no time stamp or episode", True)
    BACKWARDS = ("time runs backwards", True)
    DUPLICATE = ("the time stamp stands twice", True)
    DECODE = ("message cannot be decoded", True)
    MISSING = ("value missing (NaN)", False)
    IMPLAUSIBLE = ("implausible value, check the unit", False)
    SUSPECT = ("suspicious", False)
    COLUMN = ("column not used", False)
    NOTE = ("note", False)

    @property
    def text(self) -> str:
        return self.value[0]

    @property
    def lost(self) -> bool:
        return self.value[1]


@dataclass(slots=True)
class Finding:
    """One kind of trouble, in one column, with the first line numbers."""

    kind: Kind
    what: str
    count: int = 0
    lines: list[int] = field(default_factory=list)
    place: str = "line"

    def __str__(self) -> str:
        # it may name what the file holds: no control character of that may reach a terminal
        what = "".join(c if c.isprintable() else repr(c)[1:-1] for c in self.what)
        text = f"{self.kind.text}: {what}" if what else self.kind.text
        if not self.lines:
            return text
        more = ", ..." if self.count > len(self.lines) else ""
        where = f"{self.place}{'s' if self.count > 1 else ''} {', '.join(map(str, self.lines))}{more}"
        return f"{text} ({self.count} x, {where})"


@dataclass(slots=True)
class LoadReport:
    """Counts of the rows that were read and kept, and the findings.

    ``place`` says what is numbered in a finding: the lines of a file, or the messages of a topic from 0.
    """

    rows_read: int = 0
    rows_kept: int = 0
    findings: list[Finding] = field(default_factory=list)
    place: str = "line"

    def add(self, kind: Kind, what: str = "", lines: Iterable[int] = ()) -> None:
        """Count what was found on ``lines``; the same kind and text is one finding."""
        new = list(lines)
        finding = next((f for f in self.findings if f.kind is kind and f.what == what), None)
        if finding is None:
            finding = Finding(kind, what, place=self.place)
            self.findings.append(finding)
        finding.count += len(new)
        finding.lines = sorted({*finding.lines, *new})[:SHOWN]

    @property
    def rows_lost(self) -> int:
        return self.rows_read - self.rows_kept

    @property
    def is_clean(self) -> bool:
        return not self.findings

    def count(self, kind: Kind) -> int:
        return sum(f.count for f in self.findings if f.kind is kind)

    def summary(self) -> str:
        head = f"{self.rows_kept} of {self.rows_read} rows kept"
        return "\n".join([head, *(f"  {finding}" for finding in self.findings)])

    def as_dict(self) -> dict[str, Any]:
        """The report for machines."""
        return {
            "rows_read": self.rows_read,
            "rows_kept": self.rows_kept,
            "rows_lost": self.rows_lost,
            "findings": [
                {"kind": f.kind.name.lower(), "what": f.what, "count": f.count, "lines": f.lines}
                for f in self.findings
            ],
        }
