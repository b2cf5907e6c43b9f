"""The launch file of a hand in parts, and the maps of its pads, drawn up from products and few answers."""

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Final

from vegrip.config import toml_key
from vegrip.connect.parts import listen
from vegrip.errors import ConfigError, InputError
from vegrip.transport.hands.bench import Source, read_source
from vegrip.transport.hands.drive_steps import step_above
from vegrip.transport.hands.wrist_load import GRAVITY
from vegrip.transport.maps.map_text import Setting, changed_text, key_line

WEAK_FRICTION: Final = 0.3  # of a rubber pad on what is smooth or dusty
PULLED: Final = 3.0  # times the weight: what shakes, pulls and what is poured in
PRESSED_N: Final = 1.0  # [N] a press that is meant
CLEARER: Final = 3.0  # times as much as any other pad feels
AXES: Final = {"x": ["x", "y", "z"], "-x": ["-x", "-y", "z"], "y": ["y", "-x", "z"], "-y": ["-y", "x", "z"]}
"""Our axes in those of the sensor, by which of its axes points up: that is our x."""


@dataclass(frozen=True)
class Answers:
    """What is asked for."""

    sides: Sequence[str]  # of the sensors, in their order
    up: Mapping[str, str]  # by side: which axis of the sensor points up
    sign: Mapping[str, int]  # of the normal force
    heaviest: float  # [kg] of the objects; 0: not known


def map_of_pad(source: Source, side: str, answers: Answers, said: Sequence[Setting]) -> str:
    """Return the map of one pad under the name of its jaw; other fingers of the product are left out."""
    text = source.path.read_text(encoding="utf-8")
    first, *others = source.plan.hand.fingers
    for name in others:
        text = re.sub(rf"^\[fingers\.{re.escape(toml_key(name))}\]\n", "", text, flags=re.MULTILINE)
    text = text.replace(f"[fingers.{toml_key(first)}]", f"[fingers.{toml_key(side)}]")
    own: list[Setting] = [(["transport", key], value) for key, value in source.transport.items()]
    if answers.up.get(side, "x") != "x":
        own.append((["fingers", side, "axes"], AXES[answers.up[side]]))
    if answers.sign.get(side, 1) < 0:
        own.append((["fingers", "*", "normal_force", "sign"], -1))
    text = changed_text(text, own, "answered to vegrip connect")
    return changed_text(text, [each for each in said if each[0][:2] == ["fingers", side]])


def launch_text(sides: Sequence[str], drive: Source, heaviest: float) -> str:
    """Return the launch file that joins ``SIDE.toml`` and the drive."""
    lines = [
        "# A bench as vegrip connect wrote it: docs/tutorials/bench.md. vegrip doctor tries each part.",
        key_line("sensors", [f"{side}.toml" for side in sides], ""),
        key_line("drive", drive.text, "its force serves all of these"),
        key_line("serves", list(sides), ""),
        "",
        "[[node]]",
        'program = "grasp_force"',
        "required = true",
        'restart = "always"',
    ]
    if heaviest:
        lines.append(f"parameters.limits.max_force = {largest_for(heaviest, drive)}  # [N]")
    return "\n".join(lines) + "\n"


def largest_for(mass: float, drive: Source) -> float:
    """Return the largest force [N] to allow for objects of a ``mass`` [kg]: N = 3 m g / (2 mu), mu = 0.3.

    Raises:
        ConfigError: the drive cannot hold the weight alone.

    """
    limits = drive.plan.hand.drive
    hold = mass * GRAVITY / (2.0 * WEAK_FRICTION)
    if hold > limits.maximum:
        raise ConfigError(
            f"{drive.text} presses with {limits.maximum:g} N at most, and {mass:g} kg need {hold:.0f} N "
            f"where friction is {WEAK_FRICTION:g}; take a lighter object"
        )
    least = limits.minimum + max(limits.resolution, limits.hysteresis)
    return round(step_above(limits, max(PULLED * hold, least)), 3)


def which_is_pressed(at_rest: Mapping[str, float], pressed: Mapping[str, float]) -> tuple[str, int]:
    """Return which pad is pressed, and the sign of its normal force, from means [N] by pad.

    Raises:
        InputError: none is, or two are.

    """
    change = {name: pressed[name] - at_rest[name] for name in at_rest}
    if silent := [name for name, force in change.items() if math.isnan(force)]:
        raise InputError(f"nothing comes of {', '.join(silent)}; `vegrip doctor` says more of each part")
    first, *others = sorted(change, key=lambda name: -abs(change[name]))
    least = max([PRESSED_N, *(CLEARER * abs(change[one]) for one in others)])
    if abs(change[first]) < least:
        felt = ", ".join(f"{name} {force:+.2f} N" for name, force in change.items())
        raise InputError(
            f"it is not clear which pad was pressed ({felt}); press one with {PRESSED_N:g} N or more"
        )
    return first, 1 if change[first] > 0.0 else -1


def listen_to_all(sources: Mapping[str, Source], seconds: float) -> dict[str, float]:
    """Return the mean normal force [N] of the first finger of each, all listened to at once; NaN: none."""
    with ExitStack() as stack:
        opened = {name: stack.enter_context(source.open(source.text)) for name, source in sources.items()}
        received = listen(opened, seconds)
    return {name: float(one.mean(next(iter(one.states), ""))[2]) for name, one in received.items()}


def sources_of(texts: Sequence[str]) -> list[Source]:
    """Read products with their ports: each must say where it is."""
    for text in texts:
        if "@" not in text:
            raise InputError(f"{text!r}: say where it is, as {text}@/dev/ttyACM0")
    return [read_source(text, "vegrip connect") for text in texts]
