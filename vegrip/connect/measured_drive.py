"""The map of a drive as it was measured: its ``[drive]``, and its command in newtons that the pads feel.

A command is ``value = k F + c`` in the unit of its signal (k: ``sign``, ``scale`` and newtons of the unit). A
drive that was commanded F is felt as ``a F + b``, so that k becomes k / a, and c becomes c - k b / a.
"""

import math
from collections.abc import Mapping
from typing import Any

from vegrip.config import parse_toml
from vegrip.connect.drive_response import DriveResponse
from vegrip.transport.hands.bench import Source
from vegrip.transport.mapped.commands import law_of
from vegrip.transport.maps.map_text import Setting, changed_text, surely_changed, whole
from vegrip.transport.maps.schema import ALL

LINEAR = ("force", "current")
"""Kinds of commands whose value is a line in the force; the others follow what is felt by themselves."""


def measured_settings(source: Source, found: DriveResponse) -> list[Setting]:
    """Return what a map gets of what was found; forces of ``[drive]`` are those that are felt."""
    drive = source.plan.hand.drive
    table = whole(parse_toml(source.path.read_text(encoding="utf-8")), str(source.path))
    said: dict[str, float] = dict(found.settings)
    commands: list[Setting] = []
    for finger in source.commanded:
        command = source.plan.hand.fingers[finger].command
        if command is None or command.kind not in LINEAR:
            continue
        law = law_of(command, command.unit, finger)
        slope = law.sign * law.scale * law.per_newton
        place = ["fingers", _owner(table["fingers"], finger), "command"]
        scale = command.scale / found.gain.value
        offset = command.offset - slope * found.offset.value / found.gain.value
        commands += [([*place, "scale"], _rounded(scale)), ([*place, "offset"], _rounded(offset))]
        said |= {"minimum": round(max(found.felt(drive.minimum), 0.0), 3)} if drive.minimum else {}
        said |= {"maximum": round(found.felt(drive.maximum), 3)} if math.isfinite(drive.maximum) else {}
    distinct = {tuple(path): (path, value) for path, value in commands}
    return [*((["drive", key], value) for key, value in said.items()), *distinct.values()]


def measured_map(source: Source, settings: list[Setting]) -> str:
    """Return the text of the map with ``settings``, and with where the device is.

    Raises:
        InputError: the map has no lines for them; says what to write by hand.

    """
    transport: list[Setting] = [
        (["transport", key], value)
        for key, value in source.transport.items()
        if value != source.plan.hand.transport.get(key)
    ]
    text = changed_text(source.path.read_text(encoding="utf-8"), transport, f"of {source.text}")
    return surely_changed(text, settings, str(source.path), "measured by vegrip calibrate --drive")


def _owner(fingers: Mapping[str, Any], finger: str) -> str:
    """Return whose table has the command of ``finger``: its own, or that of all."""
    return finger if "command" in fingers.get(finger, {}) else ALL


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")
