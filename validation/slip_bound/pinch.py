"""Two fingers pinch an object: who carries how much of its weight, and how far it slides. Quasi-static.

Finger i is a bristle of stiffness k_i that slides where it would carry more than friction allows::

    T_i = min(k_i (x - q_i), mu_i(N) N),      T_1 + T_2 = W,      k_i = share_i k

with the object at x and the foot of the bristle at q_i: what one finger cannot carry the other takes. Where
both together cannot, the object slides: by ``CREEP``, if only the forces matter, or by
``m x'' = W - sum T_i``.
Nothing here is taken from vegrip.
"""

import math
from dataclasses import dataclass, field

from validation.slip_bound.worlds import Grasp

STIFFNESS = 4000.0  # [N/m] k of both bristles
CREEP = (
    5e-3  # [m/s] with which an object slides whose forces are set: a slow slide, as was seen of [Burke2023]_
)
GRAVITY = 9.81  # [m/s^2]


@dataclass
class Pinch:
    """The state of a grasp."""

    grasp: Grasp
    falls: bool = False  # a slide is one of a mass, and does not creep
    x: float = 0.0  # [m] of the object, downwards
    speed: float = 0.0  # [m/s] while the object slides
    slid: float = 0.0  # [m] that the object has slid on both fingers
    feet: list[float] = field(default_factory=lambda: [0.0, 0.0])  # [m] q of each finger
    pulls: tuple[float, float] = (0.0, 0.0)  # [N] true tangential forces
    slips: tuple[float, float] = (0.0, 0.0)  # [m/s] with which each finger slides

    def step(self, dt: float, force: float, weight: float) -> None:
        """Go on by ``dt`` [s] to a normal force [N] and a weight [N]."""
        limits = self.grasp.limits(force)
        spare = sum(limits) - weight
        if force <= 0.0 or (spare >= 0.0 and (self.speed <= 0.0 or not self.falls)):
            self.speed = 0.0
            self._hold(dt, limits, weight)
            return
        if self.falls:
            self.speed = max(self.speed - spare * GRAVITY / max(self.grasp.weight, 1e-9) * dt, 0.0)
        else:
            self.speed = CREEP
        self.x = max(self.x, *(foot + most / k for foot, most, k in self._rows(limits)))
        self.x += self.speed * dt
        self.slid += self.speed * dt
        self.feet = [self.x - most / k for _, most, k in self._rows(limits)]
        self.pulls, self.slips = limits, (self.speed, self.speed)

    def margins(self, force: float) -> tuple[float, float]:
        """Return the true margin of each finger: 0 when it slides."""
        limits = self.grasp.limits(force)
        one, other = (
            max(1.0 - pull / most, 0.0) if most > 0.0 else math.nan
            for pull, most in zip(self.pulls, limits, strict=True)
        )
        return one, other

    def _rows(self, limits: tuple[float, float]) -> list[tuple[float, float, float]]:
        """Return foot [m], limit [N] and stiffness [N/m] of each finger."""
        share = self.grasp.share
        stiffness = (share * STIFFNESS, (1.0 - share) * STIFFNESS)
        return list(zip(self.feet, limits, stiffness, strict=True))

    def _hold(self, dt: float, limits: tuple[float, float], weight: float) -> None:
        (foot, most, k), (foot2, most2, k2) = self._rows(limits)
        if weight <= 0.0:
            self.pulls = self.slips = 0.0, 0.0
            return
        x = (weight + k * foot + k2 * foot2) / (k + k2)
        if k * (x - foot) > most:  # the other takes the rest
            x = foot2 + (weight - most) / k2
        elif k2 * (x - foot2) > most2:
            x = foot + (weight - most2) / k
        before = self.feet
        self.feet = [max(foot, x - most / k), max(foot2, x - most2 / k2)]
        self.pulls = k * (x - self.feet[0]), k2 * (x - self.feet[1])
        one, other = ((after - was) / dt for after, was in zip(self.feet, before, strict=True))
        self.slips, self.x = (one, other), x
