"""The parent's end of a child process of the demonstration."""

import multiprocessing
import time
from typing import Any

from vegrip.demo.worker import Job, RunStatistics, serve
from vegrip.errors import DeviceError

START_PATIENCE = (
    600.0  # [s] a first run compiles, a busy machine compiles slowly; a dead child is seen at once
)
END_PATIENCE = 10.0  # [s]


class WorkerHandle:
    """A node in a process of its own."""

    def __init__(self, name: str, job: Job) -> None:
        self.name = name
        self.news: Any = None  # the newest
        self.statistics_at_end: RunStatistics | None = None
        context = multiprocessing.get_context("spawn")  # a fork would inherit the bus and its threads
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs, job), name=name, daemon=True)
        self._process.start()
        theirs.close()

    @property
    def process_id(self) -> int:
        return self._process.pid or 0

    def wait(self, word: str) -> None:
        """Wait until the child says ``word``.

        Raises:
            VegripError: it said that it cannot.
            DeviceError: it died, or says nothing.

        """
        deadline = time.monotonic() + START_PATIENCE
        while time.monotonic() < deadline:
            if self._pipe.poll(0.1) and self._hear() == word:
                return
        raise DeviceError(f"the process of {self.name} does not get ready within {START_PATIENCE:g} s")

    def say(self, word: str) -> None:
        """Tell the child something; one that has gone does not hear it."""
        try:
            self._pipe.send(word)
        except (BrokenPipeError, OSError):
            return

    def listen(self) -> bool:
        """Take in what the child has said; tell whether it still runs."""
        while self.statistics_at_end is None and self._pipe.poll():
            self._hear()
        return self.statistics_at_end is None

    def stop(self) -> None:
        """Ask the child to end, and see that it does."""
        self.say("stop")
        deadline = time.monotonic() + END_PATIENCE
        try:
            while self.statistics_at_end is None and time.monotonic() < deadline:
                if self._pipe.poll(0.05):
                    self._hear()
        except DeviceError:
            pass  # it has ended in another way
        self._process.join(1.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()

    def _hear(self) -> str:
        try:
            word, content = self._pipe.recv()
        except (EOFError, OSError):
            raise DeviceError(f"the process of {self.name} has ended unexpectedly") from None
        if word == "error":
            raise DeviceError(f"{self.name}: {content}")
        if word == "news":
            self.news = content
        if word == "done":
            self.statistics_at_end = content
        return str(word)
