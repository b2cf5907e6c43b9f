"""The routes of the check page."""

from typing import Any

from starlette.routing import Route

from vegrip.web.actions import Actions, action_routes
from vegrip.web.check.controller import Controller
from vegrip.web.check.render import body, commands, progress, verdict


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
    return action_routes("check.html", _Shown(controller), actions, controller.motion)


def _place(told: Any) -> int | None:
    return None if told == "before" else int(told)


class _Shown:
    """What the page shows of a check."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller

    @property
    def version(self) -> int:
        """Counts changes of the whole."""
        return self._controller.version

    def progress(self) -> str:
        """Return what is going on."""
        job = self._controller.job
        return "" if job is None else progress(self._controller.what, job.elapsed, job.lines)

    def whole(self) -> dict[str, Any]:
        """Return everything else."""
        controller = self._controller
        session = controller.session
        rung = session.rung
        level, name, _ = verdict(rung) if rung is not None else ("unknown", "fitting", "")
        return {
            "name": controller.name,
            "level": level,
            "verdict": name,
            "body": body(
                session,
                is_busy=controller.job is not None,
                beside=controller.beside,
                other=controller.other,
                node=controller.node,
            ),
            "commands": commands(controller.commands),
            "error": controller.error,
            "note": controller.note,
        }
