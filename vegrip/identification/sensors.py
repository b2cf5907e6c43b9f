"""From the channels that a fingertip measures to the outputs that can be had of them.

>>> lacking({"normal_force", "displacement", "slip"})
['no slip margin and no grip command: tangential_force_x and tangential_force_y are not measured']
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from vegrip.identification.recording import Recording

GRAVITY: Final = 9.81  # [m/s^2]
TANGENTIAL_CHANNELS: Final = ("tangential_force_x", "tangential_force_y")
LOAD_REMEDY: Final = "state the load instead: vegrip replay RECORDING --through --load 1.5 (or --mass 0.3)"

Channels = Collection[str]


@dataclass(frozen=True)
class Output:
    """One thing that vegrip estimates."""

    name: str  # for people
    short: str  # the same as a heading
    needs: str  # which channels, in words
    given: Callable[[Channels], bool]  # whether it can be had of some channels
    otherwise: str  # what is done without


def _presses(channels: Channels) -> bool:
    return bool({"normal_force", "displacement"} & set(channels))


def _knows_load(channels: Channels) -> bool:
    return _presses(channels) and set(TANGENTIAL_CHANNELS) <= set(channels)


OUTPUT_NEEDS: Final = (
    Output(
        "contact radius, pressure exponent, limit force",
        "contact",
        "normal_force or displacement",
        _presses,
        "nothing can be estimated",
    ),
    Output(
        "slip margin, time to slip, grip command",
        "margin, grip",
        "that and tangential_force_x, tangential_force_y",
        _knows_load,
        "no margin; with a stated load or mass: the margin for that",
    ),
    Output(
        "torque in the margin",
        "torque",
        "those and torque_z",
        lambda channels: _knows_load(channels) and "torque_z" in channels,
        "counts as zero: a load off the centre slips earlier than reported",
    ),
    Output(
        "stiffness and relaxation learned",
        "stiffness",
        "normal_force and displacement",
        lambda channels: {"normal_force", "displacement"} <= set(channels),
        "stay as in the model file",
    ),
    Output(
        "friction learned at every slip",
        "friction",
        "both tangential forces, and slip or slip_speed",
        lambda channels: _knows_load(channels) and bool({"slip", "slip_speed"} & set(channels)),
        "stays as in the model file, unless a slip shows in the forces",
    ),
)

USUAL_SENSORS: Final = {
    "normal force": ("normal_force",),
    "position": ("displacement",),
    "normal force and position": ("normal_force", "displacement"),
    "and both tangential forces": ("normal_force", "displacement", *TANGENTIAL_CHANNELS),
    "and torque about the normal": ("normal_force", "displacement", *TANGENTIAL_CHANNELS, "torque_z"),
    "and slip": ("normal_force", "displacement", *TANGENTIAL_CHANNELS, "torque_z", "slip"),
}
"""Sets of sensors that hands have, each with what the next one adds."""


def answers(channels: Channels) -> dict[str, bool]:
    return {output.name: output.given(channels) for output in OUTPUT_NEEDS}


def lacking(channels: Channels, remedy: str = "") -> list[str]:
    """Return what a fingertip that measures ``channels`` does not measure and what that costs.

    A sentence each, what costs most first. The ``remedy`` stands behind the sentence on the missing margin.
    """
    if not _presses(channels):
        return ["no estimate at all: neither normal_force nor displacement is measured"]
    sentences = []
    if not _knows_load(channels):
        missing = " and ".join(name for name in TANGENTIAL_CHANNELS if name not in channels)
        are = "are" if " and " in missing else "is"
        advice = f"; {remedy}" if remedy else ""
        sentences.append(f"no slip margin and no grip command: {missing} {are} not measured{advice}")
    elif "torque_z" not in channels:
        sentences.append(
            "torque_z is not measured and counts as zero: a load off the centre slips earlier than reported"
        )
    for name, other in (("normal_force", "displacement"), ("displacement", "normal_force")):
        if name not in channels:
            sentences.append(
                f"stiffness and relaxation stay as in the model file: {name} is not measured beside {other}"
            )
    if _knows_load(channels) and not {"slip", "slip_speed"} & set(channels):
        sentences.append(
            "friction stays as in the model file unless a slip shows in the forces: "
            "neither slip nor slip_speed is measured"
        )
    return sentences


def with_load(recording: Recording, load: float) -> Recording:
    """Return ``recording`` as if its fingertip carried ``load`` [N] along x; what is measured stays.

    The margin is then that for the stated load: true where the finger carries no more than it.
    """
    rows = len(recording)
    stated = {TANGENTIAL_CHANNELS[0]: np.full(rows, load), TANGENTIAL_CHANNELS[1]: np.zeros(rows)}
    if set(TANGENTIAL_CHANNELS) <= set(recording.columns):
        return recording
    return replace(recording, columns={**recording.columns, **stated})


def share_of(mass: float, fingers: int) -> float:
    """Return the load [N] of each of ``fingers`` that hold ``mass`` [kg] between them, shared evenly."""
    return GRAVITY * mass / fingers
