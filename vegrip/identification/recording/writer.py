"""Recording what is on the bus: one folder per session, in it one recording per finger.

::

    session/session.toml            when it began, whether it was closed, what was lost
    session/diagnostics.csv         NodeStatus of every node
    session/grasp.csv               GraspStatus of every node
    session/thumb/recording.toml    with recording.csv: a recording like any other
    session/thumb/contact.csv       ContactEstimate; slip_margin.csv, force_command.csv, model_health.csv,
                                    learned.csv, device.csv

Rows are whole lines, written out by :meth:`RecordingWriter.flush`, so that after a crash at most what came
since the last flush is missing. Nothing here raises once the folder is made: what the disk refuses, and what
is deleted while it is written, is counted in :attr:`RecordingWriter.lost`, logged when it happens,
and summed up in :attr:`RecordingWriter.problem`.
"""

import contextlib
import dataclasses
import logging
import math
import os
import sys
import threading
import time
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from enum import Enum, IntFlag
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

import numpy as np

from vegrip import messages
from vegrip.clock import NS
from vegrip.errors import RecordingError
from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.recording.data import Fingertip, Recording
from vegrip.identification.recording.folder import toml_text
from vegrip.identification.recording.report import MISSING, MissingStates, describe_missing
from vegrip.identification.recording.table_file import BUFFERED_ROWS, TableFile
from vegrip.whole_file import write_whole, writing

FILE_OF_MESSAGE: Final[dict[type[messages.Message], str]] = {
    messages.FingertipState: "recording.csv",
    messages.ContactEstimate: "contact.csv",
    messages.SlipMargin: "slip_margin.csv",
    messages.ForceCommand: "force_command.csv",
    messages.ModelHealth: "model_health.csv",
    messages.LearnedParameter: "learned.csv",
    messages.DeviceReport: "device.csv",
    messages.NodeStatus: "diagnostics.csv",
    messages.GraspStatus: "grasp.csv",
}
"""Which file of a finger's folder a message goes to; diagnostics lie beside the fingers."""
STATE_HEADER: Final = ",".join(("t", "episode", *CHANNELS))
SESSION = "session.toml"
MOST_TABLES = 400
"""Files of a session; each keeps a descriptor, and a sender of made-up fingers must not use them all."""
log = logging.getLogger(__name__)
# messages; four seconds of five fingers at 500 Hz with all that is said of them
QUEUE_MESSAGES: Final = 100_000
# [s] between two looks at the queue; what gathers in a second takes a core for a while
LOOK_PERIOD_S: Final = 0.05
FLUSH_PERIOD_S: Final = 1.0  # [s] between two flushes: the most that a power cut costs
NICENESS: Final = 10  # of the writing thread: the loops of a hand on the same machine come first


def csv_header(kind: type[messages.Message]) -> str:
    """Return the first line of the file of ``kind``."""
    if kind is messages.FingertipState:
        return STATE_HEADER
    names = ["t"]
    for name, is_estimate in _FIELDS[kind]:
        names += [name, f"{name}_std", f"{name}_valid", f"{name}_age"] if is_estimate else [name]
    return ",".join(names)


def csv_row(message: messages.Message, start: int) -> str:
    """Return ``message`` as a line without its end; ``start`` [ns] is the stamp of t = 0."""
    seconds, rest = divmod(message.stamp - start, NS)
    t = f"{seconds}.{rest:09d}" if seconds >= 0 else repr((message.stamp - start) / NS)
    if isinstance(message, messages.FingertipState):
        return ",".join((t, "0", *(exact_cell(getattr(message, name)) for name in CHANNELS)))
    cells = [t]
    for name, is_estimate in _FIELDS[type(message)]:
        value = getattr(message, name)
        cells += _estimate(value) if is_estimate else [_cell(value)]
    return ",".join(cells)


def _written(kind: type[messages.Message]) -> tuple[tuple[str, bool], ...]:
    known = [field for field in dataclasses.fields(kind) if field.name not in ("stamp", "finger")]
    return tuple((field.name, isinstance(field.default, messages.Estimate)) for field in known)


_FIELDS: Final = {kind: _written(kind) for kind in FILE_OF_MESSAGE}


def _estimate(estimate: messages.Estimate) -> list[str]:
    return [_float(estimate.value), _float(estimate.std), str(int(estimate.valid)), _float(estimate.age)]


def _cell(value: Any) -> str:
    for kind, text in _CELLS.items():
        if isinstance(value, kind):
            return text(value)
    raise TypeError(f"no way to write {value!r}")


def _float(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.8g}"


def exact_cell(value: float) -> str:
    return "" if math.isnan(value) else repr(value)


def _mapping(value: Mapping[str, int]) -> str:
    return ";".join(f"{_text(key)}={count}" for key, count in value.items())


def _text(value: str) -> str:
    return "".join(" " if c in ',;="\r\n' else c for c in value)


