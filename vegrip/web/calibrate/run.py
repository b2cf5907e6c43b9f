"""Run the calibration page until it is interrupted."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from vegrip.web.calibrate.controller import Calibrator
from vegrip.web.calibrate.page import routes
from vegrip.web.server import serve


def run(folder: Path, node: str, port: int, announce: Callable[[str], None], *, opens: bool = False) -> None:
    """Guide a calibration on a page.

    Raises:
        DeviceError: the port is in use.

    """
    with closing(Calibrator(folder, node)) as calibrator:
        calibrator.look()
        serve(routes(calibrator), port, announce, opens=opens)
