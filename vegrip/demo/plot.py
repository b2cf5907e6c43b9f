"""The picture of a demonstration: grip force and margin against time, for all controllers on one axis."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vegrip.demo.run import DESCRIPTION
from vegrip.plotting import save_figure
from vegrip.validation.controllers.candidates import LABEL
from vegrip.validation.controllers.closed_loop import Course
from vegrip.validation.controllers.result import result_of
from vegrip.validation.controllers.scenario import SETTLED_S
from vegrip.virtual import Disturbance

COLOUR = {"vegrip": "#0b6e4f", "constant": "#8a8a8a", "cone": "#d1603d"}
BLUE = "#4a7bd0"
CHARACTER = 0.0088  # width of one of a label, as a share of the time axis


def draw_comparison(
    courses: Mapping[str, Course], events: tuple[Disturbance, ...], path: Path, duration: float
) -> None:
    """Write the picture of ``courses`` (by name of the controller) to ``path``."""
    figure = Figure(figsize=(10.0, 7.6), layout="constrained")
    figure.suptitle(
        "One object, the same disturbances: how hard each controller grips, and how near it comes to slipping"
    )
    strip, force, margin = figure.subplots(3, 1, sharex=True, height_ratios=(0.4, 1.0, 1.0))
    _schedule(strip, events, duration)
    for axes in (force, margin):
        _shade(axes, events)
    for name, course in courses.items():
        time, margins, forces = course.since(SETTLED_S)
        if not len(time):
            continue
        style = {"color": COLOUR[name], "linewidth": 1.6 if name == "vegrip" else 1.1}
        force.plot(time, forces[:, 0], label=_legend(name, course), **style)
        margin.plot(time, margins.min(axis=1), **style)
        _slips(margin, course, COLOUR[name])
    force.set_ylabel("grip force (thumb) [N]")
    force.set_ylim(bottom=0.0)
    figure.legend(loc="outside lower center", ncols=len(courses), frameon=False)
    margin.axhline(0.0, color="black", linewidth=0.8)
    margin.set_ylabel("smallest true slip margin [-]\n0 = slips")
    margin.set_ylim(-0.05, 1.0)
    margin.set_xlabel("time [s]")
    margin.set_xlim(SETTLED_S, duration)
    for axes in (force, margin):
        axes.grid(alpha=0.25)
    save_figure(figure, path, dpi=140)


def _legend(name: str, course: Course) -> str:
    end = ", object dropped" if course.dropped else ""
    plural = "" if course.slips == 1 else "s"
    return f"{LABEL[name]}: {result_of(course).mean_grip_force:.1f} N mean, {course.slips} slip{plural}{end}"


def _slips(axes: Axes, course: Course, colour: str) -> None:
    counts = np.array(course.slipped)
    begins = np.flatnonzero(np.diff(counts, prepend=0) > 0)
    times = np.array(course.time)[begins]
    axes.plot(times, np.zeros(len(times)), "x", color=colour, markersize=8, markeredgewidth=2)
    if course.dropped:
        axes.plot(course.time[-1], 0.0, "v", color=colour, markersize=9)


def _schedule(axes: Axes, events: tuple[Disturbance, ...], duration: float) -> None:
    """One bar per disturbance with its name inside or beside it, each in the first lane that has room."""
    free: list[float] = []  # [s] from which on each lane is free
    for event in events:
        name = f" {DESCRIPTION[type(event).__name__].split(',')[0]} "
        text_at, left, right = _place(event, CHARACTER * (duration - SETTLED_S) * len(name), duration)
        lane = next((i for i, time in enumerate(free) if time <= left), len(free))
        free[lane : lane + 1] = [right]
        axes.barh(-lane, event.duration, left=event.start, height=0.8, color=BLUE, alpha=0.25)
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
        axes.axvspan(event.start, event.start + event.duration, color=BLUE, alpha=0.08, linewidth=0)
