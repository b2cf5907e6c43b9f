"""Runs ``vegrip calibrate`` for the page, and keeps what it told."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

from starlette.routing import Route

from vegrip.errors import UsageError
from vegrip.web.calibrate.render import body, standing
from vegrip.web.job_page import Actions, JobPage, job_routes
from vegrip.web.server import serve


class Calibrator(JobPage):
    """The state of a calibration and the command that is going on; any thread may call it.

    Args:
        folder: of the calibration.
        node: that trials are recorded from; empty: none is proposed.

    """

    kept = "what was recorded"

    def __init__(self, folder: Path, node: str = "") -> None:
        super().__init__()
        self.folder, self.node = folder, node
        self.told: dict[str, Any] | None = None

    @property
    def has_begun(self) -> bool:
        return (self.folder / "calibration.json").is_file()

    def refresh(self) -> None:
        if self.has_begun:
            self._start("judging what there is")

    def begin(self, radius: str, force: str = "") -> None:
        """Begin with a fingertip.

        Raises:
            UsageError: no radius.

        """
        if not radius.strip():
            raise UsageError("state the radius of the fingertip, e.g. 9 mm")
        limit = ["--normal-force", force.strip()] if force.strip() else []
        self._start("planning the first trial", "--radius", radius.strip(), *limit)

    def take(self, recording: str, kind: str = "") -> None:
        """Take the recording of a trial.

        Raises:
            UsageError: no folder.

        """
        if not recording.strip():
            raise UsageError("give the folder of the recording")
        chosen = ["--kind", kind] if kind else []
        self._start("looking at the recording", "--take", recording.strip(), *chosen)

    def record(self, node: str, finger: str) -> None:
        """Record the next trial from a running node.

        Raises:
            UsageError: no node.

        """
        if not node.strip():
            raise UsageError("name the running node, e.g. grasp_force")
        self.node = node.strip()
        self._start("recording", "--node", self.node, "--finger", finger.strip() or "index", "--no-ask")

    def practise(self, seed: int) -> None:
        self._start("a virtual fingertip is measured", "--virtual", str(seed))

    def drop(self, number: int) -> None:
        self._start("without that trial", "--drop", str(number))

    def end(self) -> None:
        self._start("looking for what the model lacks", "--end")

    def motion(self) -> Path | None:
        found = (self.told or {}).get("motion")
        return Path(found) if found and Path(found).is_file() else None

    def shown(self) -> dict[str, Any]:
        """Return ``name``, ``level``, ``verdict`` and ``body`` of the page."""
        level, name = standing(self.told)
        html = body(self.told, node=self.node, is_busy=self.job is not None)
        return {"name": self.folder.resolve().name, "level": level, "verdict": name, "body": html}

    def _start(self, what: str, *options: str) -> None:
        with self._lock:
            self._be_free()
            self.error = ""
            self._run(what, ["calibrate", str(self.folder), *options], self._store)

    def _store(self, told: dict[str, Any]) -> None:
        self.told = told

    def _fail(self, told: dict[str, Any] | None) -> None:
        if told is None:  # it did nothing: what is shown is what leads here
            self.commands = self.commands[:-1]


def routes(calibrator: Calibrator) -> list[Route]:
    actions: Actions = {
        "begin": lambda told: calibrator.begin(str(told["radius"]), str(told["force"])),
        "take": lambda told: calibrator.take(str(told["recording"]), str(told.get("kind", ""))),
        "record": lambda told: calibrator.record(str(told["node"]), str(told["finger"])),
        "practise": lambda told: calibrator.practise(int(told["seed"])),
        "drop": lambda told: calibrator.drop(int(told["number"])),
        "end": lambda _: calibrator.end(),
        "look": lambda _: calibrator.refresh(),
        "stop": lambda _: calibrator.stop(),
    }
    return job_routes("calibrate", "trial", calibrator, actions)


def run(folder: Path, node: str, port: int, announce: Callable[[str], None], *, opens: bool = False) -> None:
    """Guide a calibration on a page.

    Raises:
        DeviceError: the port is in use.

    """
    with closing(Calibrator(folder, node)) as calibrator:
        calibrator.refresh()
        serve(routes(calibrator), port, announce, opens=opens)
