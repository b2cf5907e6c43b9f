"""``python -m validation.slip_bound``: whether the bound holds where the force is set from outside."""

import json
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from rich.table import Table

from validation.slip_bound.forced import STATED
from validation.slip_bound.picture import draw
from validation.slip_bound.run import INFORMED, TAUGHT, WITH, WITHOUT, play_world, sum_up
from validation.slip_bound.shares import missed_goal
from validation.slip_bound.worlds import WORLDS
from vegrip.cli import run
from vegrip.cli._terminal import printer, progress
from vegrip.errors import UsageError, suggestion

GRASPS, HELD = 700, 100
REPORT_EVERY: Final = 50


def slip_bound(
    *,
    world: Annotated[
        list[str] | None, typer.Option(help="published or belief; may be repeated. Both when not given.")
    ] = None,
    grasps: Annotated[int, typer.Option(min=1, help="With a force from outside, in each world.")] = GRASPS,
    held: Annotated[
        int, typer.Option(min=0, help="How many of them are held by the grip as well, by its own force.")
    ] = HELD,
    first: Annotated[
        int, typer.Option(min=0, help="Number of the first grasp: of the draw and the noise.")
    ] = 1,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 1,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Picture: the reliability diagram.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures for machines.")] = False,
) -> int:
    """Set the force of grasps from outside, and count how often the true margin lies below its bound.

    Example: python -m validation.slip_bound -o reliability.png

    Force and load are drawn whatever the bound says; friction comes from published figures or from what the
    grip believes at first. Exit 1 where more lie below the 95 % bound than their number allows.
    """
    for name in world or ():
        if name not in WORLDS:
            raise UsageError(f"there is no world {name!r}; {suggestion(name, WORLDS)}")
    told = {}
    for name in world or WORLDS:
        with progress("slip_bound") as report:
            count = partial(_report, report, f"of {grasps} grasps, {name} world")
            told[name] = sum_up(name, play_world(name, grasps, held, first=first, jobs=jobs, report=count))
    if output is not None:
        draw(told, output)
    if as_json:
        sys.stdout.write(json.dumps({"worlds": told}) + "\n")
    else:
        _print(told)
    wrong = missed(told)
    for sentence in wrong:
        sys.stderr.write(f"{sentence}\n")
    return min(len(wrong), 1)


def _report(report: Callable[[str], None], of: str, done: int) -> None:
    if done % REPORT_EVERY == 0:
        report(f"{done} {of}")


def missed(worlds: dict[str, dict[str, Any]]) -> list[str]:
    """Return in a sentence each where the bound holds less often than it says."""
    return [
        f"{name} world, {channel}: {sentence}"
        for name, told in worlds.items()
        for channel, part in parts(told).items()
        if (sentence := missed_goal(part))
    ]


def parts(told: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the figures of a world by channel."""
    return {WITHOUT: told, WITH: told["with_slip_channel"], TAUGHT: told["after_a_slide"]}


def _print(worlds: dict[str, dict[str, Any]]) -> None:
    console = printer()
    for name, told in worlds.items():
        for channel, part in {**parts(told), INFORMED: told["informed"]}.items():
            console.print(f"{name} world, {channel}: grasps [%] whose true margin lies below the bound")
            console.print(_table(part))
            if part.get("grasps_under_grip"):
                console.print(
                    f"under the grip, {part['grasps_under_grip']} grasps: {part['slides_per_100']:.0f} slides"
                    f" and {part['drops_per_100']:.0f} drops in a hundred,"
                    f" {part['force_over_least']:.2f} times the least force\n"
                )


def _table(part: dict[str, Any]) -> Table:
    table = Table(box=None, padding=(0, 1))
    table.add_column("stated confidence")
    stated = part["margin_below_bound"]
    columns = (
        "grasps", *(f"{float(name):.0%}" for name in stated), f"{STATED:.0%}, last look", "mean slack",
        "no bound",
    )  # fmt: skip
    for column in columns:
        table.add_column(column, justify="right")
    for name, some in {"all": part, **part["by_class"]}.items():
        table.add_row(
            name, str(some["grasps"]), *(f"{100.0 * one:.1f}" for one in some["margin_below_bound"].values()),
            f"{100.0 * some['margin_below_bound_at_the_last_look'][str(STATED)]:.1f}",
            f"{some['mean_slack']:.2f}", f"{100.0 * some['looks_without_bound']:.1f} %",
        )  # fmt: skip
    return table


if __name__ == "__main__":
    sys.exit(run(slip_bound, sys.argv[1:], "python -m validation.slip_bound"))
