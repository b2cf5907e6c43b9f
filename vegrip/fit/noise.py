"""How well the sensors of a recording measure: as stated, checked in air, else from the signals themselves.

Noise that is white stands out in differences of neighbouring samples, where motion and contact hardly show:
the third difference of white noise has the variance ``20 sigma^2``.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from vegrip.fit.smoother import Floats
from vegrip.fit.whitening import ForceNoise
from vegrip.recording import Recording
from vegrip.recording.channels import noise_name

SERVED = ("normal_force", "displacement", "tangential_force_x", "torque_z", "contact_radius")
LEAST_AIR = 100  # rows in air from which their scatter is believed
DISAGREE = 1.4  # stated and found noise differ by more than this factor


@dataclass(frozen=True)
class Noise:
    """Standard deviations, SI; ``source`` says of each where it comes from, ``doubts`` what disagrees."""

    normal_force: float
    displacement: float
    tangential_force: float = math.nan
    torque_z: float = math.nan
    contact_radius: float = math.nan
    slow_force: float = 0.0  # [N] wandering of the force sensor
    slow_time: float = 2.0  # [s] its time constant
    source: Mapping[str, str] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()

    @property
    def force(self) -> ForceNoise:
        """What the whitening needs."""
        return ForceNoise(self.normal_force, self.slow_force, self.slow_time)


def noise_of(recording: Recording) -> Noise:
    """Return the noise of ``recording``; what it does not state is taken from its own differences."""
    values: dict[str, float] = {}
    source: dict[str, str] = {}
    doubts: list[str] = []
    for channel in SERVED:
        if channel not in recording.columns:
            continue
        name, column = noise_name(channel), recording.columns[channel]
        stated = recording.sensors.get(name, math.nan)
        if stated > 0.0:
            values[name], source[name] = stated, "stated by the recording"
        else:
            values[name], source[name] = (
                rough(column, recording.episode),
                "differences of neighbouring samples",
            )
    air = in_air(recording)
    if "normal_force" in values and np.count_nonzero(air) >= LEAST_AIR:
        found = rough(recording.columns["normal_force"][air], recording.episode[air])
        ratio = found / values["normal_force"]
        if not 1.0 / DISAGREE < ratio < DISAGREE:
            doubts.append(
                f"the force scatters by {found:.3g} N in air, but its noise is stated as "
                f"{values['normal_force']:.3g} N; the measured one is used"
            )
            values["normal_force"], source["normal_force"] = found, "scatter in air"
    return Noise(
        values.get("normal_force", math.nan),
        values.get("displacement", 0.0),
        values.get("tangential_force", math.nan),
        values.get("torque_z", math.nan),
        values.get("contact_radius", math.nan),
        source=source,
        doubts=tuple(doubts),
    )


def rough(values: Floats, episode: Floats | np.ndarray) -> float:
    """Return the std of the white part of ``values`` (n,), at least what rounding to their steps leaves."""
    jumps = np.diff(values, 3)[np.asarray(episode[3:] == episode[:-3])]
    jumps = jumps[np.isfinite(jumps)]
    if jumps.size < 8:
        return math.nan
    middle = float(np.median(np.abs(jumps))) / 0.6745 / math.sqrt(20.0)
    steps = np.abs(np.diff(np.unique(values[np.isfinite(values)])))
    rounding = float(steps.min()) / math.sqrt(12.0) if steps.size else 0.0
    return max(middle, rounding, 1e-12)


def in_air(recording: Recording) -> np.ndarray:
    """Return the rows (n,) in which the tip is clear of the surface, as far as the displacement tells."""
    depth = recording.columns.get("displacement")
    if depth is None:
        return np.zeros(len(recording), dtype=bool)
    clear = 5.0 * recording.sensors.get("displacement", 0.0)
    if np.isfinite(recording.fingertip.radius):
        clear = max(clear, 2e-3 * recording.fingertip.radius)
    return np.asarray(depth < -clear)
