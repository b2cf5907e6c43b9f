"""The motion of a trial as a drawing: depth over time, with what slides and turns marked. Pure."""

from collections.abc import Mapping, Sequence
from typing import Any

from vegrip.web.axes import Axes, extent

SIZE = (640, 210)  # [px]


def draw_motion(motion: Mapping[str, Sequence[Any]]) -> str:
    """Draw the motion of a trial.

    Args:
        motion: ``t`` [s], ``depth`` [m], and ``moves``: begin and end [s] and name of each pull and twist.

    """
    t = list(motion["t"])
    depth = [1e3 * value for value in motion["depth"]]
    axes = Axes(extent(t, room=0.0), extent(depth), "time without the pauses [s]", "depth [mm]", SIZE)
    for begin, end, name in motion["moves"]:
        colour = "orange" if name == "pull" else "violet"
        axes.line((begin, end), (max(depth), max(depth)), colour, **{"stroke-width": 6, "opacity": 0.7})
    axes.line(t, depth, "blue")
    said = {"pull": "orange: pull along the surface", "twist": "violet: twist"}
    names = dict.fromkeys(name for _, _, name in motion["moves"])
    legend = "; ".join(said[name] for name in names)
    return axes.svg("motion of the trial") + (f'<p class="soft">{legend}</p>' if legend else "")
