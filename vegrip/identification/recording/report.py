"""The report on what was read: all rows or frames that came, those used, those left out, every doubt.

One account for tables, logs, bags and live traffic. More than ``WARNED_SHARE`` left out, or a whole second or
the peak of an episode, is a warning; from ``REFUSED_SHARE`` on, or where a reading is ambiguous, nothing is
made of it until an option says so.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.errors import RecordingError
from vegrip.messages import FingertipState
from vegrip.types import Floats

WARNED_SHARE, REFUSED_SHARE = 0.01, 0.1
LEAST_REFUSED: Final = 3  # rows left out, below which a share says nothing: one row of a table of five
WHOLE_STRETCH_S: Final = 1.0  # [s]
LEAST_GAP_S: Final = 0.1  # [s]
GAP_STEPS: Final = 10.0  # times the usual step, from which a step is a gap (origin: rule)
TOP: Final = 0.5  # of the largest value, from which a rise and fall is a peak (origin: rule)
SOMETIMES: Final = 0.5  # of the rows without a value, in even holes, from which a channel is a slower one
LEAST_HOLES: Final = 3
UNEVEN: Final = 3.0  # times the usual hole (origin: rule)
LEAST_STEPS: Final = 20  # that show how often rows come
LEAST_TOP: Final = 3  # rows that are left out at a peak before it counts as lost
HIDDEN_RISE: Final = 0.01  # of the largest value, that a hole hides before the peak counts as lost
PEAKED: Final = ("normal_force", "displacement")
ACCEPT: Final = "--accept-losses"

SILENCE_S: Final = 0.5  # [s] after which a counter may go on anywhere, because its sender has started again
LIKE: Final = 0.1  # part of the states of a silence by which counter and time may differ
MISSING: Final = "missing_states"
"""Key in ``[source]`` of ``recording.toml``."""
DOUBTS: Final = "doubts"
"""Key in ``[source]``: what an import doubted, which every command that follows says again."""


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


def describe_missing(count: int) -> str:
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
    REFUSED = ("frame refused", True)
    UNSEEN = ("sent, and not in it", True)
    AMBIGUOUS = ("can be read in two ways", False)
    MISSING = ("value missing (NaN)", False)
    IMPLAUSIBLE = ("implausible value, check the unit", False)
    SUSPECT = ("suspicious", False)
    AIRLESS = ("never in the air", False)
    COLUMN = ("column not used", False)
    NOTE = ("note", False)

    @property
    def text(self) -> str:
        return self.value[0]

    @property
    def lost(self) -> bool:
        return self.value[1]


REMEDIES: Final[Mapping[Kind, str]] = {
    Kind.FIELDS: "--delimiter says what separates the fields",
    Kind.NUMBER: "--thousands says what stands between thousands, --decimal the decimal sign",
    Kind.BACKWARDS: "a column that separates trials is said by --map episode=COLUMN",
    Kind.DUPLICATE: "--spread gives rows of one time stamp times of their own, until the next stamp",
}
"""The option that helps."""


@dataclass(slots=True)
class Finding:
    """One kind of trouble, in one column, with the first line numbers, and all of those that are lost."""

    kind: Kind
    what: str
    count: int = 0
    lines: list[int] = field(default_factory=list)
    place: str = "line"
    lost: list[int] = field(default_factory=list)

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
    seconds: dict[Kind, float] = field(default_factory=dict)
    lost_parts: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    tables: list[tuple[str, "LoadReport"]] = field(default_factory=list)

    def include(self, name: str, table: "LoadReport") -> None:
        """Add the account of the table ``name``, which is said with each thing that was found in it."""
        self.tables.append((name, table))
        self.place = table.place
        self.rows_read += table.rows_read
        self.rows_kept += table.rows_kept
        for finding in table.findings:
            lines = finding.lost or finding.lines
            what = f"{name}: {finding.what}".rstrip(": ")
            self.add(finding.kind, what, lines, finding.count - len(lines))
        for kind, seconds in table.seconds.items():
            self.seconds[kind] = self.seconds.get(kind, 0.0) + seconds
        self.lost_parts += [f"{name}: {part}" for part in table.lost_parts]
        self.missing += [f"{name}: {sentence}" for sentence in table.missing]

    def add(self, kind: Kind, what: str = "", lines: Iterable[int] = (), count: int = 0) -> None:
        """Count what was found on ``lines``, or ``count`` without any; a kind and text is one finding."""
        new = list(lines)
        finding = next((f for f in self.findings if f.kind is kind and f.what == what), None)
        if finding is None:
            finding = Finding(kind, what, place=self.place)
            self.findings.append(finding)
        finding.count += len(new) + count
        finding.lines = sorted({*finding.lines, *new})[:SHOWN]
        if kind.lost:
            finding.lost += new

    def place_losses(
        self,
        t: Floats,
        lines: NDArray[np.int64],
        columns: Mapping[str, Floats],
        episode: NDArray[np.int64],
    ) -> None:
        """Find when the rows left out were, and whether a whole second or a peak is missing.

        Args:
            t: (n,) [s] of the rows kept.
            lines: (n,) of the rows kept, ascending.
            columns: channel -> (n,) of the rows kept.
            episode: (n,) of the rows kept.

        """
        step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
        reasons: dict[int, Kind] = {}
        for finding in self.findings:
            for line in finding.lost if finding.kind.lost else ():
                reasons.setdefault(line, finding.kind)
        gone = np.array(sorted(reasons), dtype=np.int64)
        after = np.searchsorted(lines, gone)  # each is before this row
        holes, counts = np.unique(after, return_counts=True)
        edges = np.concatenate([[-np.inf], t, [np.inf]])
        spans = np.clip(edges[holes + 1] - edges[holes] - step, 0.0, counts * step)
        each = np.repeat(spans / counts, counts)
        self.seconds = {}
        for line, seconds in zip(gone.tolist(), each.tolist(), strict=True):
            self.seconds[reasons[line]] = self.seconds.get(reasons[line], 0.0) + seconds
        for finding in self.findings:
            if finding.kind.lost and not finding.lost:  # where is not known
                seconds = self.seconds.get(finding.kind, 0.0) + finding.count * step
                self.seconds[finding.kind] = seconds
        for hole, span in zip(holes.tolist(), spans.tolist(), strict=True):
            if span >= WHOLE_STRETCH_S:
                begin = float(t[hole - 1]) if hole else float(t[0]) - span
                self.lost_parts.append(f"all from {begin:.4g} to {begin + span:.4g} s")
        unexplained = np.where(np.diff(episode) == 0, np.diff(t), 0.0)
        inner = (holes > 0) & (holes < len(t))
        unexplained[holes[inner] - 1] -= spans[inner]
        self.note_gaps(t, [one for one in gaps_of(t) if unexplained[one] >= LEAST_GAP_S])
        for name in PEAKED:
            if name in columns and _lacks_its_peak(columns[name], holes, counts):
                self.lost_parts.append(f"the peak of {name}")
        for name, values in columns.items():
            if name in PEAKED:
                self._place_missing(name, values)

    def note_gaps(self, t: Floats, after: Sequence[int], what: str = "") -> None:
        """Note that nothing (of ``what``) came between the rows ``after`` and the next."""
        if after:
            longest = max(after, key=lambda row: float(t[row + 1] - t[row]))
            others = f", and in {len(after) - 1} shorter gaps" if len(after) > 1 else ""
            self.missing.append(
                f"nothing{what} came from {t[longest]:.6g} to {t[longest + 1]:.6g} s{others}: the clock "
                "was set forward there, or nothing was recorded; cut it there into recordings of their own"
            )

    def _place_missing(self, name: str, values: Floats) -> None:
        """Note where a channel that is there in most rows has no value in too many."""
        there = np.isfinite(values)
        absent = float(np.mean(~there))
        holes, counts = np.unique(np.cumsum(there)[~there], return_counts=True)
        lacks = _lacks_its_peak(values[there], holes, counts)
        is_even = len(counts) >= LEAST_HOLES and int(np.max(counts)) <= UNEVEN * float(np.median(counts))
        is_slower = absent >= SOMETIMES and is_even
        if not is_slower and (lacks or (absent and absent + self.share_lost > WARNED_SHARE)):
            part = ", with them its peak" if lacks else ""
            self.missing.append(
                f"{name} has no value in {np.count_nonzero(~there)} of {len(values)} rows "
                f"({100 * absent:.3g} %){part}: its cells are empty there"
            )

    @property
    def rows_lost(self) -> int:
        return self.rows_read - self.rows_kept

    @property
    def share_lost(self) -> float:
        return self.rows_lost / self.rows_read if self.rows_read else 0.0

    def count(self, kind: Kind) -> int:
        return sum(f.count for f in self.findings if f.kind is kind)

    def warnings(self) -> list[str]:
        """Return a sentence on each loss of more than ``WARNED_SHARE``, a second or a peak, by table."""
        if self.tables:
            return [f"{name}: {sentence}" for name, table in self.tables for sentence in table.warnings()]
        if self.share_lost <= WARNED_SHARE and not self.lost_parts:
            return self.missing
        kinds = dict.fromkeys(f.kind for f in self.findings if f.kind.lost and f.count)
        causes = ", ".join(self._cause(kind) for kind in kinds)
        parts = f", with them {', '.join(dict.fromkeys(self.lost_parts))}" if self.lost_parts else ""
        remedies = "; ".join(REMEDIES[kind] for kind in kinds if kind in REMEDIES)
        return [
            f"{self.rows_lost} of {self.rows_read} {self._rows} are left out ({100 * self.share_lost:.3g} %)"
            f"{parts}: {causes or 'see below'}" + (f"; {remedies}" if remedies else ""),
            *self.missing,
        ]

    @property
    def doubts(self) -> list[str]:
        """What may be wrong with the recording, with the option that settles it."""
        kinds = Kind.SUSPECT, Kind.AIRLESS
        return [finding.what for finding in self.findings if finding.kind in kinds]

    def refuse(self, where: object, *, accepted: bool) -> None:
        """Raise where a reading is ambiguous, or too much is left out and that is not ``accepted``.

        Raises:
            RecordingError: names what, and the option that settles it.

        """
        for finding in self.findings:
            if finding.kind is Kind.AMBIGUOUS:
                raise RecordingError(f"{where}: {finding.what}")
        if not accepted and self.rows_lost >= LEAST_REFUSED and self.share_lost >= REFUSED_SHARE:
            raise RecordingError(f"{where}: {self.warnings()[0]}; {ACCEPT} goes on without them")

    def summary(self) -> str:
        """Return the account and all findings, what is lost first."""
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

    @property
    def _rows(self) -> str:
        return {"line": "rows", "message": "messages", "frame": "frames"}.get(self.place, "rows")

    def _cause(self, kind: Kind) -> str:
        texts = [f"{f.what} {f.count} x".strip() for f in self.findings if f.kind is kind]
        first = next((f.lines[0] for f in self.findings if f.kind is kind and f.lines), None)
        where = f" from {self.place} {first} on" if first is not None else ""
        return f"{kind.text} ({'; '.join(texts[:3])}, {self.seconds.get(kind, 0.0):.3g} s{where})"


def account(reports: Iterable[LoadReport]) -> dict[str, Any]:
    """Return for machines how many rows came, were used, and were left out by reason with their seconds."""
    left_out, read, kept = dict[str, dict[str, float]](), 0, 0
    for report in reports:
        read, kept = read + report.rows_read, kept + report.rows_kept
        for finding in report.findings:
            if finding.kind.lost:
                one = left_out.setdefault(finding.kind.name.lower(), {"count": 0, "seconds": 0.0})
                one["count"] += finding.count
        for kind, seconds in report.seconds.items():
            left_out[kind.name.lower()]["seconds"] += seconds
    return {"in": read, "used": kept, "left_out": left_out}


def gaps_of(t: Floats) -> list[int]:
    """Return the rows of ``t`` [s] after which nothing comes for a second, or for more than a share.

    The usual step is the longest but a tenth.
    """
    steps = np.diff(t)
    if len(steps) < LEAST_STEPS:
        return []
    gaps = np.flatnonzero(steps >= max(LEAST_GAP_S, GAP_STEPS * float(np.quantile(steps, 0.9))))
    lost = steps[gaps]
    is_much = np.max(lost, initial=0.0) >= WHOLE_STRETCH_S or np.sum(lost) > WARNED_SHARE * (t[-1] - t[0])
    return gaps.tolist() if is_much else []


def _lacks_its_peak(values: Floats, holes: NDArray[np.int64], counts: NDArray[np.int64]) -> bool:
    """Whether ``values`` rise into a hole of rows that are left out, and fall behind it, at their largest.

    What the hole hides is the lesser of both slopes over half of its rows.
    """
    known = values[np.isfinite(values)]
    largest = float(np.max(known, initial=0.0))
    for at, count in zip(holes.tolist(), counts.tolist(), strict=True):
        before, after = values[max(at - count, 0) : at], values[at : at + count]
        if count < LEAST_TOP or len(before) < count or len(after) < count:
            continue
        if not min(before[-1], after[0]) >= TOP * largest > 0.0:
            continue
        slope = min(before[-1] - before[0], after[0] - after[-1]) / (count - 1)
        if slope * count / 2 > HIDDEN_RISE * largest:
            return True
    return False
