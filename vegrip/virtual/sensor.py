"""The sensors of the fingertips: noise, bias, resolution, lost and jittered samples."""

import numpy as np

from vegrip.clock import NS
from vegrip.hand_sample import HandSample
from vegrip.types import Floats
from vegrip.virtual import kernels
from vegrip.virtual.kernels import CHANNEL, Records
from vegrip.virtual.settings import SensorSettings

SENSED_CHANNELS = (
    "normal_force",
    "tangential_force_x",
    "tangential_force_y",
    "torque_z",
    "displacement",
    "temperature",
    "slip_speed",
    "contact_radius",
)
"""Order of the measured quantities in the arrays of this module."""

DRAWN_AHEAD = 16  # samples; numbers drawn one after the other cost a third of those drawn sample by sample


class Sensors:
    """All sensors of one hand; every finger has its own constant bias, drawn from the seed."""

    def __init__(self, settings: SensorSettings, fingers: tuple[str, ...], rng: np.random.Generator) -> None:
        s = settings
        self.settings, self.fingers, self._rng = s, fingers, rng
        force, shift = s.force_bias, s.displacement_bias
        self._noise = np.array([
            s.normal_force, s.tangential_force, s.tangential_force, s.torque_z, s.displacement, s.temperature,
            s.slip_speed, s.contact_radius,
        ])  # fmt: skip
        self._channels = np.zeros(len(SENSED_CHANNELS), CHANNEL)
        self._channels["gain"] = [1.0, s.tangential_gain, s.tangential_gain, *[1.0] * 5]
        self._channels["step"][:5] = [s.force_step] * 3 + [s.torque_step, s.displacement_step]
        self._channels["present"] = [1.0] * 6 + [float(s.slip_sensor), float(s.radius_sensor)]
        spread = np.array([force, force, force, 0.0, shift, 0.0, 0.0, 0.0])
        n = len(fingers)
        self.bias = spread * rng.standard_normal((n, len(SENSED_CHANNELS)))
        self._felt = np.zeros((round(s.slip_delay * s.rate) + 1, n, 2))  # flag, speed [m/s], as they are felt
        self._errors = np.zeros((DRAWN_AHEAD, n, len(SENSED_CHANNELS)))
        self._chance, self._shifts = np.zeros((DRAWN_AHEAD, n)), np.zeros((DRAWN_AHEAD, n))
        self._drawn = self._seq = 0

    def sample(self, tips: Records, temperature: float, time: float, epoch: int = 0) -> HandSample:
        """Return what is sensed of the ``tips`` at ``time`` [s] after ``epoch`` [ns].

        The sequence numbers of lost samples are used up.
        """
        errors, chance, shifts = self.draw()
        values = kernels.sense(
            tips, temperature, self.settings.slip_threshold, self._felt, self._seq, errors, self._channels
        )
        s = self.settings
        stamps = np.empty(len(self.fingers), np.int64)
        stamps.fill(epoch + round(time * NS))
        if s.jitter > 0.0:
            stamps[:] = [epoch + round((time + s.jitter * shift) * NS) for shift in shifts.tolist()]
        self._seq += 1
        return HandSample(self._seq, stamps, values, chance < s.dropout)

    def draw(self) -> tuple[Floats, Floats, Floats]:
        """Draw the errors of one sample: bias with noise (n, 8), chance of loss (n,), shift in time (n,).

        They stand in these arrays only until the next ones are drawn.
        """
        i = self._drawn % DRAWN_AHEAD
        if i == 0:
            rng = self._rng
            for errors, chance, shifts in zip(self._errors, self._chance, self._shifts, strict=True):
                rng.standard_normal(out=errors)
                rng.random(out=chance)
                rng.standard_normal(out=shifts)
            self._errors *= self._noise
            self._errors += self.bias
        self._drawn += 1
        return self._errors[i], self._chance[i], self._shifts[i]
