"""The calibration page, served until it is interrupted."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from starlette.routing import Route

from vegrip.web.calibrate.controller import Calibrator
from vegrip.web.job_page import Actions, job_routes
from vegrip.web.server import serve


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
    return job_routes("calibrate.html", calibrator, actions)


def run(folder: Path, node: str, port: int, announce: Callable[[str], None], *, opens: bool = False) -> None:
    """Guide a calibration on a page.

    Raises:
        DeviceError: the port is in use.

    """
    with closing(Calibrator(folder, node)) as calibrator:
        calibrator.look()
        serve(routes(calibrator), port, announce, opens=opens)
