"""The check page, served until it is interrupted."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

from starlette.routing import Route

from vegrip.web.check.controller import Controller
from vegrip.web.job_page import Actions, job_routes
from vegrip.web.server import serve


def routes(controller: Controller) -> list[Route]:
    """Return the routes of the check page."""
    actions: Actions = {
        "judge": lambda _: controller.judge(),
        "add": lambda told: controller.add(str(told["effect"])),
        "undo": lambda _: controller.undo(),
        "look_at": lambda told: controller.look_at(int(told["place"])),
        "stop": lambda _: controller.stop(),
        "hold_back": lambda told: controller.hold_back(str(told["episodes"])),
        "compare_with": lambda told: controller.compare_with(_place(told["place"])),
        "compare_with_file": lambda told: controller.compare_with_file(str(told["name"])),
        "plan": lambda told: controller.plan(str(told["candidates"]), str(told["duration"])),
        "write_model": lambda told: controller.write_model(str(told["name"])),
        "use_in_node": lambda told: controller.use_in_node(str(told["node"])),
    }
    return job_routes("check.html", controller, actions)


def _place(told: Any) -> int | None:
    return None if told == "before" else int(told)


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
