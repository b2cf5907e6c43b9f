"""What ``vegrip demo`` does: run, watch, sum up, compare, draw."""

import importlib.util
import json as json_format
import os
import sys
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.live import Live

from vegrip.demo.bench import BenchProduct
from vegrip.demo.product import Product
from vegrip.demo.report import as_json, describe_scenario, run_other_controllers, summary
from vegrip.demo.run import Demo, Outcome, Page, run
from vegrip.errors import DeviceError
from vegrip.jsonable import jsonable
from vegrip.runtime.monitor import render
from vegrip.trials import candidates
from vegrip.trials.closed_loop import Course, Scenario

PAGE_PORT = 8520  # of the live page; any other where it is in use


def run_demo(
    scenario: Scenario,
    folder: Path,
    *,
    live: bool,
    json: bool,
    plot: bool,
    web: bool = False,
    product: Product | BenchProduct | None = None,
) -> bool:
    """Run the demonstration and print what comes out; return whether it was interrupted.

    ``web``: besides as a page in the browser, whose address is printed and, where there is a display, opened.

    Raises:
        DeviceError: no state came, or the recording is not whole.

    """
    console = Console(stderr=json)  # with --json standard output holds the JSON object and nothing else
    live = live and console.is_terminal
    if not isinstance(product, BenchProduct):
        console.print(describe_scenario(scenario, shown=live or web), markup=False)
    if product is not None:
        console.print(product.describe(), markup=False, soft_wrap=True)
    if plot and not _can_draw():
        console.print(
            "there will be no picture: it needs matplotlib; pip install 'vegrip[plot]'", markup=False
        )
    with _page(scenario, console) if web else nullcontext() as page:
        outcome = _run_shown(scenario, folder, console, page, product, live=live)
    if not (outcome.node.states or outcome.interrupted):
        raise DeviceError(f"no state came, so nothing was gripped; what there is is in {folder}")
    courses = {"vegrip": outcome.course}
    if plot and not outcome.interrupted:
        console.print("the same scenario with a constant grip and a Coulomb cone, in simulated time ...")
        courses |= run_other_controllers(scenario, outcome.course)
        _draw(courses, scenario, folder, console)
    console.print(summary(outcome, courses))
    figures: dict[str, Any] = as_json(outcome)
    if isinstance(product, BenchProduct):
        console.print(product.summary(outcome.course), markup=False, soft_wrap=True)
        figures["bench"] = product.figures(outcome.course)
    console.print(f"next: {what_to_try(folder, web=web)}", markup=False, soft_wrap=True)
    if json:
        sys.stdout.write(json_format.dumps(jsonable(figures)) + "\n")
    if outcome.problem:
        raise DeviceError(outcome.problem)
    return outcome.interrupted


def what_to_try(folder: Path, *, web: bool) -> str:
    """Return what the demonstration leads to, as commands."""
    longer = "vegrip launch demo, and vegrip monitor --web beside it, for as long as you like"
    found = "vegrip sample press && vegrip check press finds what a model lacks"
    if not web and not _can_serve():
        return f"vegrip report {folder} (this run as one page); {found.replace('check', 'diagnose')}"
    return f"vegrip report {folder} (this run as one page); {longer}; {found}"


@contextmanager
def _page(scenario: Scenario, console: Console) -> Iterator[Page | None]:
    if not _can_serve():
        console.print("no page in the browser: it needs pip install 'vegrip[web]'", markup=False)
        yield None
        return
    from vegrip.web.live.stream import FedPage  # noqa: PLC0415 (an extra)

    parameters = candidates.demonstrated_parameters(scenario.grasp)
    with closing(FedPage(parameters.grip.wanted_margin, PAGE_PORT)) as page:
        console.print(f"live page: {page.address}", markup=False, soft_wrap=True)
        if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
            webbrowser.open(page.address)
        yield page


def _can_serve() -> bool:
    return all(importlib.util.find_spec(name) is not None for name in ("starlette", "uvicorn"))


def _run_shown(
    scenario: Scenario,
    folder: Path,
    console: Console,
    page: Page | None,
    product: Product | BenchProduct | None,
    *,
    live: bool,
) -> Outcome:
    screen: AbstractContextManager[Any] = (
        Live(console=console, auto_refresh=False, screen=False) if live else nullcontext()
    )

    def say(sentence: str) -> None:
        console.print(sentence)

    with screen as shown:
        refresh: Callable[[Demo], None] = (lambda demo: _show(shown, demo)) if live else (lambda _: None)
        return run(scenario, folder, refresh, say, page, product)


def _show(live: Live, demo: Demo) -> None:
    live.update(render(demo.board, time.monotonic_ns(), demo.title(), size=live.console.size), refresh=True)


def _draw(courses: dict[str, Course], scenario: Scenario, folder: Path, console: Console) -> None:
    if not _can_draw():
        return
    from vegrip.demo.plot import draw_comparison  # noqa: PLC0415 (matplotlib is an extra)

    path = folder / "comparison.png"
    draw_comparison(courses, scenario.events, path, scenario.duration)
    console.print(f"picture: {path}")


def _can_draw() -> bool:
    return importlib.util.find_spec("matplotlib") is not None
