"""The picture of a demonstration: grip force against the least possible, where others fail, friction."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vegrip.demo.report import AS_FORCEFUL
from vegrip.demo.run import DESCRIPTION
from vegrip.plotting import save_figure
from vegrip.trials.candidates import LABEL
from vegrip.trials.closed_loop import SETTLED_S, Course, result_of
from vegrip.trials.fronts import force_over_least, least_grip_force
from vegrip.types import Floats
from vegrip.virtual import Disturbance

COLOUR = {"vegrip": "#0072b2", "constant": "#6e6e6e", "cone": "#d55e00"}
"""Distinguishable with every colour vision, and by their line styles in grey."""
STYLE = {"vegrip": "-", "constant": "--", "cone": "-."}
SLIP = {"vegrip": "1", "constant": "x", "cone": "+"}
LEAST = "#222222"
BAND = "#cfe3f3"
BAR = "#b7c9e2"
SHADE = "#eef2f8"
CHARACTER = 0.0088  # width of one of a label, as a share of the time axis
LOWEST_OVER_S = 0.2  # the margin is drawn as the lowest of so long: it swings faster than a line shows


def draw_comparison(
    courses: Mapping[str, Course], events: tuple[Disturbance, ...], path: Path, duration: float
) -> None:
    """Write the picture of ``courses`` (by name of the controller) to ``path``."""
    figure = Figure(figsize=(12.0, 9.0), layout="constrained")
    figure.suptitle(
        "One object, the same disturbances: grip force against the least that would have held", fontsize=14
    )
    strip, force, margin, friction = figure.subplots(4, 1, sharex=True, height_ratios=(0.42, 1.0, 0.75, 0.6))
    _schedule(strip, events, duration)
    for axes in (force, margin, friction):
        _shade(axes, events)
    _draw_forces(force, courses)
    _draw_margins(margin, courses)
    _draw_friction(friction, courses["vegrip"])
    for axes in (force, margin, friction):
        axes.set_axisbelow(True)
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(loc="upper left", bbox_to_anchor=(1.005, 1.03), frameon=False, fontsize=9)
    friction.set_xlabel("time [s]")
    friction.set_xlim(SETTLED_S, duration)
    friction.xaxis.set_major_locator(MaxNLocator(12, integer=True))
    save_figure(figure, path, dpi=140)


def _draw_forces(axes: Axes, courses: Mapping[str, Course]) -> None:
    for name in ("constant", "cone", "vegrip"):
        course = courses.get(name)
        if course is None or not len(course.since(SETTLED_S)[0]):
            continue
        time, _, forces = course.since(SETTLED_S)
        axes.plot(
            time, forces[:, 0], STYLE[name], color=COLOUR[name], label=_label(name, course), **_width(name)
        )
    time, least = _least(courses["vegrip"])
    axes.fill_between(
        time, 0.0, least, color=LEAST, linewidth=0.0, label="least possible\n(everything known)"
    )
    axes.set_title("tuned beforehand, on other objects, so that none slips", loc="left", fontsize=10)
    axes.set_ylabel("grip force [N]")
    axes.set_ylim(bottom=0.0)


def _draw_margins(axes: Axes, courses: Mapping[str, Course]) -> None:
    for name in ("constant", "cone", "vegrip"):
        course = courses.get(name if name == "vegrip" else name + AS_FORCEFUL)
        if course is None or not len(course.since(SETTLED_S)[0]):
            continue
        time, margins, _ = course.since(SETTLED_S)
        lowest = _lowest(margins.min(axis=1), _samples(course))
        axes.plot(time, lowest, STYLE[name], color=COLOUR[name], label=_label(name, course), **_width(name))
        _slips(axes, course, name)
    axes.axhline(0.0, color="black", linewidth=1.0)
    axes.set_title(
        "constant grip and cone with the mean force of vegrip; x and +: it slips, triangle: dropped",
        loc="left",
        fontsize=10,
    )
    axes.set_ylabel("true slip margin [-]\n0 = slips")
    axes.set_ylim(-0.08, 1.0)


def _draw_friction(axes: Axes, course: Course) -> None:
    time = np.array(course.time)
    if course.contact:
        axes.plot(
            time, [contact[0][2] for contact in course.contact], color=LEAST, linewidth=1.4, label="true"
        )
    if course.friction:
        at, mean, std = np.array(course.friction).T
        axes.plot(at, mean, color=COLOUR["vegrip"], linewidth=1.6, label="vegrip's estimate")
        axes.fill_between(at, mean - std, mean + std, color=BAND, linewidth=0.0, label="± 1 std", zorder=1)
    axes.set_title(
        "friction, which no controller knows beforehand, and what vegrip learns of it",
        loc="left",
        fontsize=10,
    )
    axes.set_ylabel("friction coefficient\n(thumb) [-]")
    axes.set_ylim(0.0, 1.25)


def _width(name: str) -> dict[str, Any]:
    return {"linewidth": 2.0, "zorder": 3.0} if name == "vegrip" else {"linewidth": 1.3, "zorder": 2.5}


def _least(course: Course) -> tuple[Floats, Floats]:
    time, least = np.array(course.time), least_grip_force(course)
    kept = time >= SETTLED_S
    return time[kept], np.nan_to_num(least[kept], posinf=0.0)


def _label(name: str, course: Course) -> str:
    figures, ratio = result_of(course), force_over_least(course, SETTLED_S)
    slips = f"{course.slips} slip" + ("" if course.slips == 1 else "s")
    end = ", dropped" if course.dropped else ""
    least = f", {ratio:.1f} times the least" if np.isfinite(ratio) else ""
    return f"{LABEL[name]}\n{figures.mean_grip_force:.1f} N{least}\n{slips}{end}"


def _samples(course: Course) -> int:
    step = course.time[1] - course.time[0] if len(course.time) > 1 else LOWEST_OVER_S
    return max(1, round(LOWEST_OVER_S / step))


def _lowest(values: Floats, count: int) -> Floats:
    padded = np.pad(values, (count // 2, count - 1 - count // 2), mode="edge")
    lowest: Floats = np.lib.stride_tricks.sliding_window_view(padded, count).min(axis=1)
    return lowest


def _slips(axes: Axes, course: Course, name: str) -> None:
    colour = COLOUR[name]
    counts = np.array(course.slipped)
    begins = np.flatnonzero(np.diff(counts, prepend=0) > 0)
    times = np.array(course.time)[begins]
    axes.plot(
        times, np.zeros(len(times)), SLIP[name], color=colour, markersize=12, markeredgewidth=2.2, zorder=4
    )
    if course.dropped:
        axes.plot(course.time[-1], 0.0, "v", color=colour, markersize=11, zorder=4)


def _schedule(axes: Axes, events: tuple[Disturbance, ...], duration: float) -> None:
    """One bar per disturbance with its name inside or beside it, each in the first lane that has room."""
    free: list[float] = []  # [s] from which on each lane is free
    for event in events:
        name = f" {DESCRIPTION[type(event).__name__].split(',')[0]} "
        text_at, left, right = _place(event, CHARACTER * (duration - SETTLED_S) * len(name), duration)
        lane = next((i for i, time in enumerate(free) if time <= left), len(free))
        free[lane : lane + 1] = [right]
        axes.barh(-lane, event.duration, left=event.start, height=0.8, color=BAR)
        side = "right" if left < event.start else "left"
        axes.text(text_at, -lane, name, fontsize=8, ha=side, va="center", color="#1d3461", clip_on=True)
    axes.set_ylim(0.5 - max(len(free), 1), 0.5)
    axes.set_axis_off()


def _place(event: Disturbance, width: float, duration: float) -> tuple[float, float, float]:
    """Return where the name of ``event``, ``width`` [s] wide, is anchored, and the room of both [s]."""
    end = event.start + event.duration
    if width <= event.duration:
        return event.start, event.start, end
    if end + width <= duration:
        return end, event.start, end + width
    return event.start, event.start - width, end


def _shade(axes: Axes, events: tuple[Disturbance, ...]) -> None:
    for event in events:
        axes.axvspan(event.start, event.start + event.duration, color=SHADE, linewidth=0, zorder=0.5)
