"""``vegrip grasp`` and ``vegrip release``: ask a running node, wait, and say how it ended."""

import time
from typing import Annotated, Any

import typer

from vegrip.cli._options import JSON, NODE_NAME
from vegrip.cli._terminal import answer
from vegrip.errors import DeviceError

POLL_PERIOD_S = 0.05
GRACE_S = 2.0  # [s] beyond the time of the goal
ENDED = ("held", "missed", "weak", "released")
REACHED = ("held", "released")

TIMEOUT = Annotated[float, typer.Option(min=0.1, max=600.0, help="Then the result is what there is [s].")]


def grasp(
    node: NODE_NAME,
    force: Annotated[float, typer.Option(min=0.0, help="Every finger closes with so much [N].")] = 2.0,
    max_force: Annotated[
        float, typer.Option(min=0.0, max=1000.0, help="Most for this object [N]; never above the limits.")
    ] = 1000.0,
    margin: Annotated[
        float, typer.Option(min=-1.0, max=1.0, help="Lower bound of the slip margin that counts as held [1].")
    ] = 0.0,
    timeout: TIMEOUT = 5.0,
    as_json: JSON = False,
) -> None:
    """Close around an object, and say whether it is held.

    It is when two fingers touch (the thumb is one), press as asked to, and the lower bound of each slip
    margin has been at --margin for 0.2 s; without a margin force alone decides. Else the exit code is 4.

    Example: vegrip grasp grasp_force --force 3 --max-force 8

    """
    _ask(node, "grasp", as_json, force=force, max_force=max_force, margin=margin, timeout=timeout)


def release(
    node: NODE_NAME,
    rate: Annotated[float, typer.Option(min=0.1, max=1000.0, help="By which the force falls [N/s].")] = 10.0,
    timeout: TIMEOUT = 5.0,
    as_json: JSON = False,
) -> None:
    """Release what is held, slowly; the hand stays open until the next grasp.

    Example: vegrip release grasp_force

    """
    _ask(node, "release", as_json, rate=rate, timeout=timeout)


def _ask(node: str, what: str, as_json: bool, **goal: float) -> None:
    from vegrip.runtime.registry import ask, find_node

    entry = find_node(node)
    ask(entry, what, **goal)
    end = time.monotonic() + goal["timeout"] + GRACE_S
    status: dict[str, Any] = ask(entry, "grasp_status")
    while status["phase"] not in ENDED and time.monotonic() < end:
        time.sleep(POLL_PERIOD_S)
        status = ask(entry, "grasp_status")
    phase, reason = status["phase"], status["reason"]
    result = {
        "phase": phase,
        "reached_goal": phase in REACHED,
        "stalled": phase == "weak",
        "reason": reason,
        "normal_force": status["normal_force"],
        "margin": status["margin"],
    }
    sentence = f"{phase}{f': {reason}' if reason else ''}"
    if phase in REACHED:
        more = f", {status['normal_force']:.2f} N, margin above {status['margin']:.2f}"
        answer(result, lambda: typer.echo(sentence + (more if phase == "held" else "")), as_json=as_json)
        return
    answer(result, lambda: None, as_json=as_json)
    raise DeviceError(sentence)
