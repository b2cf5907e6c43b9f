"""The grasp force node as a recording wants it: with that recording's radius and sensor noise."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vegrip.config import read_toml
from vegrip.identification.recording.data import Recording
from vegrip.runtime import Node, NodeContext
from vegrip.runtime.program import find_program

Settings = dict[str, Any]
CHANNELS_OF_NOISE = (
    "normal_force",
    "displacement",
    "tangential_force",
    "torque_z",
    "contact_radius",
    "temperature",
)


def read_settings(path: Path | None) -> Settings:
    """Return the parameters of the node from a TOML file; a relative model file counts from that file."""
    settings = read_toml(path) if path is not None else {}
    tip = settings.get("tip")
    if path is not None and isinstance(tip, dict) and isinstance(tip.get("model"), str) and tip["model"]:
        tip["model"] = str(path.parent / tip["model"])
    return settings


def offline(settings: Mapping[str, Any]) -> Settings:
    """Return ``settings`` without the search for suspects, unless they ask for it.

    Its process answers in its own time: in simulated time that is after the end.
    """
    return {"suspects": False, **settings}


def with_recording(settings: Mapping[str, Any], recordings: Mapping[str, Recording]) -> Settings:
    """Return ``settings`` with what the recordings know of radius and noise, where they do not say it."""
    noise, tips = dict(settings.get("noise", {})), dict(settings.get("tips", {}))
    merged = {**settings, "noise": noise, "tips": tips}
    tip_says = {"radius", "model"} & settings.get("tip", {}).keys()
    for finger, recording in recordings.items():
        for name in CHANNELS_OF_NOISE:
            if name in recording.sensors:
                merged["noise"].setdefault(name, recording.sensors[name])
        radius = recording.fingertip.radius
        own = merged["tips"].get(finger, {})
        if not (math.isnan(radius) or tip_says or {"radius", "model"} & own.keys()):
            merged["tips"][finger] = {**own, "radius": radius}
    return merged


def grasp_node(
    settings: Mapping[str, Any], recordings: Mapping[str, Recording], program: str = "grasp_force"
) -> Node:
    context = NodeContext(program, fingers=tuple(recordings))
    return find_program(program)(with_recording(settings, recordings), context)
