"""The controller of a grasp, and what its fingers send to it."""

from dataclasses import replace
from typing import Final

import numpy as np

import vegrip
from validation.slip_bound.pinch import Pinch
from vegrip import GripController
from vegrip.grip.settings import ControlSettings

FINGERS: Final = ("thumb", "index")
TIP_RADIUS: Final = 9e-3  # [m]
RATE: Final = 200  # [Hz]
NS_PER_SAMPLE: Final = 1_000_000_000 // RATE
NOISE: Final = 0.01  # [N] std of each component of the force
THRESHOLD, DELAY_SAMPLES, SPEED_NOISE = 1e-4, 4, 5e-5
"""Of a sound slip channel: [m/s] from which it says slip; by which it is late; [m/s] std of its speed."""
STRONGEST: Final = 80.0  # [N] no limit hides what is commanded
CONFIDENCES: Final = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)

NORMAL, ALONG, ACROSS, SLIP, SLIP_SPEED = 0, 1, 2, 6, 7
CHANNELS = 9
"""Places in a state of a finger, and how many channels it has."""


def controller(*, feels_slip: bool) -> GripController:
    """Return a controller with the default settings, told of the slip channel where there is one."""
    plain = ControlSettings()
    friction = plain.friction
    if feels_slip:
        friction = replace(friction, learning=True, slip_threshold=THRESHOLD, slip_delay=DELAY_SAMPLES / RATE)
    settings = replace(plain, friction=friction, limits=replace(plain.limits, max_force=STRONGEST))
    return GripController(FINGERS, model=vegrip.paper_model(TIP_RADIUS), settings=settings)


class Hand:
    """Sends what two fingers measure of a pinch, with a sound slip channel where one ``feels_slip``."""

    def __init__(self, grip: GripController, pinch: Pinch, samples: int, *, feels_slip: bool) -> None:
        grip.reset()
        self.grip, self._pinch, self._feels = grip, pinch, feels_slip
        rng = np.random.default_rng([pinch.grasp.seed, 52])
        self._noise = rng.standard_normal((samples, len(FINGERS), 4))
        self._noise *= [NOISE, NOISE, NOISE, SPEED_NOISE]
        self._values = np.full((len(FINGERS), CHANNELS), np.nan)
        self._felt: list[tuple[float, float]] = [(0.0, 0.0)] * (DELAY_SAMPLES + 1)  # [m/s], the latest last

    def send(self, k: int, force: float) -> int:
        """Send sample ``k``, at a normal force [N] of each finger; return its time [ns]."""
        pinch, values, now = self._pinch, self._values, (k + 1) * NS_PER_SAMPLE
        gain = pinch.grasp.gain
        self._felt = [*self._felt[1:], pinch.slips]
        for i, finger in enumerate(self.grip.fingers.values()):
            noise, row = self._noise[k, i], values[i]
            row[NORMAL], row[ALONG] = force + noise[0], gain * pinch.pulls[i] + noise[1]
            row[ACROSS] = noise[2]
            if self._feels:
                speed = self._felt[0][i]
                row[SLIP], row[SLIP_SPEED] = float(speed >= THRESHOLD), speed + noise[3]
            finger.answer_values(row, k, now, now)
        return now
