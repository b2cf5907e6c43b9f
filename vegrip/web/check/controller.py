"""Runs what the page asks for, one command after the other, and keeps what came out."""

import shlex
import shutil
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vegrip.errors import InputError, UsageError
from vegrip.web.check.job import Job
from vegrip.web.check.session import Rung, Session, load, save

MOST_COMMANDS = 100  # that are shown


@dataclass(frozen=True)
class Task:
    """A command to run, and what to do with what it prints."""

    what: str
    arguments: list[str]
    take: Callable[[dict[str, Any]], None]


Step = Callable[[], Task]
"""Gives the next task when it is its turn: which model it is about may depend on those before."""


class Controller:
    """The state of a check and the work that is going on; all methods may be called from any thread.

    Args:
        recording: folder.
        model: model file to begin with, None = the paper's.
        folder: where models and state are kept; made when absent.
        options: of fit, compare, diagnose and add, e.g. ``--tolerance 0.01``.

    Raises:
        InputError: the folder is the check of another recording.

    """

    def __init__(
        self, recording: Path, model: Path | None, folder: Path, options: tuple[str, ...] = ()
    ) -> None:
        self._model, self._folder, self._options = model, folder, list(options)
        self._recording = recording
        self._lock = threading.RLock()
        folder.mkdir(parents=True, exist_ok=True)
        name = str(recording.resolve())
        self.session = load(folder, name) or Session(name)
        self.commands: list[str] = []
        self.error = ""
        self.note = ""
        self.job: Job | None = None
        self.what = ""
        self.version = 0
        self._queue: list[Step] = []

    @property
    def name(self) -> str:
        """Of the recording."""
        return self._recording.name

    @property
    def folder(self) -> Path:
        """Where the models are kept."""
        return self._folder

    def begin(self) -> None:
        """Fit the first model, unless a former check has; compare and diagnose what is not yet."""
        with self._lock:
            if self.session.rung is None:
                self._start([self._fit, self._compare, self._diagnose])
            else:
                self.judge()

    def judge(self) -> None:
        """Compare and diagnose the model that is looked at, what is not yet."""
        with self._lock:
            rung = self._standing()
            steps: list[Step] = [self._compare] if rung.comparison is None else []
            self._start([*steps, self._diagnose] if rung.diagnosis is None else steps)

    def add(self, effect: str) -> None:
        """Add an effect to the model that is looked at, refit, compare and diagnose."""
        with self._lock:
            rung = self._standing()
            if effect in self.session.effects:
                raise UsageError(f"the model has {effect} already")
            file = self.session.next_file(effect)
            (self._folder / file).unlink(missing_ok=True)  # of an addition that was stopped
            arguments = ["add", effect, *self._with(rung.model), "-o", self._path(file), *self._options]
            parent = self.session.current

            def take(told: dict[str, Any]) -> None:
                added = Rung(file, effect, parent, told["error"]["after"])
                added.parameters, added.warnings = told["parameters"], told["warnings"]
                self.session.add(added)

            task = Task(f"adding {effect.replace('_', ' ')}", arguments, take)
            self._start([lambda: task, self._compare, self._diagnose])

    def undo(self) -> None:
        """Go back to the model before the last effect."""
        with self._lock:
            self._be_free()
            self.session.undo()
            self._changed()

    def look_at(self, place: int) -> None:
        """Look at another of the models."""
        with self._lock:
            self._be_free()
            if not 0 <= place < len(self.session.rungs):
                raise UsageError("there is no such model")
            self.session.current = place
            self._changed()

    def stop(self) -> None:
        """Stop what is running; what was found before stays."""
        with self._lock:
            self._queue.clear()
            if self.job is not None:
                self.job.stop()

    def write_model(self, name: str) -> None:
        """Copy the model that is looked at to a file of that name.

        Raises:
            UsageError: the name is none, or is taken.
            InputError: it cannot be written.

        """
        with self._lock:
            rung, path = self._standing(), Path(name)
            if not name or path.suffix != ".toml":
                raise UsageError("a model file ends in .toml")
            if path.exists():
                raise UsageError(f"{path} is there already; give another name")
            try:
                shutil.copyfile(self._folder / rung.model, path)
            except OSError as error:
                raise InputError(f"{path} cannot be written: {error.strerror}") from None
            self._say(f"saved as {path}", f"cp {shlex.quote(self._path(rung.model))} {shlex.quote(name)}")

    def use_in_node(self, node: str) -> None:
        """Let a running node go on with the model that is looked at.

        Raises:
            VegripError: no such node, or it refuses the model.

        """
        from vegrip.runtime.client import ask  # noqa: PLC0415 (a check needs no node)
        from vegrip.runtime.registry import find_node  # noqa: PLC0415

        with self._lock:
            file = (self._folder / self._standing().model).resolve()
        ask(find_node(node), "set_parameter", name="tip.model", value=str(file))
        self._say(
            f"{node} goes on with this model", f"vegrip param set {node} tip.model {shlex.quote(str(file))}"
        )

    def close(self) -> None:
        """Stop what is running and wait for its end."""
        self.stop()
        job = self.job
        if job is not None:
            job.wait()

    def _fit(self) -> Task:
        file = self.session.next_file(None)
        (self._folder / file).unlink(missing_ok=True)
        model = ["--model", str(self._model)] if self._model is not None else []
        arguments = ["fit", str(self._recording), *model, "-o", self._path(file), *self._options]

        def take(told: dict[str, Any]) -> None:
            rung = Rung(file, None, None, told["error"])
            rung.parameters, rung.warnings = told["parameters"], told.get("warnings", [])
            self.session.add(rung)

        return Task("fitting the first model", arguments, take)

    def _compare(self) -> Task:
        rung = self._standing()
        arguments = ["compare", *self._with(rung.model), "--curves", *self._options]

        def take(told: dict[str, Any]) -> None:
            rung.comparison = told
            rung.error = told["error"]

        return Task("comparing", arguments, take)

    def _diagnose(self) -> Task:
        rung = self._standing()

        def take(told: dict[str, Any]) -> None:
            rung.diagnosis = told

        return Task(
            "looking for what is missing", ["diagnose", *self._with(rung.model), *self._options], take
        )

    def _with(self, model: str) -> list[str]:
        return [str(self._recording), "--model", self._path(model)]

    def _path(self, file: str) -> str:
        return str(self._folder / file)

    def _standing(self) -> Rung:
        rung = self.session.rung
        if rung is None:
            raise UsageError("there is no model yet; the first fit has not ended")
        return rung

    def _be_free(self) -> None:
        if self.job is not None:
            raise UsageError(f"{self.what} is going on; wait for it or stop it")

    def _start(self, steps: list[Step]) -> None:
        self._be_free()
        self.error = self.note = ""
        self._queue = steps
        self._next()

    def _next(self) -> None:
        self._changed()
        if not self._queue:
            return
        task = self._queue.pop(0)()
        self.what = task.what
        self._note_command("vegrip " + shlex.join(task.arguments))
        self.job = Job(task.arguments, lambda *end: self._take(task, *end))

    def _take(self, task: Task, code: int, told: dict[str, Any] | None, last_words: str) -> None:
        with self._lock:
            stopped = self.job is not None and self.job.stopped
            self.job = None
            if code == 0 and told is not None and not stopped:
                task.take(told)
                save(self.session, self._folder)
                self._next()
                return
            self._queue.clear()
            self.error = (
                f"{task.what} was stopped; what was found before is kept"
                if stopped
                else last_words.removeprefix("vegrip: ") or f"{task.what} ended with exit code {code}"
            )
            self._changed()

    def _say(self, note: str, command: str) -> None:
        with self._lock:
            self.note, self.error = note, ""
            self._note_command(command)
            self._changed()

    def _note_command(self, command: str) -> None:
        self.commands = [*self.commands, command][-MOST_COMMANDS:]

    def _changed(self) -> None:
        self.version += 1
