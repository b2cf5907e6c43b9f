"""Runs what the page asks for, one command after the other, and keeps what came out."""

import shlex
import shutil
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from starlette.routing import Route

from vegrip.errors import UsageError
from vegrip.identification.recording.data import episodes_text, parse_episodes
from vegrip.runtime.registry import ask, find_node
from vegrip.web.check.render import body, verdict
from vegrip.web.check.session import Rung, Session, load, save
from vegrip.web.job_page import Actions, JobPage, job_routes
from vegrip.web.server import serve
from vegrip.whole_file import writing


@dataclass(frozen=True)
class Task:
    """A command to run, and what to do with what it prints."""

    what: str
    arguments: list[str]
    store: Callable[[dict[str, Any]], None]


Step = Callable[[], Task]
"""Gives the next task when it is its turn: which model it is about may depend on those before."""


class Controller(JobPage):
    """The state of a check and the work that is going on; all methods may be called from any thread.

    Args:
        recording: folder.
        model: model file to begin with, None = the paper's.
        folder: where models and state are kept; made when absent.
        options: of fit, compare, diagnose and add, e.g. ``--tolerance 0.01``.
        node: that the model may be written into.

    Raises:
        InputError: the folder is the check of another recording.

    """

    kept = "what was found before"

    def __init__(
        self,
        recording: Path,
        model: Path | None,
        folder: Path,
        options: tuple[str, ...] = (),
        node: str = "grasp_force",
    ) -> None:
        super().__init__()
        self.node = node
        self._model, self.folder, self._options = model, folder, list(options)
        self._recording = recording
        folder.mkdir(parents=True, exist_ok=True)
        name = str(recording.resolve())
        self.session = load(folder, name) or Session(name)
        self.beside: int | None = None  # place of the model to compare with; None = the one before
        self.other: tuple[str, dict[str, Any]] | None = None  # a model file to compare with, and how it does
        self._queue: list[Step] = []

    def shown(self) -> dict[str, Any]:
        rung = self.session.rung
        level, name, _ = verdict(rung) if rung is not None else ("unknown", "fitting", "")
        is_busy = self.job is not None
        html = body(self.session, is_busy=is_busy, beside=self.beside, other=self.other, node=self.node)
        return {"name": self.name, "level": level, "verdict": name, "body": html}

    @property
    def name(self) -> str:
        return self._recording.name

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
            if rung.held_back and rung.held_out is None:
                steps.append(self._compare_held_out)
            self._start([*steps, self._diagnose] if rung.diagnosis is None else steps)

    def hold_back(self, episodes: str) -> None:
        """Fit the model that is looked at without ``episodes``, and see how it predicts them.

        Raises:
            UsageError: not a list of episodes, or the model was fitted so.

        """
        with self._lock:
            rung = self._standing()
            numbers = parse_episodes(episodes, "hold back")
            if numbers == parse_episodes(rung.held_back, "hold back"):
                raise UsageError(f"this model was fitted so: held back is {rung.held_back or 'nothing'}")
            held = episodes_text(numbers)
            task = self._fit_task(self._path(rung.model), held, self.session.current)
            self._start([lambda: task, *self._judging(held)])

    def compare_with(self, place: int | None) -> None:
        """Show another of the models beside the one that is looked at; None = the one before it.

        Both are judged on the same episodes: where the other was judged on others, it is compared again.
        """
        with self._lock:
            if place is not None and not 0 <= place < len(self.session.rungs):
                raise UsageError("there is no such model")
            self._be_free()
            self.beside, self.other = place, None
            if place is not None:
                mine, other = self._standing(), self.session.rungs[place]
                held = self._held(mine.held_back)
                command = ["compare", *self._with(mine.model), "--versus", self._path(other.model), *held]
                self._log_command("vegrip " + shlex.join(command))
                if other.held_back != mine.held_back:
                    self._compare_other(f"model {place}", self._path(other.model), place)
                    return
            self._changed()

    def compare_with_file(self, name: str) -> None:
        """Show the model of a file beside the one that is looked at."""
        with self._lock:
            if not name or not Path(name).is_file():
                raise UsageError(f"there is no model file {name!r}")
            self._compare_other(name, name, None)

    def _compare_other(self, name: str, file: str, beside: int | None) -> None:
        def store(answer: dict[str, Any]) -> None:
            self.beside, self.other = beside, (name, answer)

        held = self._held(self._standing().held_back)
        arguments = ["compare", str(self._recording), "--model", file, "--curves", *held, *self._options]
        self._start([lambda: Task(f"comparing with {name}", arguments, store)])

    def plan(self, candidates: str, duration: str = "") -> None:
        """Look for the experiment that separates ``candidates`` (by commas), as a motion to export."""
        with self._lock:
            rung = self._standing()
            if not candidates.strip():
                raise UsageError("name the effects to distinguish, e.g. adhesion,guide_friction")
            file = self._path(f"next-{self.session.current}.toml")
            arguments = ["experiment", *self._with(rung.model), "--candidates", candidates]
            arguments += [*(["--duration", duration] if duration else []), "-o", file, "--force"]
            task = Task("looking for the next experiment", arguments, _into(rung, "experiment"))
            self._start([lambda: task])

    def draft(self) -> None:
        """Look for a law for what the model that is looked at leaves, and for a rival of it."""
        with self._lock:
            rung = self._standing()
            files = [self._path(f"{name}_{self.session.current}.py") for name in ("law", "rival")]
            arguments = ["draft", *self._with(rung.model), "-o", files[0], "--rival", files[1]]
            arguments += ["--curves", "--force", *self._held(rung.held_back), *self._options]
            task = Task("drafting a law for what is left", arguments, _into(rung, "draft"))
            self._start([lambda: task])

    def motion(self) -> Path | None:
        """Return the file of the motion that was found last for the model that is looked at."""
        rung = self.session.rung
        found = None if rung is None or rung.experiment is None else rung.experiment.get("protocol")
        return Path(found) if found and Path(found).is_file() else None

    def add(self, effect: str) -> None:
        """Add an effect, or the file of one, to the model that is looked at; refit, compare and diagnose."""
        with self._lock:
            rung = self._standing()
            name = Path(effect).stem
            if name in self.session.effects:
                raise UsageError(f"the model has {name} already")
            file = self.session.next_file(name)
            (self.folder / file).unlink(missing_ok=True)  # of an addition that was stopped
            held = rung.held_back
            arguments = ["add", effect, *self._with(rung.model), "-o", self._path(file), *self._held(held)]
            arguments += self._options
            parent = self.session.current

            def store(answer: dict[str, Any]) -> None:
                added = Rung(file, name, parent, answer["error"]["after"], held_back=held)
                added.parameters, added.warnings = answer["parameters"], answer["warnings"]
                self.session.add(added)
                self.beside = self.other = None

            task = Task(f"adding {name.replace('_', ' ')}", arguments, store)
            self._start([lambda: task, *self._judging(held)])

    def undo(self) -> None:
        """Go back to the model before the last effect."""
        with self._lock:
            self._be_free()
            self.session.undo()
            self.beside = self.other = None
            self._changed()

    def look_at(self, place: int) -> None:
        with self._lock:
            self._be_free()
            if not 0 <= place < len(self.session.rungs):
                raise UsageError("there is no such model")
            self.session.current = place
            self.beside = self.other = None
            self._changed()

    def stop(self) -> None:
        """Stop the running command and those that wait; what was found before stays."""
        with self._lock:
            self._queue.clear()
            super().stop()

    def write_model(self, name: str) -> None:
        """Copy the model that is looked at to a file of that name."""
        with self._lock:
            rung, path = self._standing(), Path(name)
            if not name or path.suffix != ".toml":
                raise UsageError("a model file ends in .toml")
            if path.exists():
                raise UsageError(f"{path} is there already; give another name")
            with writing(path):
                shutil.copyfile(self.folder / rung.model, path)
            self._say(f"saved as {path}", f"cp {shlex.quote(self._path(rung.model))} {shlex.quote(name)}")

    def use_in_node(self, node: str) -> None:
        """Let a running node go on with the model that is looked at."""
        with self._lock:
            file = (self.folder / self._standing().model).resolve()
        ask(find_node(node), "set_parameter", name="tip.model", value=str(file))
        self._say(
            f"{node} goes on with this model", f"vegrip param set {node} tip.model {shlex.quote(str(file))}"
        )

    def _judging(self, held_back: str) -> list[Step]:
        return [self._compare, *([self._compare_held_out] if held_back else []), self._diagnose]

    def _fit(self) -> Task:
        return self._fit_task(str(self._model) if self._model is not None else "", "", None)

    def _fit_task(self, model: str, held_back: str, parent: int | None) -> Task:
        file = self.session.next_file(None)
        (self.folder / file).unlink(missing_ok=True)
        start = ["--model", model] if model else []
        arguments = ["fit", str(self._recording), *start, "-o", self._path(file), *self._held(held_back)]

        def store(answer: dict[str, Any]) -> None:
            rung = Rung(file, None, parent, answer["error"], held_back=held_back)
            rung.parameters, rung.warnings = answer["parameters"], answer.get("warnings", [])
            self.session.add(rung)
            self.beside = self.other = None

        what = "fitting the first model" if parent is None else "fitting again"
        return Task(what, [*arguments, *self._options], store)

    def _compare(self) -> Task:
        rung = self._standing()
        arguments = ["compare", *self._with(rung.model), "--curves", *self._held(rung.held_back)]

        def store(answer: dict[str, Any]) -> None:
            rung.comparison = answer
            rung.error = answer["error"]

        return Task("comparing", [*arguments, *self._options], store)

    def _compare_held_out(self) -> Task:
        rung = self._standing()
        arguments = ["compare", *self._with(rung.model), "--curves", "--episodes", rung.held_back]
        what = "comparing with what was held back"
        return Task(what, [*arguments, *self._options], _into(rung, "held_out"))

    def _diagnose(self) -> Task:
        rung = self._standing()
        arguments = ["diagnose", *self._with(rung.model), *self._held(rung.held_back), *self._options]
        return Task("looking for what is missing", arguments, _into(rung, "diagnosis"))

    @staticmethod
    def _held(episodes: str) -> list[str]:
        return ["--hold-back", episodes] if episodes else []

    def _with(self, model: str) -> list[str]:
        return [str(self._recording), "--model", self._path(model)]

    def _path(self, file: str) -> str:
        return str(self.folder / file)

    def _standing(self) -> Rung:
        rung = self.session.rung
        if rung is None:
            raise UsageError("there is no model yet; the first fit has not ended")
        return rung

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

        def store(answer: dict[str, Any]) -> None:
            task.store(answer)
            save(self.session, self.folder)
            self._next()

        self._run(task.what, task.arguments, store)

    def _fail(self, answer: dict[str, Any] | None) -> None:
        del answer
        self._queue.clear()

    def _say(self, note: str, command: str) -> None:
        with self._lock:
            self.note, self.error = note, ""
            self._log_command(command)
            self._changed()


