"""Lifts of a known weight as fingers read them: a simulator that shares nothing with what reads them."""

from dataclasses import dataclass, field

import numpy as np

from vegrip.identification.recording import Fingertip, Recording

EARTH = 9.81  # [m/s^2]


@dataclass(frozen=True)
class Lift:
    """One lift: open, grip, up, still, down, open."""

    mass: float  # [kg]
    shares: tuple[float, ...]  # of the weight, by finger
    later: tuple[float, ...] = ()  # shares at the end of the hold
    still: float = 3.0  # [s]
    tilt: float = 0.0  # [rad] by which the pads face up or down
    shake: float = 0.0  # [m/s^2] of the arm, at 6 Hz, while it holds


@dataclass
class Hand:
    """Fingers with gains and zeros of their own."""

    gains: tuple[float, ...]
    names: tuple[str, ...] = ("thumb", "index")
    noise: float = 0.02  # [N] of a component
    zero: float = 0.3  # [N] std of the zeros
    drift: float = 0.0  # [N/s] of a zero
    rate: float = 200.0  # [Hz]
    seed: int = 0
    grip: float = 8.0  # [N]
    air: bool = True  # the recording begins and ends with open fingers
    angles: tuple[float, ...] = field(default=())  # [rad] of down in the frame of each finger

    def record(self, *lifts: Lift) -> dict[str, Recording]:
        rng = np.random.default_rng(self.seed)
        loads, grips = map(np.concatenate, zip(*(self._loads(lift) for lift in lifts), strict=True))
        t = np.arange(len(grips)) / self.rate
        angles = self.angles or rng.uniform(-np.pi, np.pi, len(self.names))
        found = {}
        for i, name in enumerate(self.names):
            zeros = rng.normal(0.0, self.zero, 2) + np.outer(t, rng.normal(0.0, self.drift, 2))
            turn = angles[i] + 0.15 * np.sin(0.3 * t)  # the arm turns slowly
            read = self.gains[i] * loads[:, i, None] * np.column_stack([np.cos(turn), np.sin(turn)]) + zeros
            read += rng.normal(0.0, self.noise, read.shape)
            columns = {
                "normal_force": grips + rng.normal(0.0, 0.02, len(t)),
                "tangential_force_x": read[:, 0],
                "tangential_force_y": read[:, 1],
            }
            episode = np.zeros(len(t), dtype=np.int64)
            found[name] = Recording(name, t, episode, columns, Fingertip(9e-3, name))
        return found

    def _loads(self, lift: Lift) -> tuple[np.ndarray, np.ndarray]:
        """Return true tangential forces (m, fingers) and the grip force (m,)."""
        seconds = 1.0 if self.air else 0.0
        corners = np.cumsum([0.0, seconds, 0.5, 0.5, 0.4, 0.4, lift.still, 0.6, 0.3, seconds])
        _, touch, gripped, take, up, held, down, put, let, end = corners
        t = np.arange(0.0, end, 1.0 / self.rate)
        carried = np.interp(t, [gripped, take, down, put], [0.0, 1.0, 1.0, 0.0])
        speeding = np.where((t > take) & (t < up), 1.5, 0.0) + np.where((t > up) & (t < held), -1.5, 0.0)
        speeding += np.where((t > held) & (t < down), lift.shake * np.sin(2.0 * np.pi * 6.0 * t), 0.0)
        force = carried * lift.mass * (EARTH + speeding) * np.cos(lift.tilt)
        late = np.clip((t - held) / (down - held), 0.0, 1.0)[:, None]
        first, last = np.array(lift.shares), np.array(lift.later or lift.shares)
        shares = first + late * (last - first)
        grip = self.grip * np.interp(t, [touch, gripped, put, let], [0.0, 1.0, 1.0, 0.0])
        return force[:, None] * shares, grip if self.air else np.full(len(t), self.grip)
