"""The menu: kinds of experiment, each with amplitudes to choose.

Depths are shares of the greatest allowed one, so that an item is the same for a fingertip and a cell.
"""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np

from vegrip.config import build, parameter, read_toml
from vegrip.identification.fit.motion import motion_of
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.recording import Recording
from vegrip.identification.simulate import Protocol, Segment
from vegrip.virtual.bench.protocol import Episode

USUAL_DURATION_S = 120.0  # [s]
SPEED_PERCENTILE = 99.5  # percentile of the speed that counts as the greatest: jumps in the record are none
AIR_S = 0.5  # [s] out of contact before and after each contact: the zeros of the sensors
CLEARANCE_SHARE = 0.05  # [of the depth] distance kept there
SLID = 3.0  # times the motion at which a contact of that depth slips
FINEST = 8  # samples per period of a sine


@dataclass(frozen=True)
class RigLimits:
    """Greatest values of an experiment; NaN = as in the recording."""

    depth: float = parameter(math.nan, unit="m", low=1e-9, high=1.0, doc="greatest indentation")
    force: float = parameter(math.nan, unit="N", low=1e-12, high=1e5, doc="greatest normal force")
    speed: float = parameter(math.nan, unit="m/s", low=1e-9, high=10.0, doc="fastest motion along the normal")
    tangential_force: float = parameter(math.nan, unit="N", low=0.0, high=1e5, doc="0 = the rig cannot pull")
    torque: float = parameter(math.nan, unit="N m", low=0.0, high=1e4, doc="0 = the rig cannot twist")
    duration: float = parameter(
        USUAL_DURATION_S, unit="s", low=1.0, high=1e5, doc="of the experiment, with pauses"
    )
    pause: float = parameter(10.0, unit="s", low=0.0, high=1e4, doc="between episodes, for recovery")


def read_limits(path: Path) -> RigLimits:
    """Read a file with keys of :class:`RigLimits`."""
    return build(RigLimits, read_toml(path), str(path))


def limits_of(recording: Recording) -> RigLimits:
    """Return what was done in ``recording``: the rig can do that again."""
    columns, noise = recording.columns, noise_of(recording)
    first = np.r_[1.0, np.diff(recording.episode) != 0].astype(np.float64)
    depth = motion_of(recording.t, first, columns["displacement"].copy(), noise.displacement).displacement
    same = np.diff(recording.episode) == 0
    speed = np.abs(np.diff(depth) / np.diff(recording.t))[same]
    none = np.zeros(1)
    pull = np.hypot(*(np.nan_to_num(columns.get(f"tangential_force_{axis}", none)) for axis in "xy"))
    slides = bool(np.any(columns.get("slip", none) == 1.0))
    return RigLimits(
        float(depth.max()),
        float(np.nanmax(columns["normal_force"])),
        float(np.percentile(speed, SPEED_PERCENTILE)) if speed.size else 1e-3,
        float(pull.max()) if slides else 0.0,
        float(np.nanmax(np.abs(np.nan_to_num(columns.get("torque_z", none))))) if slides else 0.0,
    )


def complete_limits(given: RigLimits, usual: RigLimits) -> RigLimits:
    unknown = {f.name for f in fields(RigLimits) if math.isnan(getattr(given, f.name))}
    return replace(given, **{name: getattr(usual, name) for name in unknown})


@dataclass(frozen=True)
class Rig:
    """The scales of the items: depth [m], speed [m/s], rate [Hz], pause [s], friction [-]."""

    depth: float
    speed: float
    rate: float
    pause: float
    friction: float = 0.7

    def air(self, duration: float = AIR_S) -> Segment:
        return Segment(duration, depth=-CLEARANCE_SHARE * self.depth)

    def go(self, start: float, depth: float, speed: float = 0.0) -> Segment:
        """Return the motion from one depth to the other [m], as fast as allowed or with ``speed``."""
        pace = min(speed, self.speed) if speed > 0.0 else self.speed
        return Segment(max(abs(depth - start) / pace, 2.0 / self.rate), depth=depth)

    def press(self, depth: float, *inside: Segment, speed: float = 0.0) -> Episode:
        off = -CLEARANCE_SHARE * self.depth
        return (self.air(), self.go(off, depth, speed), *inside, self.go(depth, off, speed), self.air())


Levels = Mapping[str, tuple[float, ...]]
Make = Callable[..., list[Episode]]


