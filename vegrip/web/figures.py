"""What is drawn of a comparison and of a ladder of models; the check page and the reports share it. Pure."""

from collections.abc import Mapping, Sequence
from typing import Any

from vegrip.identification.compare.plot import CHANNEL_NAMES, SIGMA, scaled
from vegrip.identification.compare.where import format_quantity
from vegrip.plotting import runs
from vegrip.web.axes import Axes, extent
from vegrip.web.markup import Markup, table

WIDE, LOW = (1300, 260), (1300, 170)  # [px]
MAX_POINT_COLUMNS = 80  # columns, with less of which each is drawn as a point
DOT = 1.5  # [px]
Answer = Mapping[str, Any]


def over_time(channel: str, answer: Answer, beside: Answer | None = None) -> str:
    """Draw measurement and model over time; ``beside``: the same channel of another model."""
    columns, (scale, unit) = answer["columns"], scaled(answer["unit"])
    if not columns:
        return ""
    low, high = ([scale * v for v in columns[f"measured_{end}"]] for end in ("low", "high"))
    model = _model(columns, scale)
    axes = Axes(
        extent(columns["time"], room=0.0),
        extent([*low, *high, *model]),
        "time without the pauses between trials [s]",
        f"{channel.replace('_', ' ')} [{unit}]",
        WIDE,
    )
    noise = SIGMA * scale * (answer["noise"] or 0.0)
    time = columns["time"]
    for run in runs(time):
        axes.band(time[run], [v - noise for v in low[run]], [v + noise for v in high[run]], "measured")
    if beside is not None and beside["columns"]:
        other, its = beside["columns"]["time"], _model(beside["columns"], scale)
        for run in runs(other):
            axes.line(other[run], its[run], "orange", **{"stroke-dasharray": "5 4"})
    for run in runs(time):
        axes.line(time[run], model[run], "blue")
    return axes.svg(f"{channel}: measured and modelled over time")


def residual_over_time(channel: str, answer: Answer) -> str:
    """Draw least and greatest residual of each column of time, in units of the noise."""
    columns = answer["columns"]
    if not columns:
        return ""
    far = max(4.0, *(abs(v) for v in (*columns["z_low"], *columns["z_high"])))
    time = columns["time"]
    axes = Axes(
        extent(time, room=0.0), (-far, far), "time without the pauses [s]", "residual [noise std]", LOW
    )
    axes.band([time[0], time[-1]], [-SIGMA] * 2, [SIGMA] * 2, "band")
    if len(time) < MAX_POINT_COLUMNS:
        axes.points(time, columns["z_high"], "ink-soft")
    for run in runs(time):
        axes.band(time[run], columns["z_low"][run], columns["z_high"][run], "ink-soft")
    return axes.svg(f"{channel}: residual over time")


def over_variable(channel: str, name: str, answer: Answer) -> str:
    """Draw rms and mean of the residual in bins of a variable, and mark the worst bin."""
    bins, (scale, unit) = answer["bins"], scaled(answer["unit"])
    middles = [scale * (one["low"] + one["high"]) / 2.0 for one in bins]
    rms, mean = [one["rms"] for one in bins], [one["mean"] for one in bins]
    axes = Axes(
        (scale * bins[0]["low"], scale * bins[-1]["high"]),
        (min(-1.2, *mean), max(2.0, *(1.08 * v for v in rms))),
        f"{CHANNEL_NAMES.get(name, name)} [{unit}]",
        "residual [noise std]",
        (360, 200),
    )
    axes.line(axes.x, (1.0, 1.0), "soft", **{"stroke-dasharray": "2 3"})
    axes.line(axes.x, (0.0, 0.0), "soft", **{"stroke-width": 1})
    axes.line(middles, rms, "blue")
    axes.points(middles, rms, "blue")
    axes.line(middles, mean, "orange", **{"stroke-dasharray": "5 4"})
    worst = max(bins, key=lambda one: one["excess"])
    if worst["rms"] > WORST:
        axes.mark((scale * worst["low"], scale * worst["high"]), f"worst: {worst['rms']:.3g} × noise")
    return axes.svg(f"{channel}: residual over {CHANNEL_NAMES.get(name, name)}")


WORST = 1.15  # rms over noise from which on a bin is marked


def over_law(answer: Answer) -> str:
    """Draw what a model left and what a drafted law adds to it, over the variable of the law."""
    columns = answer["columns"]
    ends = [*columns["left"], *columns["low"], *columns["high"]]
    axes = Axes(extent(columns["q"], room=0.0), extent(ends), answer["label"], "normal force [N]", WIDE)
    axes.points(columns["q"], columns["left"], "ink-soft", radius=DOT)
    for q, low, high in zip(columns["q"], columns["low"], columns["high"], strict=True):
        axes.line((q, q), (low, high), "soft", **{"stroke-width": 1})
    axes.points(columns["q"], columns["law"], "blue", radius=DOT)
    return axes.svg(f"what was left, and {answer['title']}")


def over_phases(phases: Sequence[Answer]) -> str:
    """Return the residual by regime as a table with bars."""
    most = max((one["rms"] for one in phases), default=1.0)
    rows = [
        (one["name"], one["rows"], f"{one['mean']:+.2f}", f"{one['rms']:.2f}",
         Markup(bar(one["rms"] / most, is_bad=one["rms"] > WORST)))
        for one in phases
    ]  # fmt: skip
    return table(("regime", "rows", "mean", "rms", ""), rows, numbers=(1, 2, 3), kind="phases")


def ladder_width(count: int) -> int:
    """Return in how many pixels the names of so many models stand beside each other."""
    return max(420, 170 * count)


def ladder(rungs: Sequence[Answer]) -> str:
    """Draw the error of each model against the noise, in training and held out."""
    names = [short_name(rung["effect"]) for rung in rungs]
    places = [float(i) for i in range(len(rungs))]
    held = [
        (i, rung["heldout_error"]) for i, rung in zip(places, rungs, strict=True) if rung.get("heldout_error")
    ]
    errors = [rung["error"] for rung in rungs]
    top = max(2.0, 1.15 * max([*errors, *(error for _, error in held)]))
    axes = Axes(
        (-0.5, len(rungs) - 0.5),
        (0.9, top),
        "model",
        "error over noise",
        (ladder_width(len(rungs)), 240),
        is_logarithmic=True,
        x_names=names,
    )
    axes.line(axes.x, (1.0, 1.0), "green", **{"stroke-dasharray": "6 4"})
    axes.line(places, errors, "blue")
    axes.points(places, errors, "blue")
    if held:
        axes.line([x for x, _ in held], [y for _, y in held], "orange", **{"stroke-dasharray": "5 4"})
        axes.points([x for x, _ in held], [y for _, y in held], "orange", filled=False)
    return axes.svg("ladder of errors")


def short_name(effect: str | None) -> str:
    return "start" if effect is None else f"+ {effect.replace('_', ' ')}"


def bar(share: float, *, is_bad: bool = False) -> str:
    width = f"{100.0 * min(max(share, 0.0), 1.0):.1f}"
    return f'<div class="bar"><i class="{"is-bad" if is_bad else ""}" style="width:{width}%"></i></div>'


def in_noise(channel: str, answer: Answer) -> str:
    rmse, noise = (format_quantity(channel, answer[key]) for key in ("rmse", "noise"))
    return f"{rmse} against {noise} of noise"


def _model(columns: Answer, scale: float) -> list[float]:
    return [
        scale * (low + high) / 2.0
        for low, high in zip(columns["model_low"], columns["model_high"], strict=True)
    ]