def _into(rung: Rung, name: str) -> Callable[[dict[str, Any]], None]:
    return lambda answer: setattr(rung, name, answer)


def routes(controller: Controller) -> list[Route]:
    actions: Actions = {
        "judge": lambda _: controller.judge(),
        "add": lambda answer: controller.add(str(answer["effect"])),
        "undo": lambda _: controller.undo(),
        "look_at": lambda answer: controller.look_at(int(answer["place"])),
        "stop": lambda _: controller.stop(),
        "hold_back": lambda answer: controller.hold_back(str(answer["episodes"])),
        "compare_with": lambda answer: controller.compare_with(_place(answer["place"])),
        "compare_with_file": lambda answer: controller.compare_with_file(str(answer["name"])),
        "draft": lambda _: controller.draft(),
        "plan": lambda answer: controller.plan(str(answer["candidates"]), str(answer["duration"])),
        "write_model": lambda answer: controller.write_model(str(answer["name"])),
        "use_in_node": lambda answer: controller.use_in_node(str(answer["node"])),
    }
    return job_routes("check", "model", controller, actions)


def _place(answer: Any) -> int | None:
    return None if answer == "before" else int(answer)


def run(
    recording: Path,
    model: Path | None,
    folder: Path,
    options: tuple[str, ...],
    port: int,
    announce: Callable[[str], None],
    *,
    opens: bool = False,
    node: str = "grasp_force",
) -> None:
    """Check a model against a recording on a page; models and state are kept in ``folder``.

    Raises:
        DeviceError: the port is in use.
        InputError: ``folder`` is the check of another recording.

    """
    with closing(Controller(recording, model, folder, options, node)) as controller:
        controller.begin()
        serve(routes(controller), port, announce, opens=opens)