@dataclass(frozen=True)
class Item:
    """One kind of experiment; ``make(rig, **amplitudes)`` gives its episodes."""

    name: str
    make: Make
    levels: Levels
    has_tangential_load: bool = False  # it pulls or twists

    def choices(self) -> Iterator[dict[str, float]]:
        for values in itertools.product(*self.levels.values()):
            yield dict(zip(self.levels, values, strict=True))

    def protocol(self, rig: Rig, amplitudes: Mapping[str, float]) -> Protocol:
        episodes = tuple(self.make(rig, **amplitudes))
        return Protocol(self.name, episodes, rig.pause, (self.name, *[""] * (len(episodes) - 1)))


def _growing(rig: Rig, depth: float, time: float) -> list[Episode]:
    peaks = [part * depth * rig.depth for part in (0.25, 0.5, 0.75, 1.0, 0.5)]
    strokes = [s for peak in peaks for s in (rig.go(0.0, peak, peak / time), rig.go(peak, 0.0, peak / time))]
    return [(rig.air(), *strokes, rig.air(1.0))]


def _triangles(rig: Rig, depth: float, frequency: float) -> list[Episode]:
    peak = depth * rig.depth
    pace = 2.0 * peak * frequency
    cycles = min(max(round(8.0 * frequency), 2), 20)
    return [(rig.air(), *(rig.go(0.0, peak, pace), rig.go(peak, 0.0, pace)) * cycles, rig.air(1.0))]


def _speeds(rig: Rig, depth: float) -> list[Episode]:
    peak = depth * rig.depth
    paces = [min(rig.speed, pace * peak) for pace in (0.1, 1.0, 10.0)]
    return [rig.press(peak, speed=pace) for pace in paces]


def _sines(rig: Rig, depth: float, frequency: float) -> list[Episode]:
    middle = 0.8 * depth * rig.depth
    frequency = min(frequency, rig.rate / FINEST)
    amplitude = min(0.2 * middle, rig.speed / (6.3 * frequency))
    wave = Segment(max(round(5.0 * frequency), 5) / frequency, amplitude=amplitude, frequency=frequency)
    return [rig.press(middle, Segment(1.0), wave)]


def _reversals(rig: Rig, depth: float, stroke: float) -> list[Episode]:
    middle, half = depth * rig.depth, stroke * depth * rig.depth
    waves = [
        Segment(n / f, amplitude=min(half, rig.speed / (6.3 * f)), frequency=f)
        for f, n in ((0.2, 2), (5.0, 20))
    ]
    return [rig.press(middle - half, Segment(2.0), *waves)]


def _stairs(rig: Rig, depth: float, time: float) -> list[Episode]:
    levels = [depth * rig.depth * part for part in (0.2, 0.4, 0.6, 0.8, 1.0, 0.8, 0.6, 0.4, 0.2)]
    up = [s for a, b in itertools.pairwise([0.0, *levels]) for s in (rig.go(a, b), Segment(time))]
    return [(rig.air(), *up, rig.go(levels[-1], -CLEARANCE_SHARE * rig.depth), rig.air(1.0))]


def _touches(rig: Rig, depth: float, time: float) -> list[Episode]:
    light = rig.press(0.15 * rig.depth, Segment(0.5), speed=rig.depth)
    return [light, rig.press(depth * rig.depth, Segment(time)), light]


def _strokes(rig: Rig, depth: float) -> list[Episode]:
    far = -2.0 * depth * rig.depth
    near = -CLEARANCE_SHARE * rig.depth
    there_and_back = (rig.go(near, far), rig.go(far, near))
    return [(rig.air(), *there_and_back * 10, rig.air())]


def pull_until_slip(rig: Rig, depth: float, wait: float, share: float = 1.0, spin: float = 0.0) -> Episode:
    """Press, wait, move until well after slip; ``share`` of the usual speed."""
    peak = depth * rig.depth
    pull = 2.0 * rig.friction * peak * share
    move = Segment(0.5 * SLID / share, pull_x=0.0 if spin else pull, spin=spin * share)
    return rig.press(peak, Segment(wait), move, Segment(0.2))


