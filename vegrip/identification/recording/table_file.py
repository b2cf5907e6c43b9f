"""A table that grows on disk by whole lines, and survives a full disk and a deleted folder."""

import errno
import io
import os
from collections import deque
from pathlib import Path
from typing import Final

BUFFERED_ROWS: Final = 50_000
"""Rows kept while the disk refuses them: a hundred seconds of a finger at 500 Hz, some 5 MB."""


class TableFile:
    """Rows wait in memory until :meth:`flush`; the header goes with the first of them."""

    def __init__(self, path: Path, header: str) -> None:
        self.refusal = ""  # why the disk took nothing the last time it was asked
        self.accident = ""  # what was done to the file while it was written; the writer clears it
        self.moved = 0  # rows in files that were moved away
        self._path = path
        self._header = header
        self._waiting: deque[str] = deque()
        self._file: io.FileIO | None = None
        self._headed = False
        self._torn = False  # the last write ended within a line
        self._place: tuple[int, int] | None = None  # device and inode of the file
        self._rows = self._size = 0  # what is in the file: rows, [bytes]
        self._is_remade = False  # the file was lost, and is made anew

    def add(self, row: str) -> None:
        self._waiting.append(row)

    def flush(self) -> int:
        """Write what waits; what the disk refuses is kept for the next time.

        Return how many rows are lost: forgotten, the oldest first, because more than ``BUFFERED_ROWS`` wait,
        or deleted with the file, which is then begun anew.
        """
        gone = self._missing()
        self.refusal = ""
        if self._waiting:
            try:
                self._write()
            except OSError as error:
                self.refusal = error.strerror or str(error)
        forgotten = max(len(self._waiting) - BUFFERED_ROWS, 0)
        for _ in range(forgotten):
            self._waiting.popleft()
        return gone + forgotten

    def give_up(self) -> int:
        """Forget the rows that still wait; return how many of all are not on disk in the end."""
        left = len(self._waiting) + self._missing()
        self._waiting.clear()
        return left

    def close(self) -> None:
        """Close the file; rows that wait are dropped."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _open(self) -> io.FileIO:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        if self._is_remade:  # never into a file that another program has put in its place
            return io.FileIO(
                os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_EXCL, 0o666), "a"
            )
        return self._path.open("ab", buffering=0)

    def _write(self) -> None:
        if self._file is None:
            self._file = self._open()
            self._place = self._found()
        if not self._headed:
            self._write_lines(deque([self._header]))
            self._headed = True
        waiting = len(self._waiting)
        try:
            self._write_lines(self._waiting)
        finally:
            self._rows += waiting - len(self._waiting)

    def _found(self) -> tuple[int, int] | None:
        try:
            found = self._path.stat()
        except OSError:
            return None
        return found.st_dev, found.st_ino

    def _missing(self) -> int:
        """Return how many rows were in the file and are not any more, and begin anew when it is gone.

        A file that was deleted can still be written, without complaint: only its name shows that.
        """
        if not isinstance(self._file, io.FileIO):
            return 0
        if self._found() != self._place:
            moved = os.fstat(self._file.fileno()).st_nlink > 0
            self.accident = "moved away" if moved else "deleted"
            self.moved += self._rows if moved else 0
            lost = 0 if moved else self._rows
            self.close()
            self._headed = self._torn = False
            self._rows = self._size = 0
            self._is_remade = True
            return lost
        if os.fstat(self._file.fileno()).st_size >= self._size:
            return 0
        return self._shortened()

    def _shortened(self) -> int:
        self.accident = "shortened"
        with self._path.open("rb") as file:
            lines, last = 0, b"\n"
            while block := file.read(1 << 20):
                lines, last = lines + block.count(b"\n"), block[-1:]
            self._size = file.tell()
        left = max(min(lines - 1, self._rows), 0)
        lost, self._rows = self._rows - left, left
        self._headed, self._torn = lines > 0, last != b"\n"
        return lost

    def _write_lines(self, lines: deque[str]) -> None:
        data = ("\n".join(lines) + "\n").encode()
        if self._torn:  # seal a torn line, so that a reader loses it alone and not the one after it
            data = b"\n" + data
        done = 0
        try:
            while done < len(data):
                written = self._write_some(data[done:])
                if not written:
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                self._torn = data[done + written - 1 : done + written] != b"\n"
                done += written
                self._size += written
        finally:
            whole = data[:done].count(b"\n") - (data[:1] == b"\n" and done > 0)
            for _ in range(whole):
                lines.popleft()

    def _write_some(self, data: bytes) -> int:
        return (self._file.write(data) if self._file else 0) or 0
