"""Two recordings and what changed between them, as a picture."""

from pathlib import Path
from typing import Any

import numpy as np

from vegrip.identification.changed.changes import Changed
from vegrip.identification.compare.comparison import residuals_of
from vegrip.identification.compare.plot import TIME_LABEL, drawn_time, measured_values
from vegrip.identification.compare.where import SPOKEN_UNITS
from vegrip.plotting import new_figure, save_figure
from vegrip.types import Floats

AVERAGED = 25  # rows of a difference that are drawn as one: noise hides what a few percent make
LEAST_SEEN = 10.0  # [nats] of a change, from which its channel is drawn


def draw_changed(found: Changed, path: Path) -> None:
    """Draw both recordings, and by channel what the second shows beyond the first's law and why."""
    pair, problems = found.pair, (found.pair.first, found.pair.second)
    unchanged = np.where(np.arange(pair.w.size) < pair.kept, pair.w, 0.0)
    law = residuals_of(pair.second, pair.side(1, unchanged)[0])
    left = {r.channel: r for r in residuals_of(pair.second, pair.side(1, pair.w)[0])}
    made = {
        r.channel: (r.raw - left[r.channel].raw, r.z - left[r.channel].z) for r in law if r.channel in left
    }
    shown = [law[0], *(r for r in law[1:] if r.channel in made and nats(made[r.channel][1]) > LEAST_SEEN)]
    figure, axes = new_figure(2 + len(shown), size=(9, 3.0 + 2.4 * len(shown) + 2.4))
    both = (residuals_of(pair.first, pair.side(0, pair.w)[0])[0], law[0])
    for axis, problem, r, kind in zip(axes, problems, both, ("first", "second"), strict=False):
        t, seen = drawn_time(problem.measured.recording)[r.rows], measured_values(problem, r)
        axis.plot(t, seen, "k.", ms=1.5, label=f"{kind}, measured")
        axis.plot(t, seen - r.raw, ".", ms=1.0, label="as the first's law has it")
        _labelled(axis, r.channel, f"{kind}: {problem.measured.recording.name}")
    for axis, r in zip(axes[2:], shown, strict=True):
        t = drawn_time(pair.second.measured.recording)[r.rows]
        count = max(r.raw.size // AVERAGED, min(r.raw.size, AVERAGED))
        t_mean, mean = ([part.mean() for part in np.array_split(values, count)] for values in (t, r.raw))
        axis.plot(t, made[r.channel][0], ".", ms=2.0, color="C1", label="what the change makes")
        axis.plot(t_mean, mean, "k.", ms=3.0, label="second less the first's law, averaged")
        axis.set_xlim(axes[1].get_xlim())
        _labelled(axis, r.channel, f"difference of the {r.channel.replace('_', ' ')}")
    figure.suptitle(found.sentence, fontsize=10, wrap=True)
    save_figure(figure, path)


def nats(z: Floats) -> float:
    return 0.5 * float(z @ z)


def _labelled(axis: Any, channel: str, title: str) -> None:
    axis.legend(markerscale=4, fontsize=7)
    axis.set_title(title, fontsize=9, loc="left")
    axis.set_xlabel(TIME_LABEL)
    axis.set_ylabel(f"{channel.replace('_', ' ')} [{SPOKEN_UNITS[channel]}]")
