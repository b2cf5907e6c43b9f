"""A layout for Foxglove: margin with its bound, forces, friction, health, alarms."""

from collections.abc import Mapping, Sequence
from typing import Any

from vegrip.bridges.foxglove_channels import ALARMS
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, Message, ModelHealth, SlipMargin
from vegrip.transport.codec.schema import Topics

COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd")
"""One a finger, the same in every plot; from the sixth finger on again."""
FRICTION = "friction_coefficient"
FOLLOWED = 30  # [s] that a plot shows


PLOTS: Mapping[str, tuple[str, Sequence[tuple[type[Message], str, str]]]] = {
    "margin": (
        "Slip margin (line) and its lower bound (dashed), 1",
        ((SlipMargin, "margin", "solid"), (SlipMargin, "lower_bound", "dashed")),
    ),
    "force": (
        "Normal force (line) and command (dashed), N",
        ((FingertipState, "normal_force", "solid"), (ForceCommand, "normal_force", "dashed")),
    ),
    "friction": (
        "Friction (line) and its standard deviation (dotted), 1",
        ((ContactEstimate, FRICTION, "solid"), (ContactEstimate, f"{FRICTION}_std", "dotted")),
    ),
    "health": (
        "Normalised innovation squared, 1 = the model explains the input",
        ((ModelHealth, "nis", "solid"),),
    ),
}
"""Panel -> title with unit, and the fields with their lines."""
STATES = "StateTransitions!health"
LOG = "RosOut!alarms"


def layout(hands: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """Return what Foxglove imports; ``hands``: namespace, "" = none, -> fingers."""
    tips = [(Topics(namespace), finger) for namespace, fingers in hands.items() for finger in fingers]
    panels: dict[str, dict[str, Any]] = {
        f"Plot!{name}": _plot(title, [one for field in fields for one in _series(tips, *field)])
        for name, (title, fields) in PLOTS.items()
    }
    states = _series(tips, ModelHealth, "condition") + _series(tips, ForceCommand, "reason")
    panels[STATES] = {"foxglovePanelTitle": "Input and reason of the command", "paths": states}
    panels[LOG] = {"foxglovePanelTitle": "Alarms", "topicToRender": ALARMS, "minLogLevel": 1}
    left = _split("column", "Plot!margin", _split("column", "Plot!force", "Plot!friction"))
    right = _split("column", "Plot!health", _split("column", STATES, LOG))
    empty: dict[str, Any] = {"globalVariables": {}, "userNodes": {}}
    return {
        "configById": panels,
        "layout": _split("row", left, right),
        "playbackConfig": {"speed": 1},
        **empty,
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
    tips: Sequence[tuple[Topics, str]], kind: type[Message], column: str, line: str = ""
) -> list[dict[str, Any]]:
    found = []
    for number, (topics, finger) in enumerate(tips):
        if (route := topics.outgoing(kind, finger)) is not None:
            path = {"value": f"{route.topic}.{column}", "enabled": True, "timestampMethod": "receiveTime"}
            label = {"label": f"{finger} {column.replace('_', ' ')}", "color": COLOURS[number % len(COLOURS)]}
            found.append(path | (label | {"lineStyle": line} if line else {"label": label["label"]}))
    return found


def _split(direction: str, first: Any, second: Any) -> dict[str, Any]:
    return {"direction": direction, "first": first, "second": second, "splitPercentage": 45}
