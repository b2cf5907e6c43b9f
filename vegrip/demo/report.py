"""The summary of a demonstration, for people and for machines."""

from collections.abc import Mapping

from rich.console import Group
from rich.table import Table
from rich.text import Text

from vegrip.demo.others import AS_FORCEFUL, AS_SURE, SAME_FORCE, label_of
from vegrip.demo.run import Outcome
from vegrip.trials.closed_loop import Course, Result, result_of
from vegrip.trials.grip_quality import force_over_least
from vegrip.trials.scenario import CORES_OF_THE_HAND, SETTLED_S, Scenario

TOO_SHORT = (
    "nothing slipped with the same force either: this run is too short to show what force is for;"
    " a longer one (--duration) shows more"
)
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
    lines += compare_courses(courses)
    lines += judge_machine(outcome.held, node.deadline_misses / max(node.states, 1))
    return Group(_table(courses), *(Text(line) for line in lines))


def describe_scenario(scenario: Scenario, *, shown: bool) -> str:
    """Return what is about to happen, and what to look at where it is ``shown``."""
    fingers = scenario.settings.fingers
    hold = "thumb and index pinch" if len(fingers) == 2 else f"{len(fingers)} fingers hold"
    other = "" if len(fingers) > 2 else f" (five: --grasp hand, {CORES_OF_THE_HAND} cores)"
    told = f"{hold} an object of unknown friction{other}; it is pushed, twisted and made wet."
    look = (
        "Look at F, the grip force: it follows the load and keeps the margin's lower bound | above 0 (slip)."
    )
    return f"{told}\n{look}" if shown else told


def compare_courses(courses: Mapping[str, Course]) -> list[str]:
    """Return what the other controllers took to hold, and how often they slipped with the same force."""
    ours = courses["vegrip"]
    others = {name: course for name, course in courses.items() if course is not ours}
    alike = {name: course for name, course in others.items() if name.endswith(AS_FORCEFUL)}
    lines = [
        _compare_force(label_of(name), result_of(course), result_of(ours))
        for name, course in others.items()
        if name not in alike and not name.endswith(AS_SURE)
    ]
    if alike and not any(one.slips or one.dropped for one in (ours, *alike.values())):
        return [*lines, TOO_SHORT]
    for name, course in alike.items():
        lines.append(_compare_slips(label_of(name), course, ours))
        if (sure := others.get(name.removesuffix(AS_FORCEFUL) + AS_SURE)) is not None:
            force, our_force = (result_of(one).mean_grip_force for one in (sure, ours))
            lines.append(
                f"{label_of(name.removesuffix(AS_FORCEFUL) + AS_SURE)}: {force:.2f} N against"
                f" {our_force:.2f} N, with the constant that this run itself asks for"
            )
    return lines


def _compare_force(name: str, theirs: Result, ours: Result) -> str:
    if theirs.dropped or ours.dropped:
        who = [label for label, one in ((name, theirs), ("vegrip", ours)) if one.dropped]
        return f"{name} against vegrip: {' and '.join(who)} dropped the object"
    ratio = theirs.mean_grip_force / ours.mean_grip_force
    more, less = f"{ratio:.1f} times the force of", f"{100.0 * (1.0 - ratio):.0f} % less force than"
    slips = f"as many slips ({ours.slips})"
    if theirs.slips != ours.slips:
        slips = f"{theirs.slips} slips against {ours.slips}"
    return f"{name}: {more if ratio >= 1.0 else less} vegrip, {slips}"


def _compare_slips(name: str, theirs: Course, ours: Course) -> str:
    end = min(theirs.time[-1], ours.time[-1])
    force, our_force = (result_of(course, end).mean_grip_force for course in (theirs, ours))
    forces = (
        f" ({force:.2f} N against {our_force:.2f} N)" if abs(force / our_force - 1.0) > SAME_FORCE else ""
    )
    return f"{name}{forces}: {_fate(theirs)}; vegrip: {_fate(ours)}"


def _fate(course: Course) -> str:
    dropped = f" and the object dropped after {course.time[-1]:.1f} s" if course.dropped else ""
    return f"{course.slips} slip{'' if course.slips == 1 else 's'}{dropped}"


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


def until_drops(courses: Mapping[str, Course]) -> str | None:
    """Return why the mean force of a controller that dropped the object is not that of the whole run."""
    ours = courses["vegrip"]
    ends = sorted({round(one.time[-1], 1) for one in courses.values() if one.dropped and one is not ours})
    if not ends or ours.dropped:
        return None
    forces = ", ".join(f"{result_of(ours, end).mean_grip_force:.2f} N until {end:.1f} s" for end in ends)
    return f"means end where the object is dropped; vegrip: {forces}"


def _table(courses: dict[str, Course]) -> Table:
    table = Table(title="the same hand, object and disturbances", caption=until_drops(courses))
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
            Text(f"dropped, {course.time[-1]:.1f} s", "red") if figures.dropped else "held",
            f"{figures.mean_grip_force:.2f} N",
            f"{force_over_least(course, SETTLED_S):.2f}",
            f"{figures.min_margin:.2f}",
        )
    return table
