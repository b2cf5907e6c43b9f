"""Run the check page until it is interrupted."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from vegrip.web.check.controller import Controller
from vegrip.web.check.page import routes
from vegrip.web.server import serve


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
