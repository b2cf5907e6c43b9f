"""``python -m validation.measured_slip``: measured grasps with outcomes against bound and force."""

import json
import math
import sys
from typing import Annotated, Any

import typer
from rich.table import Table

from validation.measured_slip.levels import OUTCOMES, Level, lowest_held, read_levels, tangential_gains
from validation.measured_slip.replay import Replayed, controller, replay
from vegrip.cli import run
from vegrip.cli._terminal import printer

LEAST_RATIO, MOST_RATIO = 1.0, 1.6
"""Commanded force over the lowest level that held: below, an object is lost; above, it is crushed."""


def measure() -> dict[str, Any]:
    """Replay every level, and lift each mass by what is commanded."""
    hand = controller()
    told = [(level, replay(hand, level)) for level in read_levels()]
    gains = tangential_gains()
    lowest = lowest_held()
    followed = {mass: replay(hand, level, follows=True) for mass, level in lowest.items()}
    as_read = {mass: replay(hand, level, follows=True, gain=gains[mass]) for mass, level in lowest.items()}
    return {
        "failed_with_bound_above_zero": above_zero(told, "failed"),
        "force_over_lowest_held": _ratios(followed),
        "force_over_lowest_held_as_read": _ratios(as_read),
        "tangential_gain": gains,
        "lifts": {outcome: sum(getattr(level, outcome) for level in read_levels()) for outcome in OUTCOMES},
        "with_bound_above_zero": {outcome: above_zero(told, outcome) for outcome in OUTCOMES},
        "levels": [
            {
                "mass": level.mass, "normal_force": level.normal_force,
                **{outcome: getattr(level, outcome) for outcome in OUTCOMES},
                "margin": one.margin, "bound": one.bound,
            }
            for level, one in told
        ],
    }  # fmt: skip


def above_zero(told: list[tuple[Level, Replayed]], outcome: str) -> int:
    """Return how many lifts with an outcome have a bound of the margin above zero."""
    return sum(getattr(level, outcome) for level, one in told if one.bound > 0.0)


def _ratios(found: dict[str, Replayed]) -> dict[str, float]:
    lowest = lowest_held()
    return {mass: one.commanded / lowest[mass].normal_force for mass, one in found.items()}


def missed(figures: dict[str, Any]) -> list[str]:
    """Return in a sentence each which goals are not reached."""
    said = []
    if unknown := [one for one in figures["levels"] if math.isnan(one["bound"])]:
        said.append(f"{len(unknown)} levels have no bound at all")
    if failed := figures["failed_with_bound_above_zero"]:
        said.append(
            f"{failed} of {figures['lifts']['failed']} grasps that failed have a bound above zero; none may"
        )
    for name, how in (
        ("force_over_lowest_held", ""),
        ("force_over_lowest_held_as_read", " where tangential forces are read too low"),
    ):
        said += [
            f"{ratio:.2f} times the lowest force that held is commanded at {mass} kg{how},"
            f" which is not between {LEAST_RATIO:.1f} and {MOST_RATIO:.1f}"
            for mass, ratio in figures[name].items()
            if not LEAST_RATIO <= ratio <= MOST_RATIO
        ]
    return said


def measured_slip(
    *, as_json: Annotated[bool, typer.Option("--json", help="Print the figures for machines.")] = False
) -> int:
    """Replay measured lifts with known outcomes; exit 1 where bound or force do not fit them.

    Example: python -m validation.measured_slip --json
    """
    figures = measure()
    if as_json:
        sys.stdout.write(json.dumps(figures) + "\n")
    else:
        _print(figures)
    wrong = missed(figures)
    for sentence in wrong:
        sys.stderr.write(f"{sentence}\n")
    return min(len(wrong), 1)


def _print(figures: dict[str, Any]) -> None:
    console = printer()
    levels = _table("mass [kg]", "N of a finger [N]", "T / N", *OUTCOMES, "margin", "95 % bound")
    for level, one in zip(read_levels(), figures["levels"], strict=True):
        levels.add_row(
            f"{level.mass:.3f}", f"{level.normal_force:.2f}",
            f"{level.tangential_force / level.normal_force:.2f}",
            *(str(getattr(level, outcome) or "") for outcome in OUTCOMES),
            f"{one['margin']:.2f}", f"{one['bound']:.2f}",
        )  # fmt: skip
    console.print(levels)
    lifts, above = figures["lifts"], figures["with_bound_above_zero"]
    counts = (f"{above[outcome]} of {lifts[outcome]} that {_SAID[outcome]}" for outcome in OUTCOMES)
    console.print(f"bound above zero: {', '.join(counts)}")
    forces = _table("mass [kg]", "lowest that held [N]", "commanded over it", "tangential gain", "with that")
    for mass, level in lowest_held().items():
        forces.add_row(
            mass, f"{level.normal_force:.2f}", f"{figures['force_over_lowest_held'][mass]:.2f}",
            f"{figures['tangential_gain'][mass]:.2f}",
            f"{figures['force_over_lowest_held_as_read'][mass]:.2f}",
        )  # fmt: skip
    console.print(forces)


_SAID = {"failed": "failed", "slid": "slid slowly", "held": "were held"}


def _table(*columns: str) -> Table:
    table = Table(box=None, padding=(0, 2))
    for column in columns:
        table.add_column(column, justify="right")
    return table


if __name__ == "__main__":
    sys.exit(run(measured_slip, sys.argv[1:], "python -m validation.measured_slip"))
