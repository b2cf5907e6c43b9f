"""What happens to a held object: disturbances as data, so that several controllers meet the same ones.

Every disturbance starts and ends smoothly; :func:`total` adds up what acts at a time.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from vegrip.types import Floats


@dataclass(frozen=True, slots=True)
class Burden:
    """What acts on the object besides its own weight."""

    force_x: float = 0.0  # [N] in the hand's frame
    force_y: float = 0.0  # [N]
    torque: float = 0.0  # [N m] about the face normal
    mass: float = 0.0  # [kg] added
    turn: float = 0.0  # [rad] of the hand against gravity, about the face normal
    friction: float = 1.0  # [-] factor on every friction coefficient

    def __add__(self, other: "Burden") -> "Burden":
        return Burden(
            self.force_x + other.force_x,
            self.force_y + other.force_y,
            self.torque + other.torque,
            self.mass + other.mass,
            self.turn + other.turn,
            self.friction * other.friction,
        )


NO_BURDEN = Burden()


@dataclass(frozen=True)
class Disturbance:
    """Something that acts from ``start`` for ``duration`` [s]."""

    start: float
    duration: float

    def burden(self, time: float) -> Burden:
        """Return what acts at ``time`` [s]."""
        inside = self.start < time < self.start + self.duration
        return self.acting((time - self.start) / self.duration) if inside else NO_BURDEN

    def acting(self, part: float) -> Burden:
        """Return what acts after ``part`` = 0..1 of the duration."""
        raise NotImplementedError


@dataclass(frozen=True)
class Push(Disturbance):
    """A half-sine pulse of force."""

    force_x: float  # [N] at the peak
    force_y: float  # [N]

    def acting(self, part: float) -> Burden:
        height = math.sin(math.pi * part)
        return Burden(force_x=height * self.force_x, force_y=height * self.force_y)


@dataclass(frozen=True)
class Twist(Disturbance):
    """A half-sine pulse of torque about the face normal."""

    torque: float  # [N m] at the peak

    def acting(self, part: float) -> Burden:
        return Burden(torque=self.torque * math.sin(math.pi * part))


@dataclass(frozen=True)
class SlowLoad(Disturbance):
    """A force that grows evenly over the first 80 % of the duration and then fades."""

    force_x: float  # [N] at the peak
    force_y: float  # [N]

    def acting(self, part: float) -> Burden:
        height = min(part / 0.8, (1.0 - part) / 0.2)
        return Burden(force_x=height * self.force_x, force_y=height * self.force_y)


@dataclass(frozen=True)
class Shake(Disturbance):
    """The hand is shaken: a sinusoidal acceleration of the object against the hand."""

    force: float  # [N] amplitude
    frequency: float  # [Hz]
    direction: float  # [rad] from the x axis

    def acting(self, part: float) -> Burden:
        wave = math.sin(math.pi * part) * math.sin(2.0 * math.pi * self.frequency * part * self.duration)
        force = self.force * wave
        return Burden(force_x=force * math.cos(self.direction), force_y=force * math.sin(self.direction))


@dataclass(frozen=True)
class AddedMass(Disturbance):
    """Something is poured in or put on, and taken away at the end."""

    mass: float  # [kg]

    def acting(self, part: float) -> Burden:
        return Burden(mass=self.mass * plateau(part))


@dataclass(frozen=True)
class Turn(Disturbance):
    """The hand is turned about the face normal, stays, and is turned back."""

    angle: float  # [rad]

    def acting(self, part: float) -> Burden:
        return Burden(turn=self.angle * plateau(part))


@dataclass(frozen=True)
class Wetting(Disturbance):
    """The faces get wet or greasy: less friction for a while."""

    friction: float  # [-] factor

    def acting(self, part: float) -> Burden:
        return Burden(friction=1.0 - (1.0 - self.friction) * plateau(part))


def plateau(part: float, edge: float = 0.15) -> float:
    """Return 0..1..0 for part = 0..1, with smooth flanks of ``edge`` each."""
    rise = min(1.0, part / edge, (1.0 - part) / edge)
    return rise * rise * (3.0 - 2.0 * rise)


def total(events: Iterable[Disturbance], time: float) -> Burden:
    """Return all that acts at ``time`` [s]."""
    burden = NO_BURDEN
    for event in events:
        if event.start < time < event.start + event.duration:
            burden = burden + event.burden(time)
    return burden


def burden_rows(events: Iterable[Disturbance], times: Floats) -> Floats:
    """Return what acts at the times [s], which grow; (n, 6).

    Columns: force x, y [N], torque [N m], mass [kg], turn [rad], factor of friction [-].
    """
    rows = np.zeros((len(times), 6))
    rows[:, 5] = 1.0
    first, last = float(times[0]), float(times[-1])
    near = [event for event in events if event.start < last and first < event.start + event.duration]
    for i, time in enumerate(times.tolist() if near else ()):
        b = total(near, time)
        if b is not NO_BURDEN:
            rows[i] = b.force_x, b.force_y, b.torque, b.mass, b.turn, b.friction
    return rows


def disturbances(
    seed: int, duration: float, *, start: float = 2.0, weight: float = 3.0, pause: float = 1.5
) -> tuple[Disturbance, ...]:
    """Draw a schedule that is the same for every controller.

    Args:
        seed: of the schedule.
        duration: [s] nothing goes on after this.
        start: [s] nothing happens before.
        weight: [N] of the object; forces are multiples of it.
        pause: [s] mean time between two events; they may overlap.

    """
    rng = np.random.default_rng(seed)
    events: list[Disturbance] = []
    time = start
    while (time := time + float(rng.uniform(0.4, 1.6)) * pause) < duration - 0.5:
        event = _draw(rng, time, weight)
        if time + event.duration < duration:
            events.append(event)
    return tuple(events)


def _draw(rng: np.random.Generator, start: float, weight: float) -> Disturbance:
    kind = rng.integers(6)
    size, angle = float(rng.uniform(0.3, 1.0)), float(rng.uniform(0.0, 2.0 * math.pi))
    x, y = size * weight * math.cos(angle), size * weight * math.sin(angle)
    if kind == 0:
        return Push(start, float(rng.uniform(0.1, 0.5)), x, y)
    if kind == 1:
        return Twist(start, float(rng.uniform(0.2, 0.8)), 0.025 * weight * size * math.copysign(1.0, x))
    if kind == 2:
        return SlowLoad(start, float(rng.uniform(1.5, 4.0)), x, y)
    if kind == 3:
        return Shake(start, float(rng.uniform(1.0, 3.0)), 0.6 * size * weight, 1.0 + 4.0 * size, angle)
    if kind == 4:
        return AddedMass(start, float(rng.uniform(2.0, 5.0)), 0.8 * size * weight / 9.81)
    return Turn(start, float(rng.uniform(2.0, 5.0)), 1.5 * size * math.copysign(1.0, x))
