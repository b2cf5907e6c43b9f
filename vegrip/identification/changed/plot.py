"""Two recordings and what changed between them, as a picture."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vegrip.identification.changed.result import Changed
from vegrip.identification.compare.comparison import residuals_of
from vegrip.identification.compare.plot import TIME_LABEL, drawn_time, measured_values
from vegrip.identification.compare.where import SPOKEN_UNITS, Residuals
from vegrip.plotting import new_figure
from vegrip.types import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AVERAGED = 25  # rows of a difference that are drawn as one: noise hides what a few percent make
LEAST_SEEN = 10.0  # [nats] of a change, from which its channel is drawn


def changed_figure(found: Changed) -> "Figure":
    """Draw both recordings, and by channel what the second shows beyond the first's law and why."""
    w = found.pair.w
    first, law = found.pair.sides(np.where(np.arange(w.size) < w.size // 2, w, 0.0))  # without differences
    left = {r.channel: r for r in residuals_of(*found.pair.sides(w)[1])}
    panels: list[tuple[Residuals, Any, Floats]] = []
    for r in residuals_of(*law):
        known = left.get(r.channel, r)
        _, of_law, of_left = np.intersect1d(r.rows, known.rows, return_indices=True)
        made, z = (one[of_law] - other[of_left] for one, other in ((r.raw, known.raw), (r.z, known.z)))
        if not panels or 0.5 * float(z @ z) > LEAST_SEEN:
            panels.append((r, r.rows[of_law], made))

    figure, axes = new_figure(2 + len(panels), size=(9, 3.0 + 2.4 * len(panels) + 2.4))
    for axis, (problem, u), kind in zip(axes, (first, law), ("first", "second"), strict=False):
        recording, r = problem.measured.recording, residuals_of(problem, u)[0]
        t, seen = drawn_time(recording)[r.rows], measured_values(problem, r)
        axis.plot(t, seen, "k.", ms=1.5, label=f"{kind}, measured")
        axis.plot(t, seen - r.raw, ".", ms=1.0, label="as the first's law has it")
        _label(axis, r.channel, f"{kind}: {recording.name}")
    time = drawn_time(found.pair.second.measured.recording)
    for axis, (r, rows, made) in zip(axes[2:], panels, strict=True):
        count = max(r.raw.size // AVERAGED, min(r.raw.size, AVERAGED))
        averaged = ([part.mean() for part in np.array_split(one, count)] for one in (time[r.rows], r.raw))
        axis.plot(time[rows], made, ".", ms=2.0, color="C1", label="what the change makes")
        axis.plot(*averaged, "k.", ms=3.0, label="second less the first's law, averaged")
        axis.set_xlim(axes[1].get_xlim())
        _label(axis, r.channel, f"difference of the {r.channel.replace('_', ' ')}")
    figure.suptitle(found.sentence, fontsize=10, wrap=True)
    return figure


def _label(axis: Any, channel: str, title: str) -> None:
    axis.legend(markerscale=4, fontsize=7)
    axis.set_title(title, fontsize=9, loc="left")
    axis.set_xlabel(TIME_LABEL)
    axis.set_ylabel(f"{channel.replace('_', ' ')} [{SPOKEN_UNITS[channel]}]")
