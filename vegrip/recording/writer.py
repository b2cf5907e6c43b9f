"""Recording what is on the bus: one folder per session, in it one recording per finger.

::

    session/session.toml            when it began, whether it was closed, what was lost
    session/diagnostics.csv         NodeStatus of every node
    session/thumb/recording.toml    with recording.csv: a recording like any other
    session/thumb/contact.csv       ContactEstimate; slip_margin.csv, force_command.csv, model_health.csv,
                                    learned.csv

Rows are whole lines, written out by :meth:`RecordingWriter.flush`, so that after a crash at most what came
since the last flush is missing. Nothing here raises once the folder is made: what the disk refuses is
counted in :attr:`RecordingWriter.lost`.
"""

from collections import Counter
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from vegrip.errors import RecordingError
from vegrip.messages import Message, NodeStatus
from vegrip.recording.data import Fingertip, Recording
from vegrip.recording.folder import toml_text
from vegrip.recording.rows import FILES, header, row
from vegrip.recording.table_file import TableFile

SESSION = "session.toml"


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
        self._radius = radius
        self._sensors = dict(sensors or {})
        self._files: dict[str, TableFile] = {}
        self._start: int | None = None
        self._began = datetime.now(UTC).isoformat(timespec="seconds")
        self._make()

    def begin(self, stamp: int) -> None:
        """Let t = 0 be at ``stamp`` [ns]; without it, it is at the first message."""
        self._start = stamp

    def write(self, message: Message) -> None:
        """Take one message; it reaches the disk with the next :meth:`flush`."""
        if self._start is None:
            self._start = message.stamp
        name = _file(message)
        if name not in self._files:
            self._files[name] = self._new(name, message)
        self._files[name].add(row(message, self._start))
        self.rows[name] += 1

    def flush(self) -> None:
        """Write out everything taken; what the disk refuses is kept for a while, then counted as lost."""
        for name, file in self._files.items():
            self.lost[name] += file.flush()

    def close(self) -> None:
        """Write out what is left and seal the session; may be called twice."""
        self.flush()
        for name, file in self._files.items():
            self.lost[name] += file.give_up()
            file.close()
        self._describe(closed=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _make(self) -> None:
        if (self.folder / SESSION).exists() or (self.folder / "recording.toml").exists():
            raise RecordingError(f"{self.folder}: holds a recording already; choose another folder")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / SESSION).write_text(f'began = "{self._began}"\n', encoding="utf-8")
        except OSError as error:
            raise RecordingError(f"{self.folder}: cannot be written ({error.strerror or error})") from None

    def _new(self, name: str, message: Message) -> TableFile:
        if name.endswith("/recording.csv"):
            self._try(self.folder / name.replace(".csv", ".toml"), self._about(name.partition("/")[0]))
        return TableFile(self.folder / name, header(type(message)))

    def _about(self, finger: str) -> str:
        empty = Recording(
            f"{self.folder.name} {finger}",
            np.empty(0),
            np.empty(0, dtype=np.int64),
            {"normal_force": np.empty(0)},
            Fingertip(self._radius, finger),
            self._sensors,
            {"began": self._began},
            self._start or 0,
        )
        return toml_text(empty)

    def _describe(self, *, closed: bool) -> None:
        rows, lost = sum(self.rows.values()), sum(self.lost.values())
        text = f'began = "{self._began}"\nclosed = {str(closed).lower()}\nrows = {rows}\nlost = {lost}\n'
        self._try(self.folder / SESSION, text)

    def _try(self, path: Path, text: str) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        except OSError:
            self.lost[str(path.relative_to(self.folder))] += 1


def _file(message: Message) -> str:
    if isinstance(message, NodeStatus):
        return FILES[NodeStatus]
    # a finger's name may come from the wire: it must not lead out of the folder
    finger = "".join(c if c.isalnum() or c in "-_" else "_" for c in message.finger) or "_"
    return f"{finger}/{FILES[type(message)]}"
