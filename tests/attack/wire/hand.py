"""A pinch of two soft fingertips that hold a load, as simple as it can be: no code of vegrip's own hand."""

import math
from random import Random

from wires import FINGERS, Command

STIFFNESS = 4.0 / 3.0 * 3e5 * math.sqrt(9e-3)  # [N/m^1.5] Hertz, of the tip that the node is told of
RELAXING, TIME_CONSTANT = 0.25, 0.5  # [-], [s] share of the elastic force that relaxes
LOAD = 0.5  # [N] on each finger
FRICTION = 0.9
INITIAL_FORCE = 3.0  # [N] the hand holds by itself, until it is told otherwise
LAG = 0.02  # [s] of the drives
CLOSED, LIFTED = 0.5, 1.0  # [s]


class Tip:
    """One fingertip."""

    def __init__(self) -> None:
        self.wanted = INITIAL_FORCE  # [N]
        self.force = 0.0  # [N]
        self._relaxed = 0.0  # [N]
        self.slipped = 0  # steps

    def advance(self, time: float, dt: float) -> None:
        target = self.wanted * min(time / CLOSED, 1.0)
        self.force += (target - self.force) * dt / LAG
        elastic = self.force + RELAXING * self._relaxed
        self._relaxed += (elastic - self._relaxed) * dt / TIME_CONSTANT
        self.indentation = (max(elastic, 0.0) / STIFFNESS) ** (2.0 / 3.0)
        self.load = LOAD * min(max((time - CLOSED) / (LIFTED - CLOSED), 0.0), 1.0)
        self.slips = self.load > FRICTION * self.force
        self.slipped += self.slips


class Hand:
    """Both fingers, and what their sensors say."""

    def __init__(self) -> None:
        self.tips = [Tip() for _ in FINGERS]
        self._noise = Random(1)

    def advance(self, time: float, dt: float) -> None:
        for tip in self.tips:
            tip.advance(time, dt)

    def obey(self, command: Command) -> None:
        self.tips[command.finger].wanted = command.force

    def sensed(self, finger: int) -> dict[str, float]:
        tip, noise = self.tips[finger], self._noise.gauss
        return {
            "normal_force": tip.force + noise(0.0, 0.01),
            "tangential_force_x": noise(0.0, 0.01),
            "tangential_force_y": tip.load + noise(0.0, 0.01),
            "torque_z": noise(0.0, 1e-4),
            "displacement": tip.indentation + noise(0.0, 5e-6),
            "temperature": 25.0 + noise(0.0, 0.05),
            "slip": 1.0 if tip.slips else 0.0,
            "slip_speed": (0.01 if tip.slips else 0.0) + noise(0.0, 5e-5),
            "contact_radius": math.nan,  # no camera in this hand
        }
