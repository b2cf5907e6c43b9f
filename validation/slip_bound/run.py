"""Many grasps of a world, on as many processes as are given."""

import math
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from multiprocessing import get_context
from typing import Any, Final

import numpy as np

from validation.slip_bound.forced import Look, play
from validation.slip_bound.hand import controller
from validation.slip_bound.informed import informed
from validation.slip_bound.shares import figures
from validation.slip_bound.under_grip import Held, hold
from validation.slip_bound.worlds import Grasp, draw_grasp, friction_class, load_class
from vegrip import GripController

WITHOUT, WITH, TAUGHT = "no slip channel", "slip channel", "slip channel, after a slide"
CHANNELS: Final = (WITHOUT, WITH, TAUGHT)
INFORMED: Final = "no slip channel, by one who knows the world"
EXTREME: Final = "extreme friction"


@dataclass(frozen=True)
class Played:
    """A grasp, and what came of it by each channel."""

    grasp: Grasp
    looks: dict[str, list[Look]]
    held: dict[str, Held]  # under the grip; none where that was not asked for


@cache
def _controller(*, feels_slip: bool) -> GripController:
    return controller(feels_slip=feels_slip)


def play_grasp(world: str, given: tuple[int, bool]) -> Played:
    """Play one grasp by every channel; ``given``: its number, and whether it is held by the grip, too."""
    number, is_held = given
    grasp = draw_grasp(world, number)
    looks = {
        channel: play(
            _controller(feels_slip=channel != WITHOUT), grasp,
            feels_slip=channel != WITHOUT, taught=channel == TAUGHT,
        )
        for channel in CHANNELS
    }  # fmt: skip
    looks[INFORMED] = [informed(world, grasp, look) for look in looks[WITHOUT]]
    held = {
        channel: hold(_controller(feels_slip=channel == WITH), grasp, feels_slip=channel == WITH)
        for channel in ((WITHOUT, WITH) if is_held else ())
    }
    return Played(grasp, looks, held)


def play_world(
    world: str, grasps: int, held: int, *, first: int = 1, jobs: int = 1,
    report: Callable[[int], None] = lambda _: None,
) -> list[Played]:  # fmt: skip
    """Play so many grasps of a world, of which the first ``held`` are held by the grip, too."""
    given = [(first + i, i < held) for i in range(grasps)]
    one = partial(play_grasp, world)
    if jobs == 1:
        return _counted(map(one, given), report)
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        return _counted(pool.map(one, given, chunksize=10), report)


def _counted(results: Iterable[Played], report: Callable[[int], None]) -> list[Played]:
    found = []
    for one in results:
        found.append(one)
        report(len(found))
    return found


def sum_up(world: str, played: Sequence[Played]) -> dict[str, Any]:
    """Return the figures of a world: without a slip channel, and with one beside it."""
    of = {channel: _by_class(world, played, channel) for channel in (*CHANNELS, INFORMED)}
    return {
        **of[WITHOUT], **_under_grip(played, WITHOUT),
        "with_slip_channel": {**of[WITH], **_under_grip(played, WITH)},
        "after_a_slide": of[TAUGHT],
        "informed": of[INFORMED],
    }  # fmt: skip


def _by_class(world: str, played: Sequence[Played], channel: str) -> dict[str, Any]:
    classes: dict[str, list[list[Look]]] = {}
    for one in played:
        friction = friction_class(world, one.grasp)
        names = [friction, load_class(one.grasp)]
        if world == "published":
            names += [] if friction == EXTREME else ["all but extreme friction"]
        for name in names:
            classes.setdefault(name, []).append(one.looks[channel])
    return {
        **figures([one.looks[channel] for one in played]),
        "by_class": {name: figures(some) for name, some in sorted(classes.items())},
    }


def _under_grip(played: Sequence[Played], channel: str) -> dict[str, float]:
    held = [one.held[channel] for one in played if channel in one.held]
    over = [one.force_over_least for one in held if not (one.is_dropped or math.isnan(one.force_over_least))]
    if not held:
        return {"grasps_under_grip": 0}
    return {
        "grasps_under_grip": len(held),
        "slides_per_100": 100.0 * sum(one.slides for one in held) / len(held),
        "drops_per_100": 100.0 * sum(one.is_dropped for one in held) / len(held),
        "force_over_least": float(np.mean(over)) if over else math.nan,
    }
