"""Programs: the table of what ``vegrip node`` and launch files can start, and the contract of each.

A program is a function ``build(settings, context) -> Node`` in a module of its own. It reads its
``settings`` (the ``parameters`` table of the node's configuration) through :func:`vegrip.config.build`
and returns a node that has not been configured yet; it opens nothing and takes no time.
"""

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Any

from vegrip.errors import UsageError, suggestion
from vegrip.runtime.node import Node

PROGRAMS: dict[str, tuple[str, str]] = {
    # name: (module:function, one line of help)
    "grasp_force": (
        "vegrip.nodes.grasp_force:build",
        "fingertip states in, slip margins and force commands out",
    ),
    "virtual_hand": ("vegrip.nodes.virtual_hand:build", "five simulated soft fingertips that hold an object"),
    "record": ("vegrip.nodes.record:build", "write what is on the bus to a recording"),
    "replay": ("vegrip.nodes.replay:build", "send a recording as if it were a hand"),
    "monitor": ("vegrip.nodes.monitor:build", "live table of every finger"),
    "echo": (
        "vegrip.runtime.echo:build",
        "answer every state with a command at once; for latency measurements",
    ),
}
GROUP = "vegrip.programs"
"""Entry-point group under which other packages offer their programs."""


@dataclass(frozen=True)
class NodeContext:
    """What a program receives besides its settings."""

    name: str
    namespace: str = ""  # "" or like "left" or "lab/left"
    fingers: tuple[str, ...] = ("thumb", "index", "middle", "ring", "little")  # in the order of the bus
    tick_period: float = 0.002  # [s] of on_tick


Build = Callable[[Mapping[str, Any], NodeContext], Node]


def find_program(name: str) -> Build:
    """Return the ``build`` function of a program: a name of the table, an entry point or ``module:function``.

    Raises:
        UsageError: there is no such program, or it cannot be imported.

    """
    target = _target(name)
    module, _, function = target.partition(":")
    try:
        build: Build = getattr(importlib.import_module(module), function)
    except Exception as error:  # noqa: BLE001 (whatever a program of another package raises when imported)
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise UsageError(f"the program {name!r} cannot be loaded from {target}: {reason}") from None
    if not callable(build):
        raise UsageError(f"the program {name!r} cannot be used: {target} is not a function")
    return build


def _target(name: str) -> str:
    if name in PROGRAMS:
        return PROGRAMS[name][0]
    for point in entry_points(group=GROUP):
        if point.name == name:
            return point.value
    if ":" in name:
        return name
    raise UsageError(
        f"there is no program {name!r}; {suggestion(name, PROGRAMS, 'give module:function, or one of')}"
    )
