"""A table that grows on disk by whole lines, and survives a disk that is full for a while."""

import os
from pathlib import Path
from typing import Protocol


class Raw(Protocol):
    """The unbuffered file underneath."""

    def write(self, data: bytes, /) -> int | None:
        """Write some of ``data``; return how much."""

    def close(self) -> None:
        """Close the file."""


class TableFile:
    """Rows wait in memory until :meth:`flush`; the header goes with the first of them."""

    def __init__(self, path: Path, header: str) -> None:
        self._path = path
        self._header = header
        self._waiting: list[str] = []
        self._file: Raw | None = None
        self._headed = False
        self._torn = False  # the last write ended within a line

    def add(self, row: str) -> None:
        """Take one row, without its line end."""
        self._waiting.append(row)

    def flush(self) -> int:
        """Write what waits and forget it; return how many rows the disk refused."""
        rows, self._waiting = self._waiting, []
        if not rows:
            return 0
        try:
            if self._file is None:
                self._file = self._open()
            lines = rows if self._headed else [self._header, *rows]
            # a torn line is sealed, so that a reader loses it alone and not the one after it
            self._put(("\n" if self._torn else "") + "\n".join(lines) + "\n")
        except OSError:
            return len(rows)
        self._headed = True
        return 0

    def close(self) -> None:
        """Close the file; rows that wait are dropped."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _open(self) -> Raw:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        return self._path.open("ab", buffering=0)

    def _put(self, text: str) -> None:
        data = text.encode()
        while data:
            written = self._file.write(data) if self._file else 0
            if not written:
                raise OSError(os.strerror(28))
            self._torn = data[written - 1 : written] != b"\n"
            data = data[written:]
