"""Protocol files: what a rig, a virtual finger or a model does with one fingertip, as TOML in SI units.

::

    name = "growing triangles"
    pause = 20.0              # [s] between episodes, out of contact

    [[episode]]
    note = "to half of the depth"
    segments = [
        { duration = 0.3, depth = -1e-4 },                 # [s], [m]: reached evenly at the end
        { speed = 2e-3, depth = 8e-4 },                    # [m/s] instead of a duration
        { duration = 2.0 },                                # held: what was imposed last
        { duration = 1.0, force = 1.5 },                   # [N]: from now on the force is imposed
        { duration = 1.0, pull_x = 1e-3, spin = 0.5 },     # the counter-surface moves [m/s], turns [rad/s]
        { duration = 2.0, amplitude = 5e-5, frequency = 8.0 },  # a sine on what is imposed
        { speed = 2e-3, depth = -1e-4 },
    ]
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from vegrip.config import build, parameter, read_toml, toml_value
from vegrip.errors import ConfigError, suggestion
from vegrip.model import ContactModel
from vegrip.virtual.bench.protocol import Episode, Segment, standard_protocol
from vegrip.virtual.settings import FingertipSettings
from vegrip.whole_file import write_whole, writing

__all__ = ["Episode", "Protocol", "Segment", "read_protocol", "write_protocol"]
EPISODE_PAUSE_S = 20.0  # [s]
MAX_PROTOCOL_S = 1e5  # [s] of a whole protocol
CLEARANCE_XREF = 0.1  # [x_ref] between tip and object before and after
STANDARD_AIR_S = 0.3  # [s]


@dataclass(frozen=True)
class Protocol:
    """Episodes in order; the contact recovers in the ``pause`` [s] between them.

    ``notes`` says of each episode what it is for, empty where there is nothing to say.
    """

    name: str
    episodes: tuple[Episode, ...]
    pause: float = EPISODE_PAUSE_S
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.episodes or not all(self.episodes):
            raise ConfigError(f"protocol {self.name}: it needs an [[episode]] with segments")
        if not self.duration <= MAX_PROTOCOL_S:
            raise ConfigError(
                f"protocol {self.name}: it lasts {self.duration:.3g} s, more than {MAX_PROTOCOL_S:g} s"
            )

    @property
    def duration(self) -> float:
        """From the first segment to the last, with the pauses [s]."""
        return self.recorded + self.pause * (len(self.episodes) - 1)

    @property
    def recorded(self) -> float:
        """The same without the pauses [s]."""
        return sum(segment.duration for episode in self.episodes for segment in episode)

    def repeated(self, times: int) -> "Protocol":
        notes = self.notes or ("",) * len(self.episodes)
        return replace(self, episodes=self.episodes * times, notes=notes * times)

    def at_rest_between(self) -> Episode:
        """Return all episodes as one, the finger waiting in the pauses where it was left."""
        wait = Segment(self.pause)
        joined = list(self.episodes[0])
        for episode in self.episodes[1:]:
            joined += [wait, *episode] if self.pause > 0.0 else episode
        return tuple(joined)


@dataclass(frozen=True)
class _Entry:
    duration: float = parameter(math.nan, unit="s", low=1e-4, high=MAX_PROTOCOL_S, doc="how long")
    speed: float = parameter(math.nan, unit="m/s", low=1e-9, high=10.0, doc="instead of a duration")
    depth: float = parameter(math.nan, unit="m", low=-1.0, high=1.0, doc="to reach at the end")
    force: float = parameter(math.nan, unit="N", low=0.0, high=1e6, doc="to reach at the end")
    amplitude: float = parameter(0.0, low=0.0, high=1e6, doc="of a sine on what is imposed, in its unit")
    frequency: float = parameter(0.0, unit="Hz", low=0.0, high=1e4, doc="of the sine")
    pull_x: float = parameter(0.0, unit="m/s", low=-10.0, high=10.0, doc="of the counter-surface")
    pull_y: float = parameter(0.0, unit="m/s", low=-10.0, high=10.0, doc="of the counter-surface")
    spin: float = parameter(0.0, unit="rad/s", low=-1e3, high=1e3, doc="of the counter-surface")


def read_protocol(path: Path | str) -> Protocol:
    """Read a protocol file.

    Raises:
        ConfigError: not readable, or something in it cannot be; names file, episode, segment and key.

    """
    table = read_toml(Path(path))
    _check_keys(table, ("name", "pause", "episode"), str(path))
    pause = _seconds(table.get("pause", EPISODE_PAUSE_S), f"{path}: 'pause'")
    episodes, notes = [], []
    for i, section in enumerate(_list(table.get("episode", []), f"{path}: 'episode'")):
        where = f"{path} episode {i + 1}"
        _check_keys(section, ("note", "segments"), where)
        entries = _list(section.get("segments", []), f"{where}: 'segments'")
        episodes.append(tuple(_segments(entries, where)))
        notes.append(str(section.get("note", "")))
    if not episodes:
        raise ConfigError(f"{path}: it has no [[episode]]; a protocol needs one with segments")
    return Protocol(str(table.get("name", Path(path).stem)), tuple(episodes), pause, tuple(notes))


def _check_keys(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            raise ConfigError(f"{where}: unknown key {key!r}; {suggestion(key, known, 'known are')}")


def _segments(entries: list[Mapping[str, Any]], where: str) -> Iterator[Segment]:
    last = 0.0  # [m] depth at the end of the segment before; NaN where the force was imposed
    for i, table in enumerate(entries):
        at = f"{where} segment {i + 1}"
        entry = build(_Entry, table, at)
        deep, pressed = not math.isnan(entry.depth), not math.isnan(entry.force)
        if deep and pressed:
            raise ConfigError(f"{at}: depth and force cannot both be imposed; leave one out")
        if (entry.amplitude > 0.0) != (entry.frequency > 0.0):
            raise ConfigError(f"{at}: a sine needs amplitude and frequency")
        duration = _duration(entry, last, deep, at)
        last = entry.depth if deep else math.nan if pressed else last
        yield Segment(
            duration, entry.depth if deep else None, entry.force if pressed else None, entry.amplitude,
            entry.frequency, entry.pull_x, entry.pull_y, entry.spin,
        )  # fmt: skip


def _duration(entry: _Entry, last: float, deep: bool, at: str) -> float:
    if math.isnan(entry.duration) == math.isnan(entry.speed):
        raise ConfigError(f"{at}: give either its duration (in s) or a speed (in m/s)")
    if not math.isnan(entry.duration):
        return entry.duration
    if not deep or math.isnan(last):
        raise ConfigError(f"{at}: a speed needs a depth to reach, and one to start from; give a duration")
    if entry.depth == last:
        raise ConfigError(f"{at}: it is at this depth already, so a speed says nothing; give a duration")
    return abs(entry.depth - last) / entry.speed


def _list(value: Any, what: str) -> list[Mapping[str, Any]]:
    if not isinstance(value, list) or not all(isinstance(one, Mapping) for one in value):
        raise ConfigError(f"{what} must be a list of tables")
    return value


def _seconds(value: Any, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= MAX_PROTOCOL_S:
        raise ConfigError(f"{what} is {value!r}; it must be a number of seconds from 0 to {MAX_PROTOCOL_S:g}")
    return float(value)


def write_protocol(protocol: Protocol, path: Path | str, comment: str = "") -> None:
    """Write ``protocol``; :func:`read_protocol` gives the same back. ``comment`` goes to the top."""
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    lines += ["# SI units: s, m, N, m/s, rad/s, Hz.", f"name = {toml_value(protocol.name)}"]
    lines += [f"pause = {protocol.pause!r}  # [s] between episodes, out of contact"]
    notes = protocol.notes or ("",) * len(protocol.episodes)
    for episode, note in zip(protocol.episodes, notes, strict=True):
        lines += ["", "[[episode]]", *([f"note = {toml_value(note)}"] if note else []), "segments = ["]
        lines += [f"    {{ {_line(segment)} }}," for segment in episode]
        lines.append("]")
    with writing(Path(path), ConfigError):
        write_whole(Path(path), "\n".join(lines) + "\n")


def _line(segment: Segment) -> str:
    keys = {"duration": segment.duration, "depth": segment.depth, "force": segment.force}
    rest = {name: getattr(segment, name) for name in ("amplitude", "frequency", "pull_x", "pull_y", "spin")}
    keys |= {name: value for name, value in rest.items() if value}
    return ", ".join(f"{name} = {float(value)!r}" for name, value in keys.items() if value is not None)


def clear(model: ContactModel) -> Segment:
    return Segment(STANDARD_AIR_S, depth=-CLEARANCE_XREF * model.reference_depth)


def standard(model: ContactModel) -> Protocol:
    """Return 20 episodes scaled to the fingertip; the deepest press reaches 16 % of its radius."""
    tip = FingertipSettings(
        radius=model.tip_radius,
        reference_indentation=model.reference_depth,
        reference_force=model.values["K"].value if "K" in model.values else 1.0,
        exponent=min(max(model.values["p"].value if "p" in model.values else 1.5, 1.0), 3.0),
    )
    episodes = tuple(_in_air(episode, clear(model)) for episode in standard_protocol(tip, size=0.8))
    return Protocol("standard", episodes, 20.0)


def _in_air(episode: Episode, air: Segment) -> Episode:
    away = [replace(s, depth=air.depth) if s.depth == 0.0 else s for s in episode]
    return (air, *away[1:], air)
