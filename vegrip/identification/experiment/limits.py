"""What the rig may do: an experiment outside of it is not proposed."""

import math
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np

from vegrip.config import build, parameter, read_toml
from vegrip.identification.fit.motion import motion_of
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.recording import Recording

DURATION = 120.0  # [s]
QUICK = 99.5  # percentile of the speed that counts as the greatest: jumps in the record are none


@dataclass(frozen=True)
class RigLimits:
    """Greatest values of an experiment; NaN = as in the recording."""

    depth: float = parameter(math.nan, unit="m", low=1e-9, high=1.0, doc="greatest indentation")
    force: float = parameter(math.nan, unit="N", low=1e-12, high=1e5, doc="greatest normal force")
    speed: float = parameter(math.nan, unit="m/s", low=1e-9, high=10.0, doc="fastest motion along the normal")
    tangential_force: float = parameter(math.nan, unit="N", low=0.0, high=1e5, doc="0 = the rig cannot pull")
    torque: float = parameter(math.nan, unit="N m", low=0.0, high=1e4, doc="0 = the rig cannot twist")
    duration: float = parameter(DURATION, unit="s", low=1.0, high=1e5, doc="of the experiment, with pauses")
    pause: float = parameter(10.0, unit="s", low=0.0, high=1e4, doc="between episodes, for recovery")


def read_limits(path: Path) -> RigLimits:
    """Read a file with keys of :class:`RigLimits`.

    Raises:
        ConfigError: not readable, or a key or value that cannot be.

    """
    return build(RigLimits, read_toml(path), str(path))


def limits_of(recording: Recording) -> RigLimits:
    """Return what was done in ``recording``: the rig can do that again."""
    columns, noise = recording.columns, noise_of(recording)
    first = np.r_[1.0, np.diff(recording.episode) != 0].astype(np.float64)
    depth = motion_of(recording.t, first, columns["displacement"].copy(), noise.displacement).displacement
    same = np.diff(recording.episode) == 0
    speed = np.abs(np.diff(depth) / np.diff(recording.t))[same]
    none = np.zeros(1)
    pull = np.hypot(*(np.nan_to_num(columns.get(f"tangential_force_{axis}", none)) for axis in "xy"))
    slides = bool(np.any(columns.get("slip", none) == 1.0))
    return RigLimits(
        float(depth.max()),
        float(np.nanmax(columns["normal_force"])),
        float(np.percentile(speed, QUICK)) if speed.size else 1e-3,
        float(pull.max()) if slides else 0.0,
        float(np.nanmax(np.abs(np.nan_to_num(columns.get("torque_z", none))))) if slides else 0.0,
    )


def completed(given: RigLimits, recorded: RigLimits) -> RigLimits:
    """Return ``given`` with what it leaves open taken from ``recorded``."""
    unknown = {f.name for f in fields(RigLimits) if math.isnan(getattr(given, f.name))}
    return replace(given, **{name: getattr(recorded, name) for name in unknown})
