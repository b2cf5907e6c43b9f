"""The launch file of a hand in parts, and the maps of its pads, drawn up from products and few answers."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from vegrip.config import parse_toml, read_toml, toml_key
from vegrip.connect.parts import listen
from vegrip.errors import ConfigError, InputError, UsageError
from vegrip.transport.hands.bench import Source, read_source
from vegrip.transport.hands.drive_steps import step_above
from vegrip.transport.hands.wrist_load import GRAVITY
from vegrip.transport.maps.map_text import (
    Setting,
    key_line,
    surely_changed,
    whole,
)
from vegrip.transport.maps.products import map_of
from vegrip.transport.maps.schema import ALL
from vegrip.transport.open import map_and_port
from vegrip.whole_file import write_whole

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


@dataclass(frozen=True)
class Named:
    """A part as it is named: PRODUCT@PORT, or FILE[@PORT]."""

    text: str
    path: Path  # of its map
    port: str  # empty: that of the map

    @property
    def map(self) -> Mapping[str, Any]:
        return whole(read_toml(self.path), str(self.path))

    @property
    def fingers(self) -> list[str]:
        fingers = self.map.get("fingers")
        return [name for name in fingers if name != ALL] if isinstance(fingers, Mapping) else []

    @property
    def where(self) -> list[Setting]:
        """What its map gets that says where it is, and where its database is."""
        table = self.map
        key = "channel" if table.get("transport", {}).get("kind") == "can" else "address"
        found: list[Setting] = [(["transport", key], self.port)] if self.port else []
        if "database" in table:
            found.append((["database"], str(self.path.parent.absolute() / table["database"])))
        return found


def named(text: str) -> Named:
    """Read how a part is named: a product must say where it is.

    Raises:
        InputError: there is no such product or map, or no port.

    """
    name, at, port = map_and_port(text)
    is_file = name.endswith(".toml")
    if not port and (at or not is_file):
        raise InputError(f"{text!r}: say where it is, as {name}@/dev/ttyACM0")
    if is_file and not Path(name).is_file():
        raise InputError(f"there is no map {name!r}; give a file, or PRODUCT@PORT")
    found = Named(text, Path(name) if is_file else map_of(name), port)
    if not found.fingers:
        raise InputError(f"{name}: is no map; it has no [fingers.NAME]")
    return found


def said_of_parts(
    said: Sequence[Setting], groups: Mapping[str, Sequence[str]], jaws: Sequence[str]
) -> tuple[dict[str, list[Setting]], list[Setting]]:
    """Return what is said of each map of pads, and of that of the drive, whose fingers are ``jaws``.

    Raises:
        UsageError: a key is of no part.

    """
    pads: dict[str, list[Setting]] = {file: [] for file in groups}
    of_finger = {side: pads[file] for file, sides in groups.items() for side in sides}
    drive: list[Setting] = []
    for path, value in said:
        finger = path[1] if path[0] == "fingers" and len(path) > 2 else ""
        if finger in of_finger:
            of_finger[finger].append((path, value))
        elif finger in jaws or (finger == ALL and path[2] == "command") or (path[0] == "drive" and path[1:]):
            drive.append((path, value))
        elif finger == ALL:
            for settings in pads.values():
                settings.append((path, value))
        else:
            known = ", ".join(f"fingers.{name}" for name in (*of_finger, *jaws, ALL))
            raise UsageError(
                f"--set {'.'.join(path)}: of a bench there are {known} and drive; what else differs stands "
                "in a map of yours, FILE@PORT"
            )
    return pads, drive


def map_of_pads(
    given: Named, sides: Sequence[str], said: Sequence[Setting], answers: Answers | None = None
) -> str:
    """Return the map of one pad under the name of its jaw, without other fingers, or of a hub with all.

    Raises:
        InputError: its map has no lines of their own for that, or for what is ``said``.

    """
    text = _without_like(given.path)
    text = _of_one_finger(text, given.fingers, sides[0]) if len(sides) == 1 else text
    text = surely_changed(text, given.where, given.text, f"of {given.text}")
    table = parse_toml(text)
    if [name for name in table.get("fingers", {}) if name != ALL] != list(sides):
        raise InputError(
            f"{given.text}: [fingers.{given.fingers[0]}] has no lines of its own; call it {sides[0]} there"
        )
    if answers is not None:
        settings = _in_place(table["fingers"], _answered(sides, table["fingers"], answers))
        text = surely_changed(text, settings, given.text, "answered to vegrip connect")
    return surely_changed(text, _in_place(table["fingers"], said), given.text)


def _of_one_finger(text: str, fingers: Sequence[str], side: str) -> str:
    """Return the text of a map with the first of its ``fingers`` as ``side``, and without the others."""
    headers = {name: tuple(f"[fingers.{toml_key(name)}{end}" for end in "].") for name in fingers}
    own, *others = headers.values()
    lines, is_out = [], False
    for line in text.split("\n"):
        if line.startswith("["):
            is_out = any(line.startswith(other) for other in others)
        if not is_out:
            is_own = line.startswith(own)
            lines.append(f"[fingers.{toml_key(side)}{line[len(own[0]) - 1 :]}" if is_own else line)
    return "\n".join(lines).replace("{finger}", fingers[0])  # signals keep its name


def _answered(sides: Sequence[str], fingers: Mapping[str, Any], answers: Answers) -> list[Setting]:
    found: list[Setting] = [
        (["fingers", side, "axes"], AXES[answers.up[side]])
        for side in sides
        if answers.up.get(side, "x") != "x"
    ]
    if answers.sign.get(sides[0], 1) < 0:
        has_taxels = any("taxels" in keys for keys in fingers.values())
        found.append((["fingers", ALL, "taxels" if has_taxels else "normal_force", "sign"], -1))
    return found


def map_of_drive(given: Named, said: Sequence[Setting]) -> str:
    """Return the map of the drive, with where it is; raises as :func:`map_of_pads`."""
    text = surely_changed(given.path.read_text("utf-8"), given.where, given.text, f"of {given.text}")
    return surely_changed(text, _in_place(given.map["fingers"], said), given.text)


def _without_like(path: Path) -> str:
    """Return the text of a map, that of what it is ``like`` with its own values set."""
    table = read_toml(path)
    if "like" not in table:
        return path.read_text("utf-8")
    own = {key: value for key, value in table.items() if key != "like"}
    return surely_changed(
        _without_like(map_of(table["like"])), list(_leaves(own)), str(path), f"of {path.name}"
    )


def _leaves(table: Mapping[str, Any]) -> Iterator[Setting]:
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield from (([key, *path], one) for path, one in _leaves(value))
        else:
            yield [key], value


def _in_place(fingers: Mapping[str, Any], said: Sequence[Setting]) -> list[Setting]:
    """Return what is said of fingers where the map of one finger has it: its own table hides that of all."""
    names = [name for name in fingers if name != ALL]
    if len(names) != 1:
        return list(said)
    own, shared = fingers[names[0]], fingers.get(ALL, {})
    found: list[Setting] = []
    for path, value in said:
        first, finger, *rest = path
        if first == "fingers":
            finger = names[0] if rest[0] in own else ALL if rest[0] in shared and rest[1:] else finger
        found.append(([first, finger, *rest], value))
    return found


def launch_text(files: Iterable[str], sides: Sequence[str], drive: str, largest: float) -> str:
    """Return the launch file that joins ``FILE.toml`` and ``drive``; ``largest`` force [N], 0: not known."""
    lines = [
        "# A bench as vegrip connect wrote it: docs/tutorials/bench.md. vegrip doctor tries each part.",
        key_line("sensors", [f"{file}.toml" for file in files], ""),
        key_line("drive", drive, "its force serves all of these"),
        key_line("serves", list(sides), ""),
        "",
        "[[node]]",
        'program = "grasp_force"',
        "required = true",
        'restart = "always"',
    ]
    if largest:
        lines.append(f"parameters.limits.max_force = {largest}  # [N]")
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
    """Return the mean normal force [N] of each, by finger of a hub, all listened to at once; NaN: none."""
    with ExitStack() as stack:
        opened = {name: stack.enter_context(source.open(source.text)) for name, source in sources.items()}
        received = listen(opened, seconds)
    return {
        name if len(sources[name].names) == 1 else finger: float(one.mean(finger)[2])
        for name, one in received.items()
        for finger in sources[name].names
    }


def source_of(given: Named, text: str, file: Path) -> Source:
    """Read a part of which the map is ``text``, which goes to ``file``."""
    write_whole(file, text)
    try:
        return replace(read_source(str(file), "vegrip connect"), text=given.text)
    except ConfigError as error:
        raise ConfigError(str(error).replace(str(file), given.text)) from None
