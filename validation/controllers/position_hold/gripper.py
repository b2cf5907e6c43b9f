"""A gripper that moves while it closes, and stands still otherwise: a self-locking drive, or a brake.

Both pads are alike and carry half the load each, so one of them stands for both.
"""

import math
from collections.abc import Callable

import numpy as np

from validation.controllers.position_hold.pad import Pad, PressedPad
from validation.controllers.position_hold.scenario import LIFT_END_S, LIFT_START_S, Load
from vegrip.clock import NS
from vegrip.messages import FingertipState

MOVING_PERIOD_S, STANDING_PERIOD_S = 0.004, 0.05  # of the samples
SPEED = 15e-3  # [m/s] of closing, of each pad
DEEPEST = 0.5  # of the radius: the end of the travel
FORCE_NOISE_N, DEPTH_NOISE_M = 0.01, 5e-6
TANGENTIAL_NOISE_N, TORQUE_NOISE_NM = 0.01, 1e-4
NOISE_BLOCK = 1000  # samples
AIR_S = 0.2  # [s] of samples before the pads touch


class Gripper:
    """One pad on its drive, with the sensors of vegrip's fingertips."""

    def __init__(self, pad: Pad, rng: np.random.Generator) -> None:
        self.pad, self._samples = pad, 0
        self._rng, self._noise = rng, [[0.0]]
        self.time = 0.0  # [s]
        self.pressed = PressedPad(pad)
        self.load: Load | None = None
        self.closed_at = math.inf  # [s]
        self.tightenings = 0
        self.position = -SPEED * AIR_S  # [m] of the drive; the indentation where it is positive

    def sense(self) -> FingertipState:
        """Return what the sensors say now."""
        place = self._samples % NOISE_BLOCK
        if place == 0:
            self._noise = self._rng.standard_normal((NOISE_BLOCK, 4)).tolist()
        share, noise = self.lifted, self._noise[place]
        self._samples += 1
        f = share * self.load.tangential if self.load else 0.0
        torque = share * self.load.torque if self.load else 0.0
        return FingertipState(
            stamp=round(self.time * NS),
            finger="pad",
            seq=self._samples & 0xFF,
            normal_force=self.pressed.force + FORCE_NOISE_N * noise[0],
            displacement=self.position + DEPTH_NOISE_M * noise[1],
            tangential_force_x=f + TANGENTIAL_NOISE_N * noise[2],
            tangential_force_y=0.0,
            torque_z=torque + TORQUE_NOISE_NM * noise[3],
        )

    @property
    def lifted(self) -> float:
        """The share of the load that the pads carry [-]; the stand gives way after closing."""
        gone = (self.time - self.closed_at - LIFT_START_S) / (LIFT_END_S - LIFT_START_S)
        return min(max(gone, 0.0), 1.0)

    def stand(self) -> None:
        """Let one period pass, the drive standing."""
        self.pressed.press(self.pressed.depth, STANDING_PERIOD_S)
        self.time += STANDING_PERIOD_S

    def move(self, reached: Callable[[float, float], bool]) -> bool:
        """Close for one period at most; return whether ``reached`` (depth [m], force [N]) stopped it."""
        before = max(self.position, 0.0)
        self.position = min(self.position + SPEED * MOVING_PERIOD_S, DEEPEST * self.pad.radius)
        depth = max(self.position, 0.0)

        def met(part: float) -> bool:
            there = before + part * (depth - before)
            return reached(there, self.pressed.force_after(there, MOVING_PERIOD_S))

        stopped = met(1.0)
        if stopped:
            low, high = 0.0, 1.0
            for _ in range(14):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if met(middle) else (middle, high)
            depth = before + high * (depth - before)
            self.position = depth
        self.pressed.press(depth, MOVING_PERIOD_S)
        self.time += MOVING_PERIOD_S
        return stopped or self.position >= DEEPEST * self.pad.radius

    def open(self, pause: float) -> None:
        """Let go, and wait until the pads have recovered."""
        self.pressed = PressedPad(self.pad)
        self.time += pause
        self.position = -SPEED * AIR_S
        self.load, self.closed_at, self.tightenings = None, math.inf, 0