def slow_slide(rig: Rig, depth: float, speed: float) -> Episode:
    """Return a pull with ``speed`` [m/s] at most, at a share ``depth`` of the greatest one; twice as far."""
    usual = 2.0 * rig.friction * depth * rig.depth
    air, press, wait, move, *rest = pull_until_slip(rig, depth, 0.5, min(speed / usual, 1.0))
    return (air, press, wait, replace(move, duration=2.0 * move.duration), *rest)


def _twists(rig: Rig, depth: float, time: float) -> list[Episode]:
    turn = 2.0  # [rad/s]
    return [
        pull_until_slip(rig, part * depth, wait, spin=turn) for part in (0.5, 1.0) for wait in (0.2, time)
    ] + [pull_until_slip(rig, part * depth, 0.5) for part in (0.5, 1.0)]


def _directions(rig: Rig, depth: float) -> list[Episode]:
    peak = depth * rig.depth
    pull, lasts = 2.0 * rig.friction * peak, 0.5 * SLID
    ways = ((pull, 0.0), (-pull, 0.0), (0.0, pull), (0.0, -pull))
    return [rig.press(peak, Segment(0.5), Segment(lasts, pull_x=x, pull_y=y)) for x, y in ways]


DEPTH_SHARES = (0.5, 1.0)
MENU = (
    Item(
        "one hold",
        lambda rig, depth, time: [rig.press(depth * rig.depth, Segment(time)), (rig.air(2.0),)],
        {"depth": DEPTH_SHARES, "time": (2.0, 10.0, 40.0)},
    ),
    Item(
        "holds at three depths",
        lambda rig, depth, time: [
            rig.press(part * depth * rig.depth, Segment(time)) for part in (0.35, 0.65, 1.0)
        ],
        {"depth": DEPTH_SHARES, "time": (2.0, 8.0)},
    ),
    Item("growing peaks, then a small one", _growing, {"depth": DEPTH_SHARES, "time": (0.2, 1.0, 4.0)}),
    Item("triangles", _triangles, {"depth": DEPTH_SHARES, "frequency": (0.2, 2.0)}),
    Item("presses over two decades of speed", _speeds, {"depth": DEPTH_SHARES}),
    Item("small sines", _sines, {"depth": DEPTH_SHARES, "frequency": (2.0, 8.0, 20.0)}),
    Item("small reversals, slow and fast", _reversals, {"depth": DEPTH_SHARES, "stroke": (0.03, 0.15)}),
    Item(
        "slow ramp",
        lambda rig, depth, time: [rig.press(depth * rig.depth, speed=depth * rig.depth / time)],
        {"depth": DEPTH_SHARES, "time": (5.0, 20.0)},
    ),
    Item("stairs", _stairs, {"depth": DEPTH_SHARES, "time": (0.5, 2.0)}),
    Item(
        "taps and pull-offs at three speeds",
        lambda rig, depth: [
            rig.press(depth * rig.depth, Segment(0.2), speed=pace * (depth * rig.depth))
            for pace in (0.5, 2.0, 8.0)
        ],
        {"depth": (0.15, 0.4)},
    ),
    Item("light touch before and after a deep press", _touches, {"depth": DEPTH_SHARES, "time": (0.5, 5.0)}),
    Item("strokes in air", _strokes, {"depth": (1.0,)}),
    Item(
        "pulls at four loads",
        lambda rig, depth, time: [pull_until_slip(rig, part * depth, time) for part in (0.3, 0.5, 0.75, 1.0)],
        {"depth": DEPTH_SHARES, "time": (0.5,)},
        has_tangential_load=True,
    ),
    Item(
        "pulls after short and long waits",
        lambda rig, depth, time: [
            pull_until_slip(rig, depth, wait) for wait in (0.1, 0.1 * time, time, 0.1, time)
        ],
        {"depth": DEPTH_SHARES, "time": (3.0, 10.0)},
        has_tangential_load=True,
    ),
    Item(
        "slides at four speeds",
        lambda rig, depth: [pull_until_slip(rig, depth, 0.5, share) for share in (0.1, 0.4, 1.6, 6.4)],
        {"depth": DEPTH_SHARES},
        has_tangential_load=True,
    ),
    Item(
        "twists and pulls after two waits",
        _twists,
        {"depth": DEPTH_SHARES, "time": (3.0,)},
        has_tangential_load=True,
    ),
    Item("pulls in four directions", _directions, {"depth": DEPTH_SHARES}, has_tangential_load=True),
)
"""Experiments that are tried, and their first amplitudes."""