_CELLS: Final[dict[type, Callable[[Any], str]]] = {  # in order: a bool is an int, an enum may be one
    bool: lambda value: str(int(value)),
    IntFlag: lambda value: str(int(value)),
    Enum: lambda value: value.name.lower(),
    int: str,
    float: _float,
    str: _text,
    Mapping: _mapping,
}


class RecordingWriter:
    """Writes messages to a session folder.

    Args:
        folder: is made; must not hold a recording already.
        radius: of the fingertips [m], NaN when unknown.
        sensors: standard deviation of the noise per channel, as in ``recording.toml``.

    Raises:
        RecordingError: the folder cannot be made, or holds a recording.

    """

    def __init__(
        self, folder: Path | str, *, radius: float = np.nan, sensors: Mapping[str, float] | None = None
    ) -> None:
        self.folder = Path(folder)
        self.rows: Counter[str] = Counter()  # taken, by file
        self.lost: Counter[str] = Counter()  # of them not on disk, by file
        self.missing: defaultdict[str, MissingStates] = defaultdict(MissingStates)  # by finger
        self.dropped = 0  # messages that came faster than they were taken; set by a queue in front of this
        self._radius = radius
        self._sensors = dict(sensors or {})
        self._files: dict[str, TableFile] = {}
        self._start: int | None = None
        self._began = datetime.now(UTC).isoformat(timespec="seconds")
        self._descriptions = {SESSION: f'began = "{self._began}"\n'}
        self._refusal = ""  # why the disk takes nothing, as it was last logged
        self._causes: dict[str, None] = {}  # of what is lost, in the order they were met
        self._make()

    @property
    def problem(self) -> str:
        """What is not in the recording and why, in a sentence; empty when it is whole."""
        lost, rows = sum(self.lost.values()), sum(self.rows.values())
        causes = [
            *self._causes,
            *(f"{name} cannot be written" for name in self._descriptions if self.lost[name]),
        ]
        parts = [f"{lost} of {rows} rows are lost ({', '.join(causes)})"] if lost else []
        if moved := sum(file.moved for file in self._files.values()):
            parts.append(f"{moved} of {rows} rows are where the folder was moved to")
        if self.dropped:
            parts.append(f"{self.dropped} messages came faster than they could be written")
        return f"the recording {self.folder} is not whole: {'; '.join(parts)}" if parts else ""

    def begin(self, stamp: int) -> None:
        """Let t = 0 be at ``stamp`` [ns]; without it, it is at the first message."""
        self._start = stamp

    def write(self, message: messages.Message) -> None:
        """Take one message; it reaches the disk with the next :meth:`flush`."""
        if self._start is None:
            self._start = message.stamp
        name = _file(message)
        if name not in self._files:
            if len(self._files) >= MOST_TABLES:
                self._refuse(f"more than {MOST_TABLES} tables, the rest")
                return
            self._files[name] = self._new(name, message)
        if isinstance(message, messages.FingertipState):
            self.missing[folder_name(message.finger)].take(message)
        self._files[name].add(csv_row(message, self._start))
        self.rows[name] += 1

    def flush(self) -> None:
        """Write out everything taken; what the disk refuses is kept for a while, then counted as lost."""
        lost = {name: file.flush() for name, file in self._files.items()}
        self.lost.update(lost)
        self._log_accidents(lost)
        self._note_missing()
        for name in self._descriptions:
            self._describe(name)
        self._log_refusal(sum(lost.values()))

    def close(self) -> None:
        """Write out what is left and seal the session; may be called twice."""
        self.flush()
        lost = {name: file.give_up() for name, file in self._files.items()}
        self.lost.update(lost)
        self._log_accidents(lost)
        if any(lost.values()) and self._refusal:
            log.error("%s: %d rows are lost at the end (%s)", self.folder, sum(lost.values()), self._refusal)
        for file in self._files.values():
            file.close()
        counts = self._note_missing()
        if counts:
            each = ", ".join(f"{finger} {count}" for finger, count in counts.items())
            log.warning("%s: %s (%s)", self.folder, describe_missing(sum(counts.values())), each)
        for name in self._descriptions:
            self._describe(name)
        self._seal()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _make(self) -> None:
        if (self.folder / SESSION).exists() or (self.folder / "recording.toml").exists():
            raise RecordingError(f"{self.folder}: holds a recording already; choose another folder")
        with writing(self.folder, RecordingError):
            self.folder.mkdir(parents=True, exist_ok=True)
            write_whole(self.folder / SESSION, f'began = "{self._began}"\n')

    def _new(self, name: str, message: messages.Message) -> TableFile:
        if name.endswith("/recording.csv"):
            about = name.replace(".csv", ".toml")
            self._descriptions[about] = self._about(name.partition("/")[0])
            self._describe(about)
        return TableFile(self.folder / name, csv_header(type(message)))

    def _refuse(self, why: str) -> None:
        if why not in self._causes:
            log.error("%s: %s is lost", self.folder, why)
        self._causes[why] = None
        self.rows["refused"] += 1
        self.lost["refused"] += 1

    def _log_accidents(self, lost: Mapping[str, int]) -> None:
        met = {name: file.accident for name, file in self._files.items() if file.accident}
        for accident in dict.fromkeys(met.values()):
            names = [name for name, what in met.items() if what == accident]
            rows = sum(lost[name] for name in names)
            self._causes[accident] = None
            log.error(
                "%s: %s: %s while being written, %d rows are lost; the recording goes on",
                self.folder,
                ", ".join(names),
                accident,
                rows,
            )
        for name in met:
            self._files[name].accident = ""

    def _log_refusal(self, lost: int) -> None:
        refusal = next((file.refusal for file in self._files.values() if file.refusal), "")
        if refusal and not self._refusal:
            log.error(
                "%s: cannot be written (%s); rows wait in memory, at most %d of a table",
                self.folder,
                refusal,
                BUFFERED_ROWS,
            )
        if refusal:
            self._causes[refusal] = None
        if refusal and lost:
            log.error("%s: %d rows are lost so far (%s)", self.folder, sum(self.lost.values()), refusal)
        if self._refusal and not refusal:
            log.warning("%s: can be written again", self.folder)
        self._refusal = refusal

    def _note_missing(self) -> dict[str, int]:
        """Write what never came into the notes of session and fingers; return it by finger."""
        counts = {finger: found.count for finger, found in self.missing.items() if found.count}
        if counts:
            self._descriptions[SESSION] = f'began = "{self._began}"\n{MISSING} = {sum(counts.values())}\n'
        for finger, count in counts.items():
            self._descriptions[f"{finger}/recording.toml"] = self._about(finger, count)
        return counts

    def _about(self, finger: str, missing: int = 0) -> str:
        empty = Recording(
            f"{self.folder.name} {finger}",
            np.empty(0),
            np.empty(0, dtype=np.int64),
            {"normal_force": np.empty(0)},
            Fingertip(self._radius, finger),
            self._sensors,
            {"began": self._began} | ({MISSING: missing} if missing else {}),
            self._start or 0,
        )
        return toml_text(empty)

    def _seal(self) -> None:
        rows, lost = sum(self.rows.values()), sum(self.lost.values())
        text = f'began = "{self._began}"\nclosed = true\nrows = {rows}\nlost = {lost}\n'
        if self.dropped:
            text += f"dropped = {self.dropped}\n"
        if missing := sum(found.count for found in self.missing.values()):
            text += f"{MISSING} = {missing}\n"
        self._descriptions[SESSION] = text
        self._describe(SESSION)

    def _describe(self, name: str) -> None:
        """See to it that the file ``name`` says what it should; what cannot be written is tried again."""
        path, data = self.folder / name, self._descriptions[name].encode()
        try:
            if path.exists() and path.read_bytes() == data:
                return
            path.parent.mkdir(parents=True, exist_ok=True)
            _overwrite(path, data)
        except OSError:
            self.lost[name] = 1
        else:
            self.lost.pop(name, None)


