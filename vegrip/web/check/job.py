"""A command of vegrip in a process of its own, with its progress, that can be stopped."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import IO, Any

LINES = 6  # of progress that are kept
END_GRACE_S = 3.0  # [s] a stopped command has to end by itself


class Job:
    """One running command; ``ended`` is called from a thread of its own with its exit code and result.

    Args:
        arguments: of ``vegrip``, ``--json`` is added.
        ended: called with exit code, the JSON it printed (None when it printed none) and its last words.

    """

    def __init__(
        self,
        arguments: Sequence[str],
        ended: Callable[[int, dict[str, Any] | None, str], None],
    ) -> None:
        self.arguments = list(arguments)
        self.lines: list[str] = []
        self.started = time.monotonic()
        self.stopped = False
        self._ended = ended
        self._output: IO[str] = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115 (closed in _run)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "vegrip", *self.arguments, "--json"],
            stdout=self._output,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            start_new_session=True,  # its workers are stopped with it
        )
        self._thread = threading.Thread(target=self._run, name="job", daemon=True)
        self._thread.start()

    @property
    def elapsed(self) -> float:
        """Since its start [s]."""
        return time.monotonic() - self.started

    def stop(self) -> None:
        """End it."""
        self.stopped = True
        self._signal(signal.SIGINT)
        threading.Timer(END_GRACE_S, self._signal, (signal.SIGKILL,)).start()

    def wait(self) -> None:
        """Return when it has ended."""
        self._thread.join()

    def _run(self) -> None:
        assert self._process.stderr is not None  # noqa: S101
        with self._process.stderr as told:
            for line in told:
                self.lines = [*self.lines, line.strip()][-LINES:]
        code = self._process.wait()
        self._output.seek(0)
        text = self._output.read()
        self._output.close()
        self._ended(code, _parsed(text), self.lines[-1] if self.lines else "")

    def _signal(self, number: signal.Signals) -> None:
        if self._process.poll() is None:
            with suppress(ProcessLookupError):  # it has ended meanwhile
                os.killpg(self._process.pid, number)


def _parsed(text: str) -> dict[str, Any] | None:
    try:
        told = json.loads(text)
    except ValueError:
        return None
    return told if isinstance(told, dict) else None
