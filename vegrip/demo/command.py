"""What ``vegrip demo`` does: run, watch, sum up, compare, draw."""

import importlib.util
import json as json_format
import math
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.live import Live

from vegrip.demo.report import as_json, summary, what_to_see
from vegrip.demo.run import Demo, Outcome, run
from vegrip.errors import DeviceError
from vegrip.runtime.monitor import render
from vegrip.validation.controllers.candidates import KNOBS
from vegrip.validation.controllers.closed_loop import Course
from vegrip.validation.controllers.comparison import Trial, course
from vegrip.validation.controllers.scenario import Scenario

OTHERS = ("constant", "cone")


def perform(scenario: Scenario, folder: Path, *, live: bool, json: bool, plot: bool) -> bool:
    """Run the demonstration and print what comes out; tell whether it was interrupted."""
    console = Console(stderr=json)  # with --json standard output holds the JSON object and nothing else
    live = live and console.is_terminal
    console.print(what_to_see(scenario), markup=False)
    if plot and not _can_draw():
        console.print(
            "there will be no picture: it needs matplotlib; pip install 'vegrip[plot]'", markup=False
        )
    outcome = _watched(scenario, folder, console, live=live)
    courses = {"vegrip": outcome.course}
    if plot and not outcome.interrupted:
        console.print("the same scenario with a constant grip and a Coulomb cone, in simulated time ...")
        courses |= others(scenario)
        _draw(courses, scenario, folder, console)
    console.print(summary(outcome, courses))
    if json:
        sys.stdout.write(json_format.dumps(_plain(as_json(outcome))) + "\n")
    if outcome.problem:
        raise DeviceError(outcome.problem)
    return outcome.interrupted


def _watched(scenario: Scenario, folder: Path, console: Console, *, live: bool) -> Outcome:
    screen: AbstractContextManager[Any] = (
        Live(console=console, auto_refresh=False, screen=False) if live else nullcontext()
    )

    def say(sentence: str) -> None:
        console.print(sentence)

    with screen as shown:
        refresh: Callable[[Demo], None] = (lambda demo: _show(shown, demo)) if live else (lambda _: None)
        return run(scenario, folder, refresh, say)


def _show(live: Live, demo: Demo) -> None:
    live.update(render(demo.board, time.monotonic_ns(), demo.title(), size=live.console.size), refresh=True)


def others(scenario: Scenario) -> dict[str, Course]:
    """Run the other controllers through the same scenario, in simulated time."""
    knobs = KNOBS[scenario.grasp]
    trials = [Trial(n, scenario.seed, scenario.duration, knobs[n], scenario.grasp) for n in OTHERS]
    with ProcessPoolExecutor(len(trials)) as pool:
        return dict(zip(OTHERS, pool.map(course, trials), strict=True))


def _draw(courses: dict[str, Course], scenario: Scenario, folder: Path, console: Console) -> None:
    if not _can_draw():
        return
    from vegrip.demo.plot import picture  # noqa: PLC0415 (matplotlib is an extra)

    path = folder / "comparison.png"
    picture(courses, scenario.events, path, scenario.duration)
    console.print(f"picture: {path}")


def _can_draw() -> bool:
    return importlib.util.find_spec("matplotlib") is not None


def _plain(value: Any) -> Any:
    """Return ``value`` with what is not a number as null: JSON has no NaN."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