def _overwrite(path: Path, data: bytes) -> None:
    """Put ``data`` in the place of what is in ``path``, which takes no room on a disk that is full."""
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT, 0o666), "wb") as file:
        file.write(data)
        file.truncate()


def _file(message: messages.Message) -> str:
    if isinstance(message, messages.OF_NODES):
        return FILE_OF_MESSAGE[type(message)]
    return f"{folder_name(message.finger)}/{FILE_OF_MESSAGE[type(message)]}"


def folder_name(finger: str) -> str:
    """Return the folder of a finger, whose name may come from the wire and must not lead out of it."""
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in finger) or "_"


class BackgroundWriter:
    """Hands messages to a :class:`RecordingWriter` in a thread; the oldest give way, and are counted."""

    def __init__(
        self, writer: RecordingWriter, capacity: int = QUEUE_MESSAGES, period: float = LOOK_PERIOD_S
    ) -> None:
        self.writer = writer
        self._queue: deque[messages.Message] = deque(maxlen=capacity)
        self._offered = 0  # raised by the loop only
        self._taken = 0  # raised by the writing thread only
        self._period = period
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        """Messages that newer ones pushed out before they were written."""
        return max(self._offered - self._taken - len(self._queue), 0)

    def offer(self, message: messages.Message) -> None:
        """Queue ``message``; never waits."""
        self._queue.append(message)
        self._offered += 1

    def close(self) -> None:
        """Write what is left and close the recording."""
        self._stop.set()
        self._thread.join()
        self._drain()
        self.writer.dropped = self.dropped
        self.writer.close()

    def _run(self) -> None:
        if sys.platform == "linux":  # elsewhere this is the priority of the whole process
            with contextlib.suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
        due = 0.0
        while not self._stop.wait(self._period):
            self._drain()
            if time.monotonic() >= due:
                due = time.monotonic() + FLUSH_PERIOD_S
                self.writer.flush()

    def _drain(self) -> None:
        for _ in range(len(self._queue)):
            message = self._queue.popleft()
            self._taken += 1
            self.writer.write(message)
