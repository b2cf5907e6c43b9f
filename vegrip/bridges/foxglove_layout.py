"""A layout for Foxglove: margin with its bound, forces, friction, health, alarms."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from vegrip.bridges.foxglove_server import ALARMS
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, Message, ModelHealth, SlipMargin
from vegrip.transport.codec.schema import Topics

FINGERS = ("thumb", "index", "middle", "ring", "little")
"""Of the demonstration; for a layout that is written while no hand runs."""
COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd")
"""One a finger, the same in every plot; from the sixth finger on again."""
FOLLOWED = 30  # [s] that a plot shows


def layout(hands: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """Return what Foxglove imports; ``hands``: namespace, "" = none, -> fingers."""
    tips = [(Topics(namespace), finger) for namespace, fingers in hands.items() for finger in fingers]
    panels: dict[str, dict[str, Any]] = {
        "Plot!margin": _plot(
            "Slip margin (line) and its lower bound (dashed), 1",
            [
                *_series(tips, SlipMargin, "margin"),
                *_series(tips, SlipMargin, "lower_bound", lineStyle="dashed"),
            ],
        ),
        "Plot!force": _plot(
            "Normal force (line) and command (dashed), N",
            [
                *_series(tips, FingertipState, "normal_force"),
                *_series(tips, ForceCommand, "normal_force", lineStyle="dashed"),
            ],
        ),
        "Plot!friction": _plot(
            "Friction (line) and its standard deviation (dotted), 1",
            [
                *_series(tips, ContactEstimate, "friction_coefficient"),
                *_series(tips, ContactEstimate, "friction_coefficient_std", lineStyle="dotted"),
            ],
        ),
        "Plot!health": _plot(
            "Normalised innovation squared, 1 = the model explains the input",
            [
                *_series(tips, ModelHealth, "nis"),
            ],
        ),
        "StateTransitions!health": {
            "foxglovePanelTitle": "Input and reason of the command",
            "paths": [
                *_series(tips, ModelHealth, "condition"),
                *_series(tips, ForceCommand, "reason"),
            ],
            "isSynced": True,
        },
        "RosOut!alarms": {
            "foxglovePanelTitle": "Alarms",
            "topicToRender": ALARMS,
            "minLogLevel": 1,
            "searchTerms": [],
        },
    }
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _row(
            _column("Plot!margin", _column("Plot!force", "Plot!friction")),
            _column("Plot!health", _column("StateTransitions!health", "RosOut!alarms")),
        ),
    }


def _plot(title: str, paths: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "foxglovePanelTitle": title,
        "paths": paths,
        "showLegend": True,
        "legendDisplay": "floating",
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "isSynced": True,
        "xAxisVal": "timestamp",
        "followingViewWidth": FOLLOWED,
    }


def _series(
    tips: Iterable[tuple[Topics, str]], kind: type[Message], column: str, **style: str
) -> list[dict[str, Any]]:
    found = []
    for number, (topics, finger) in enumerate(tips):
        if (route := topics.outgoing(kind, finger)) is not None:
            path = {"value": f"{route.topic}.{column}", "enabled": True, "timestampMethod": "receiveTime"}
            label = {"label": f"{finger} {column.replace('_', ' ')}", "color": COLOURS[number % len(COLOURS)]}
            found.append({**path, **label, **style})
    return found


def _row(first: Any, second: Any) -> dict[str, Any]:
    return {"direction": "row", "first": first, "second": second, "splitPercentage": 50}


def _column(first: Any, second: Any) -> dict[str, Any]:
    return {"direction": "column", "first": first, "second": second, "splitPercentage": 45}
