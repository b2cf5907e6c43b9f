"""The summary of a demonstration, for people and for machines."""

from collections.abc import Mapping

from rich.console import Group
from rich.table import Table
from rich.text import Text

from vegrip.demo.run import Outcome
from vegrip.trials.candidates import KNOBS, LABEL
from vegrip.trials.closed_loop import (
    CORES_OF_THE_HAND,
    SETTLED_S,
    Course,
    Result,
    Scenario,
    result_of,
    run_scenario,
)
from vegrip.trials.fronts import force_over_least

AS_FORCEFUL = ", same force"
"""Ends the name of a controller whose knob gives it the mean force of vegrip."""
SAME_FORCE = 0.01
"""Part of the force by which two mean forces may differ and still be called the same."""
AS_SURE = ", same slips"
"""Ends the name of a controller with the least knob at which it slips no more than vegrip."""
HALVINGS = 7  # in search of it
MOST_RUNS = 8  # in search of the knob


def label_of(name: str) -> str:
    base = name.removesuffix(AS_FORCEFUL).removesuffix(AS_SURE)
    return LABEL[base].removesuffix(" grip") + name[len(base) :] if base != name else LABEL[base]


def run_other_controllers(scenario: Scenario, ours: Course) -> dict[str, Course]:
    """Run constant grip and cone: as tuned, with the mean force of ``ours`` (thumb), and as sure."""
    tuned_knobs = {name: KNOBS[scenario.grasp][name] for name in ("constant", "cone")}
    knobs = dict(tuned_knobs)
    tuned = _run_all(knobs, scenario)
    same = dict(tuned)
    for _ in range(MOST_RUNS):
        ratios = {name: force_ratio(course, ours) for name, course in same.items()}
        off = {name: ratio for name, ratio in ratios.items() if abs(ratio - 1.0) > SAME_FORCE}
        if not off:
            break
        for name, ratio in off.items():  # a cone's force goes with 1 + safety
            least = 1.0 if name == "cone" else 0.0
            knobs[name] = max((least + knobs[name]) / ratio - least, 0.0)
        same |= _run_all({name: knobs[name] for name in off}, scenario)
    sure: dict[str, Course] = {}
    if not ours.dropped:
        for name in (name for name, course in same.items() if not is_as_sure(course, ours.slips)):
            if (knob := sure_knob(name, scenario, ours.slips, tuned_knobs[name])) is not None:
                sure[name + AS_SURE] = run_scenario(scenario, name, knob)
    return {**tuned, **{name + AS_FORCEFUL: course for name, course in same.items()}, **sure}


def is_as_sure(course: Course, slips: int) -> bool:
    return not course.dropped and course.slips <= slips


def sure_knob(name: str, scenario: Scenario, slips: int, enough: float) -> float | None:
    """Return the least knob with no more than ``slips``, by halving; None when ``enough`` slips more."""
    if not is_as_sure(run_scenario(scenario, name, enough), slips):
        return None
    too_low = 0.0
    for _ in range(HALVINGS):
        knob = 0.5 * (too_low + enough)
        if is_as_sure(run_scenario(scenario, name, knob), slips):
            enough = knob
        else:
            too_low = knob
    return enough


def force_ratio(theirs: Course, ours: Course) -> float:
    end = min(theirs.time[-1], ours.time[-1])
    return result_of(theirs, end).mean_grip_force / result_of(ours, end).mean_grip_force


def _run_all(knobs: dict[str, float], scenario: Scenario) -> dict[str, Course]:
    return {name: run_scenario(scenario, name, knob) for name, knob in knobs.items()}


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
    intro = f"{hold} an object of unknown friction{other}; it is pushed, twisted and made wet."
    look = (
        "Look at F, the grip force: it follows the load and keeps the margin's lower bound | above 0 (slip)."
    )
    return f"{intro}\n{look}" if shown else intro


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
