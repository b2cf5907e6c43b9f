"""The summary of a demonstration, for people and for machines."""

from collections.abc import Mapping

from rich.console import Group
from rich.table import Table
from rich.text import Text

from vegrip.demo.least import force_over_least
from vegrip.demo.others import label_of
from vegrip.demo.run import Outcome
from vegrip.validation.controllers.closed_loop import Course
from vegrip.validation.controllers.result import Result, result_of
from vegrip.validation.controllers.scenario import CORES_OF_THE_HAND, SETTLED_S, Scenario

ALIKE = 0.05
"""Part of the force by which two mean forces may differ and still be called the same."""
OVERLOAD = 0.01
"""Share of commands from which on it is said that they were late, or held."""


def as_json(outcome: Outcome) -> dict[str, object]:
    """Return the figures of the run; slips, margin and force are the truth of the hand."""
    figures = result_of(outcome.course)
    node = outcome.node
    return {
        "samples": node.states,
        "slips": figures.slips,
        "deadline_misses": node.deadline_misses,
        "latency_us": {"p50": node.latency_p50, "p99": node.latency_p99, "max": node.latency_max},
        "bus_load": outcome.bus_load,
        "min_margin": figures.min_margin,
        "mean_grip_force": figures.mean_grip_force,
        "cores": outcome.cores,
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
        f"processor: {sum(outcome.cores.values()):.2f} cores"
        f" ({', '.join(f'{name} {share:.2f}' for name, share in outcome.cores.items())})",
        f"recording: {outcome.folder}",
    ]
    lines += compare_results({name: result_of(course) for name, course in courses.items()})
    lines += judge_machine(outcome.held, node.deadline_misses / max(node.states, 1))
    return Group(_table(courses), *(Text(line) for line in lines))


def describe_scenario(scenario: Scenario) -> str:
    """Return what is about to happen, and what to look at."""
    fingers = scenario.settings.fingers
    hold = "thumb and index pinch" if len(fingers) == 2 else f"{len(fingers)} fingers hold"
    other = "" if len(fingers) > 2 else f" (five: --grasp hand, {CORES_OF_THE_HAND} cores)"
    return (
        f"{hold} an object of unknown friction{other}; it is pushed, twisted and made wet.\n"
        "Look at F, the grip force: it follows the load and keeps the margin's lower bound | above 0 (slip)."
    )


def compare_results(results: Mapping[str, Result]) -> list[str]:
    """Return a sentence for each other controller: what it took against vegrip, whichever is better."""
    ours = results["vegrip"]
    return [
        _compare_result(label_of(name), theirs, ours)
        for name, theirs in results.items()
        if theirs is not ours
    ]


def _compare_result(name: str, theirs: Result, ours: Result) -> str:
    if theirs.dropped or ours.dropped:
        who = [label for label, one in ((name, theirs), ("vegrip", ours)) if one.dropped]
        return f"{name} against vegrip: {' and '.join(who)} dropped the object"
    ratio = theirs.mean_grip_force / ours.mean_grip_force
    more, less = f"{ratio:.1f} times the force of", f"{100.0 * (1.0 - ratio):.0f} % less force than"
    force = "as much force as" if abs(ratio - 1.0) < ALIKE else more if ratio >= 1.0 else less
    margins = f"least margin {theirs.min_margin:.2f} against {ours.min_margin:.2f}"
    return f"{name}: {force} vegrip, {theirs.slips} slips against {ours.slips}, {margins}"


def judge_machine(held: float, late: float) -> list[str]:
    """Return what a busy machine did to the figures of vegrip, if anything.

    Args:
        held: share of the commands that only held, or ramped to the fail-safe grip, for want of fresh input.
        late: deadlines missed per state.

    """
    if held > OVERLOAD:
        return [
            f"this machine was too busy: {100.0 * held:.0f} % of the commands held or went to the fail-safe"
            " grip, because no fresh state had come; on time vegrip takes less force than it did here"
        ]
    if late > OVERLOAD:
        return [
            f"this machine was busy: {100.0 * late:.0f} % of the commands were late, but hardly any held for"
            " want of a fresh state; the figures stand"
        ]
    return []


def _table(courses: dict[str, Course]) -> Table:
    table = Table(title="the same hand, object and disturbances")
    for header in (
        "controller",
        "slips",
        "object",
        "mean grip force",
        "over least",
        "least margin",
    ):
        table.add_column(header, justify="left" if header in ("controller", "object") else "right")
    for name, course in courses.items():
        figures = result_of(course)
        table.add_row(
            label_of(name),
            str(figures.slips),
            Text("dropped", "red") if figures.dropped else "held",
            f"{figures.mean_grip_force:.2f} N",
            f"{force_over_least(course, SETTLED_S):.2f}",
            f"{figures.min_margin:.2f}",
        )
    return table
