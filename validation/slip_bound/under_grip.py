"""The same grasps under the grip: it presses as it commands, the load varies, and a slide is a slide.

The hand closes by itself to 3 N, the object is lifted at 0.6 to 1 s, and its load then varies by a third and
rises twice by half. A drive follows the command with one pole and a limit of rate.
"""

import math
from dataclasses import dataclass

import numpy as np

from validation.slip_bound.hand import RATE, Hand
from validation.slip_bound.pinch import Pinch
from validation.slip_bound.worlds import Grasp, least_force
from vegrip import GripController

CLOSED, LIFTED, ENDS = 0.6, 1.0, 8.0  # [s]
START_FORCE = 3.0  # [N]
BANDWIDTH, DRIVE_RATE = 12.0, 60.0  # [Hz], [N/s] of the drives
SUBSTEPS = 5
SLIDE, DROP = 1e-4, 0.02  # [m] from which on it counts as a slide, and as lost


@dataclass(frozen=True)
class Held:
    """What came of a grasp under the grip."""

    slid: float  # [m] of the object
    force_over_least: float  # means, from the lift on

    @property
    def slides(self) -> bool:
        return self.slid > SLIDE

    @property
    def is_dropped(self) -> bool:
        return self.slid > DROP


def load_course(grasp: Grasp) -> list[float]:
    """Return the load [N] at every sample."""
    rng = np.random.default_rng([grasp.seed, 53])
    t = np.arange(round(ENDS * RATE)) / RATE
    course = 1.0 + 0.3 * np.sin(2.0 * math.pi * (rng.uniform(0.1, 0.8) * t + rng.uniform()))
    for start in rng.uniform((2.0, 5.0), (4.0, 7.0)):
        up = np.clip((t - start) / rng.uniform(0.03, 0.1), 0.0, 1.0)
        course = course + 0.5 * (up - np.clip((t - start - rng.uniform(0.3, 1.0)) / 0.3, 0.0, 1.0))
    lifted = np.clip((t - CLOSED) / (LIFTED - CLOSED), 0.0, 1.0)
    loads: list[float] = (grasp.weight * lifted * course).tolist()
    return loads


def hold(grip: GripController, grasp: Grasp, *, feels_slip: bool) -> Held:
    """Hold an object until the end, or until it is lost."""
    loads = load_course(grasp)
    pinch = Pinch(grasp, falls=True)
    hand = Hand(grip, pinch, len(loads), feels_slip=feels_slip)
    force = pressed = least = 0.0
    for k, load in enumerate(loads):
        t = k / RATE
        command = START_FORCE * t / CLOSED if t < CLOSED else max(one.held for one in grip.fingers.values())
        for _ in range(SUBSTEPS):
            force = follow_command(force, command, 1.0 / (RATE * SUBSTEPS))
            pinch.step(1.0 / (RATE * SUBSTEPS), force, load)
        hand.send(k, force)
        if t > LIFTED:
            pressed += force
            least += least_force(sum(grasp.mu), grasp.exponent, load)
        if pinch.slid > DROP:
            break
    return Held(pinch.slid, pressed / least if least > 0.0 else math.nan)


def follow_command(force: float, command: float, dt: float) -> float:
    """Return the force [N] of a drive after ``dt`` [s]."""
    wish = 2.0 * math.pi * BANDWIDTH * (command - force)
    return max(force + min(max(wish, -DRIVE_RATE), DRIVE_RATE) * dt, 0.0)
