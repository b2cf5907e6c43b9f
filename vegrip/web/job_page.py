"""A page whose work are commands of vegrip, each in a process of its own, one at a time."""

import asyncio
import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import suppress
from html import escape
from pathlib import Path
from string import Template
from typing import IO, Any

from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from vegrip.errors import UsageError
from vegrip.web.markup import commands
from vegrip.web.server import STATIC, answering, events

LINES = 6  # of progress that are kept
END_GRACE_S = 3.0  # [s] a stopped command has to end by itself
MOST_COMMANDS = 100  # that are shown
LOOK_PERIOD_S = 0.25  # [s] between two looks at what is new

Actions = Mapping[str, Callable[[dict[str, Any]], None]]
"""What the page can ask for, by name; each is given what the page sent."""


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
        """Interrupt the command; after ``END_GRACE_S`` it is killed."""
        self.stopped = True
        self._signal(signal.SIGINT)
        threading.Timer(END_GRACE_S, self._signal, (signal.SIGKILL,)).start()

    def wait(self) -> None:
        self._thread.join()

    def _run(self) -> None:
        assert self._process.stderr is not None  # noqa: S101
        with self._process.stderr as answer:
            for line in answer:
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
        answer = json.loads(text)
    except ValueError:
        return None
    return answer if isinstance(answer, dict) else None


class JobPage(ABC):
    """The state of a page and its running command; any thread may call the methods."""

    kept: str  # by a command that is stopped

    def __init__(self) -> None:
        self.commands: list[str] = []  # that did something
        self.error = self.note = ""
        self.job: Job | None = None
        self.what = ""  # the running command does
        self.version = 0  # counts changes of :meth:`whole`
        self._lock = threading.RLock()

    @abstractmethod
    def shown(self) -> dict[str, Any]:
        """Return ``name``, ``level``, ``verdict`` and ``body`` of the page."""

    @abstractmethod
    def motion(self) -> Path | None:
        """Return the file with the motion of the next experiment or trial, None where there is none."""

    def progress(self) -> str:
        job = self.job
        return "" if job is None else progress(self.what, job.elapsed, job.lines)

    def whole(self) -> dict[str, Any]:
        """Return all that the page shows but the progress, for JSON."""
        return {
            **self.shown(),
            "commands": commands(self.commands),
            "error": self.error,
            "note": self.note,
        }

    def stop(self) -> None:
        """Stop the running command; what was found before stays."""
        with self._lock:
            if self.job is not None:
                self.job.stop()

    def close(self) -> None:
        """Stop the running command and wait for its end."""
        self.stop()
        job = self.job
        if job is not None:
            job.wait()

    def _be_free(self) -> None:
        if self.job is not None:
            raise UsageError(f"{self.what} is going on; wait for it or stop it")

    def _run(self, what: str, arguments: list[str], store: Callable[[dict[str, Any]], None]) -> None:
        """Start a command; ``store`` is called with the JSON that it prints when it succeeds."""
        self.what = what
        self._log_command("vegrip " + shlex.join(arguments))
        self.job = Job(arguments, lambda *end: self._end(store, *end))
        self._changed()

    def _end(
        self,
        store: Callable[[dict[str, Any]], None],
        code: int,
        answer: dict[str, Any] | None,
        last_words: str,
    ) -> None:
        with self._lock:
            stopped = self.job is not None and self.job.stopped
            self.job = None
            if code == 0 and answer is not None and not stopped:
                store(answer)
            else:
                self.error = (
                    f"{self.what} was stopped; {self.kept} is kept"
                    if stopped
                    else last_words.removeprefix("vegrip: ") or f"{self.what} ended with exit code {code}"
                )
                self._fail(answer)
            self._changed()

    @abstractmethod
    def _fail(self, answer: dict[str, Any] | None) -> None:
        """Clean up after a command that printed ``answer`` and failed or was stopped."""

    def _log_command(self, command: str) -> None:
        self.commands = [*self.commands, command][-MOST_COMMANDS:]

    def _changed(self) -> None:
        self.version += 1


def progress(what: str, elapsed: float, lines: Sequence[str]) -> str:
    """Return a running command, its last line and its time [s] as HTML."""
    last = escape(lines[-1]) if lines else "starting"
    return f'<b>{escape(what)}</b> <span class="soft">{last}, {elapsed:.0f} s</span>'


def job_routes(name: str, subject: str, shown: JobPage, actions: Actions) -> list[Route]:
    """Return the routes: the page ``name``, its events, what it asks for, and the motion as a file."""
    html = Template((STATIC / "job.html").read_text("utf-8")).substitute(name=name, subject=subject)

    async def page(_: Request) -> Response:
        return HTMLResponse(html)

    async def live(_: Request) -> Response:
        return StreamingResponse(events(_texts(shown)), media_type="text/event-stream")

    def act(answer: dict[str, Any]) -> dict[str, Any]:
        if answer.get("do") not in actions:
            raise UsageError("the page asks for what this server does not know; load it again")
        actions[answer["do"]](answer)
        return {}

    async def file(_: Request) -> Response:
        found = shown.motion()
        if found is None:
            return JSONResponse({"error": "there is no motion yet"}, 404)
        return FileResponse(found, media_type="application/toml", filename=found.name)

    return [
        Route("/", page),
        Route("/live", live),
        Route("/motion", file),
        Route("/do", answering(act), methods=["POST"]),
    ]


async def _texts(shown: JobPage) -> AsyncIterator[str]:
    version, last = -1, ""
    while True:
        answer: dict[str, Any] = {"progress": shown.progress()}
        if shown.version != version:
            version = shown.version
            answer |= shown.whole()
        text = json.dumps(answer)
        if text != last:
            last = text
            yield text
        await asyncio.sleep(LOOK_PERIOD_S)
