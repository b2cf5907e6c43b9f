"""A table that grows on disk by whole lines, and survives a disk that is full for a while."""

import contextlib
import errno
import os
from collections import deque
from pathlib import Path
from typing import Final, Protocol

KEPT: Final = 50_000
"""Rows kept while the disk refuses them: a hundred seconds of a finger at 500 Hz, some 5 MB."""


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
        self._waiting: deque[str] = deque()
        self._file: Raw | None = None
        self._headed = False
        self._torn = False  # the last write ended within a line

    def add(self, row: str) -> None:
        """Take one row, without its line end."""
        self._waiting.append(row)

    def flush(self) -> int:
        """Write what waits; what the disk refuses is kept for the next time.

        Return how many rows had to be forgotten, the oldest first, because more than ``KEPT`` wait.
        """
        if self._waiting:
            with contextlib.suppress(OSError):
                self._write()
        forgotten = max(len(self._waiting) - KEPT, 0)
        for _ in range(forgotten):
            self._waiting.popleft()
        return forgotten

    def give_up(self) -> int:
        """Forget the rows that still wait and return how many there were."""
        left = len(self._waiting)
        self._waiting.clear()
        return left

    def close(self) -> None:
        """Close the file; rows that wait are dropped."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _open(self) -> Raw:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        return self._path.open("ab", buffering=0)

    def _write(self) -> None:
        if self._file is None:
            self._file = self._open()
        if not self._headed:
            self._put_lines(deque([self._header]))
            self._headed = True
        self._put_lines(self._waiting)

    def _put_lines(self, lines: deque[str]) -> None:
        """Write ``lines`` and take out those that are on disk whole, also when the disk refuses the rest."""
        data = ("\n".join(lines) + "\n").encode()
        if self._torn:  # seal a torn line, so that a reader loses it alone and not the one after it
            data = b"\n" + data
        done = 0
        try:
            while done < len(data):
                written = self._put(data[done:])
                if not written:
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                self._torn = data[done + written - 1 : done + written] != b"\n"
                done += written
        finally:
            whole = data[:done].count(b"\n") - (data[:1] == b"\n" and done > 0)
            for _ in range(whole):
                lines.popleft()

    def _put(self, data: bytes) -> int:
        return (self._file.write(data) if self._file else 0) or 0
