"""The routes of the calibration page."""

from typing import Any

from starlette.routing import Route

from vegrip.web.actions import Actions, action_routes
from vegrip.web.calibrate.controller import Calibrator
from vegrip.web.calibrate.render import body, standing
from vegrip.web.check.render import commands, progress


def routes(calibrator: Calibrator) -> list[Route]:
    """Return the routes of the calibration page."""
    actions: Actions = {
        "begin": lambda told: calibrator.begin(str(told["radius"]), str(told["force"])),
        "take": lambda told: calibrator.take(str(told["recording"]), str(told.get("kind", ""))),
        "record": lambda told: calibrator.record(str(told["node"]), str(told["finger"])),
        "practise": lambda told: calibrator.practise(int(told["seed"])),
        "drop": lambda told: calibrator.drop(int(told["number"])),
        "end": lambda _: calibrator.end(),
        "look": lambda _: calibrator.look(),
        "stop": lambda _: calibrator.stop(),
    }
    return action_routes("calibrate.html", _Shown(calibrator), actions, calibrator.motion)


class _Shown:
    """What the page shows of a calibration."""

    def __init__(self, calibrator: Calibrator) -> None:
        self._calibrator = calibrator

    @property
    def version(self) -> int:
        """Counts changes of the whole."""
        return self._calibrator.version

    def progress(self) -> str:
        """Return what is going on."""
        job = self._calibrator.job
        return "" if job is None else progress(self._calibrator.what, job.elapsed, job.lines)

    def whole(self) -> dict[str, Any]:
        """Return everything else."""
        one = self._calibrator
        level, name = standing(one.told)
        return {
            "name": one.folder.resolve().name,
            "level": level,
            "verdict": name,
            "body": body(one.told, node=one.node, is_busy=one.job is not None),
            "commands": commands(one.commands),
            "error": one.error,
            "note": "",
        }
