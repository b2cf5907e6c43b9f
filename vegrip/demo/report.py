"""The summary of a demonstration, for people and for machines."""

from rich.console import Group
from rich.table import Table
from rich.text import Text

from vegrip.demo.candidates import LABEL
from vegrip.demo.closed_loop import Course
from vegrip.demo.result import result
from vegrip.demo.run import Outcome

OVERLOAD = 0.01
"""Share of deadline misses above which the figures say more of the machine than of the controller."""


def as_json(outcome: Outcome) -> dict[str, object]:
    """Return the figures of the run; slips, margin and force are the truth of the hand."""
    figures = result(outcome.course)
    node = outcome.node
    return {
        "samples": node.states,
        "slips": figures.slips,
        "deadline_misses": node.deadline_misses,
        "latency_us": {"p50": node.latency_p50, "p99": node.latency_p99, "max": node.latency_max},
        "bus_load": outcome.bus_load,
        "min_margin": figures.min_margin,
        "mean_grip_force": figures.mean_grip_force,
        "recording": str(outcome.folder),
    }


def summary(outcome: Outcome, courses: dict[str, Course]) -> Group:
    """Return what is printed at the end."""
    node = outcome.node
    lines = [
        f"{node.states} states in, {node.commands} commands out;"
        f" latency {node.latency_p50:.0f} us (p50), {node.latency_p99:.0f} us (p99),"
        f" {node.latency_max:.0f} us (worst); {node.deadline_misses} deadline misses;"
        f" bus load {100.0 * outcome.bus_load:.0f} %",
        f"recording: {outcome.folder}",
    ]
    if node.deadline_misses > OVERLOAD * node.states:
        lines.append(
            "this machine was too busy for the loop: much of the input came too late, so the node held its"
            " commands and went to the fail-safe grip; the figures of vegrip say little of its control"
        )
    return Group(_table(courses), *(Text(line) for line in lines))


def _table(courses: dict[str, Course]) -> Table:
    table = Table(title="the same hand, object and disturbances")
    for header in ("controller", "slips", "object", "mean grip force", "peak", "least margin"):
        table.add_column(header, justify="left" if header in ("controller", "object") else "right")
    for name, course in courses.items():
        figures = result(course)
        table.add_row(
            LABEL[name],
            str(figures.slips),
            Text("dropped", "red") if figures.dropped else "held",
            f"{figures.mean_grip_force:.2f} N",
            f"{figures.peak_grip_force:.1f} N",
            f"{figures.min_margin:.2f}",
        )
    return table
