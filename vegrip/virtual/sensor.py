"""The sensors of the fingertips: noise, bias, resolution, lost and jittered samples."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from vegrip.clock import NS
from vegrip.messages import NAN, FingertipState
from vegrip.types import Floats
from vegrip.virtual import kernels
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
SLIP_SPEED = SENSED_CHANNELS.index("slip_speed")


@dataclass(frozen=True, slots=True)
class Reading:
    """The true quantities of all fingers at one instant."""

    values: Floats  # (n, 8) in the order of SENSED_CHANNELS
    slip: Floats  # (n,) 1 sliding, 0 not


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
        steps = [s.force_step, s.force_step, s.force_step, s.torque_step, s.displacement_step, 0.0, 0.0, 0.0]
        self._step = np.array(steps)
        self._present = np.array([1.0] * 6 + [float(s.slip_sensor), float(s.radius_sensor)])
        spread = np.array([force, force, force, 0.0, shift, 0.0, 0.0, 0.0])
        self.bias = spread * rng.standard_normal((len(fingers), len(SENSED_CHANNELS)))
        self._slips: deque[Floats] = deque(maxlen=round(s.slip_delay * s.rate) + 1)  # flag, speed [m/s]
        self._seq = 0

    def measure(self, reading: Reading, time: float, epoch: int = 0) -> list[FingertipState]:
        """Return what the hand reports at ``time`` [s] after ``epoch`` [ns].

        Lost samples are missing and their sequence numbers are used up.
        """
        s, n = self.settings, len(self.fingers)
        errors, chance, shifts = self.draw()
        felt = self._felt(reading)
        values = kernels.sense(_with_speed(reading.values, felt[:, 1]), errors, self._step, self._present)
        slip = felt[:, 0] if s.slip_sensor else np.full(n, NAN)
        lost = (chance < s.dropout).tolist() if s.dropout > 0.0 else [False] * n
        stamps = [epoch + round((time + s.jitter * shift) * NS) for shift in shifts.tolist()]
        self._seq += 1
        rows = zip(stamps, self.fingers, values.tolist(), slip.tolist(), lost, strict=True)
        return [
            FingertipState(stamp, finger, self._seq, N, fx, fy, m, d, T, slipping, speed, a)
            for stamp, finger, (N, fx, fy, m, d, T, speed, a), slipping, missing in rows
            if not missing
        ]

    def draw(self) -> tuple[Floats, Floats, Floats]:
        """Draw the errors of one sample: bias with noise (n, 8), chance of loss (n,), shift in time (n,)."""
        rng, n = self._rng, len(self.fingers)
        errors = self.bias + self._noise * rng.standard_normal((n, len(SENSED_CHANNELS)))
        return errors, rng.random(n), rng.standard_normal(n)

    def _felt(self, reading: Reading) -> Floats:
        """Return slip flag and slip speed [m/s] as they are felt: from a threshold on, and late; (n, 2)."""
        self._slips.appendleft(kernels.slips_felt(reading.values, reading.slip, self.settings.slip_threshold))
        return self._slips[-1] if len(self._slips) == self._slips.maxlen else np.zeros((len(self.fingers), 2))


def _with_speed(values: Floats, speed: Floats) -> Floats:
    """Return true ``values`` (n, 8) with another slip ``speed`` [m/s]."""
    out = values.copy()
    out[:, SLIP_SPEED] = speed
    return out
