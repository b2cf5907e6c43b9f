"""Runs ``vegrip calibrate`` for the page, and keeps what it told."""

import shlex
import threading
from pathlib import Path
from typing import Any

from vegrip.errors import UsageError
from vegrip.web.check.job import Job

MOST_COMMANDS = 100  # that are shown


class Calibrator:
    """The state of a calibration and the command that is going on; any thread may call it.

    Args:
        folder: of the calibration.
        node: that trials are recorded from; empty: none is proposed.

    """

    def __init__(self, folder: Path, node: str = "") -> None:
        self.folder, self.node = folder, node
        self.told: dict[str, Any] | None = None
        self.commands: list[str] = []  # that did something
        self.error = ""
        self.job: Job | None = None
        self.what = ""
        self.version = 0
        self._lock = threading.RLock()

    @property
    def has_begun(self) -> bool:
        """Whether the folder is a calibration already."""
        return (self.folder / "calibration.json").is_file()

    def look(self) -> None:
        """Judge what there is, when the folder is a calibration."""
        if self.has_begun:
            self._run("judging what there is")

    def begin(self, radius: str, force: str = "") -> None:
        """Begin with a fingertip.

        Raises:
            UsageError: no radius.

        """
        if not radius.strip():
            raise UsageError("state the radius of the fingertip, e.g. 9 mm")
        limit = ["--normal-force", force.strip()] if force.strip() else []
        self._run("planning the first trial", "--radius", radius.strip(), *limit)

    def take(self, recording: str, kind: str = "") -> None:
        """Take the recording of a trial.

        Raises:
            UsageError: no folder.

        """
        if not recording.strip():
            raise UsageError("give the folder of the recording")
        chosen = ["--kind", kind] if kind else []
        self._run("looking at the recording", "--take", recording.strip(), *chosen)

    def record(self, node: str, finger: str) -> None:
        """Record the next trial from a running node.

        Raises:
            UsageError: no node.

        """
        if not node.strip():
            raise UsageError("name the running node, e.g. grasp_force")
        self.node = node.strip()
        self._run("recording", "--node", self.node, "--finger", finger.strip() or "index", "--no-ask")

    def practise(self, seed: int) -> None:
        """Do all trials on a virtual fingertip."""
        self._run("a virtual fingertip is measured", "--virtual", str(seed))

    def drop(self, number: int) -> None:
        """Forget a trial."""
        self._run("without that trial", "--drop", str(number))

    def end(self) -> None:
        """Look for what the model lacks, and write model and report."""
        self._run("looking for what the model lacks", "--end")

    def stop(self) -> None:
        """Stop what is running; what was recorded stays."""
        with self._lock:
            if self.job is not None:
                self.job.stop()

    def close(self) -> None:
        """Stop what is running and wait for its end."""
        self.stop()
        job = self.job
        if job is not None:
            job.wait()

    def motion(self) -> Path | None:
        """Return the file of the next trial's motion."""
        found = (self.told or {}).get("motion")
        return Path(found) if found and Path(found).is_file() else None

    def _run(self, what: str, *options: str) -> None:
        with self._lock:
            if self.job is not None:
                raise UsageError(f"{self.what} is going on; wait for it or stop it")
            arguments = ["calibrate", str(self.folder), *options]
            self.error, self.what = "", what
            self.commands = [*self.commands, "vegrip " + shlex.join(arguments)][-MOST_COMMANDS:]
            self.version += 1
            self.job = Job(arguments, self._take)

    def _take(self, code: int, told: dict[str, Any] | None, last_words: str) -> None:
        with self._lock:
            stopped = self.job is not None and self.job.stopped
            self.job = None
            self.version += 1
            if code == 0 and told is not None and not stopped:
                self.told = told
                return
            if told is None:  # it did nothing: what is shown is what leads here
                self.commands = self.commands[:-1]
            if stopped:
                self.error = f"{self.what} was stopped; what was recorded is kept"
            else:
                self.error = last_words.removeprefix("vegrip: ") or f"{self.what} ended with exit code {code}"
