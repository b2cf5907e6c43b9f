"""A recording: channels with their ranges and noise, and the force over time."""

from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from vegrip.display import card as cards
from vegrip.display.text import Part, plain, table_of
from vegrip.displayed import one_of
from vegrip.identification.compare.plot import TIME_LABEL, drawn_time, scaled
from vegrip.identification.recording import Recording
from vegrip.identification.recording.channels import RECORDED, noise_name
from vegrip.identification.sensors import LOAD_REMEDY, lacking
from vegrip.plotting import new_figure
from vegrip.web.axes import Axes, extent
from vegrip.web.markup import listed, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OUT_OF_SIGHT = (
    "without a contact stiffness and memory of the material show; contact radius and friction do not"
)
OF_A_STEP = f"{OUT_OF_SIGHT}, nor in a step the exponent of the stiffness"
HEAD = ("column", "unit", "min", "max", "noise std")
DRAWN = 400  # columns of a card, each the least and the greatest value


def describe(recording: Recording) -> dict[str, Any]:
    """Return what ``--json`` says of a recording; what is not known is null."""
    return {
        "name": recording.name,
        "finger": recording.fingertip.name,
        "radius": _number(recording.fingertip.radius),
        "rows": len(recording),
        "duration": recording.duration,
        "episodes": len(np.unique(recording.episode)),
        "columns": {
            name: {
                "unit": RECORDED[name].unit,
                "min": _number(np.fmin.reduce(values)) if len(values) else None,
                "max": _number(np.fmax.reduce(values)) if len(values) else None,
                "noise": recording.sensors.get(noise_name(name)),
            }
            for name, values in recording.columns.items()
        },
        "lacking": [OF_A_STEP if recording.is_step else OUT_OF_SIGHT]
        if recording.is_material
        else lacking(recording.columns, LOAD_REMEDY),
        "report": recording.report.as_dict(),
    }


as_json = describe


def _number(value: float) -> float | None:
    return None if np.isnan(value) else float(value)


def size_of(about: dict[str, Any]) -> str:
    """Return rows, duration, episodes and fingertip of what :func:`describe` says."""
    radius = f"{about['radius']:g} m" if about["radius"] is not None else "unknown"
    size = f"{about['rows']} rows, {about['duration']:.6g} s, {about['episodes']} episode(s)"
    is_of_contact = about["lacking"] not in ([OF_A_STEP], [OUT_OF_SIGHT])
    return f"{size}, {about['finger']}, radius {radius}" if is_of_contact else f"{size}, without a contact"


def table_of_columns(about: dict[str, Any]) -> Part:
    return table_of(HEAD, _rows(about), left=("column", "unit"))


def _rows(about: dict[str, Any]) -> list[tuple[str, ...]]:
    return [
        (
            name,
            one["unit"],
            *("-" if (v := one[key]) is None else f"{v:.5g}" for key in ("min", "max", "noise")),
        )
        for name, one in about["columns"].items()
    ]


def brief(recording: Recording) -> str:
    return f"{recording.name}: {size_of(describe(recording))}, {', '.join(recording.columns)}"


def text(recording: Recording, most: int | None = None) -> str:
    del most  # a dozen channels at most
    about = describe(recording)
    found = [f"- {finding}" for finding in recording.report.findings]
    return plain([f"{recording.name}: {size_of(about)}", table_of_columns(about), *found])


def card(recording: Recording) -> str:
    about = describe(recording)
    name = "normal_force" if "normal_force" in recording.columns else next(iter(recording.columns))
    content = (
        f"<p>{escape(size_of(about))}</p>",
        _drawn(recording, name) if len(recording) else "",
        table(HEAD, _rows(about), numbers=(2, 3, 4)),
        listed([*(str(finding) for finding in recording.report.findings), *about["lacking"]]),
    )
    return cards.verdict(f"recording {recording.name}", "", "", "", *content)


def _drawn(recording: Recording, name: str) -> str:
    scale, unit = scaled(RECORDED[name].unit)
    known = np.isfinite(recording.columns[name])
    t, values = drawn_time(recording)[known], scale * recording.columns[name][known]
    starts = np.unique(np.linspace(0, max(t.size - 1, 0), DRAWN).astype(np.int64))
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    label = f"{name.replace('_', ' ')} [{unit}]"
    axes = Axes(
        extent(t.tolist(), room=0.0), extent([*low.tolist(), *high.tolist()]), TIME_LABEL, label, (900, 200)
    )
    axes.band(t[starts].tolist(), low.tolist(), high.tolist(), "blue")
    axes.line(t[starts].tolist(), high.tolist(), "blue", **{"stroke-width": 1})
    return axes.svg(f"{name} over time")


def figure(recording: Recording, channel: str) -> "Figure":
    """Return all channels over time, or one."""
    known = list(recording.columns)
    names = [one_of(channel, known)] if channel else known
    drawn, axes = new_figure(len(names), size=(10.0, 1.0 + 1.6 * len(names)), share_x=True)
    t = drawn_time(recording)
    for axis, name in zip(axes, names, strict=True):
        scale, unit = scaled(RECORDED[name].unit)
        axis.plot(t, scale * recording.columns[name], lw=0.8)
        axis.set_ylabel(f"{name.replace('_', ' ')} [{unit}]", fontsize=8)
    axes[-1].set_xlabel(TIME_LABEL)
    drawn.suptitle(recording.name)
    return drawn


def columns(recording: Recording) -> dict[str, Any]:
    return {"t": recording.t, "episode": recording.episode, **recording.columns}
