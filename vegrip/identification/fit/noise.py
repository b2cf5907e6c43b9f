"""How well the sensors of a recording measure: as stated, checked on replicates or in air, else from signals.

Noise that is white stands out in differences of neighbouring samples, where motion and contact hardly show:
the third difference of white noise has the variance ``20 sigma^2``.
"""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from vegrip.identification.fit.ou_noise import OuNoise, estimate_ou_noise
from vegrip.identification.fit.replicates import find_pairs, noise_of_pairs
from vegrip.identification.fit.whitening import ForceNoise
from vegrip.identification.recording import Recording
from vegrip.identification.recording.channels import noise_name
from vegrip.types import Floats

SERVED = ("normal_force", "displacement", "tangential_force_x", "torque_z", "contact_radius")
LEAST_AIR = 100  # rows in air from which their scatter is believed
ABOUT = 5  # samples to either side of one that is at rest
STATED = "stated by the recording"
NEIGHBOURS = "differences of neighbouring samples"
SAME_VALUE = 1e-9  # of the range: values that differ by less are the same number, converted
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
    tolerance: float = 0.0  # share of an episode's peak force by which a model may be wrong
    source: Mapping[str, str] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()

    def of_force(self, force: Floats, episode: np.ndarray) -> ForceNoise:
        """Return what the whitening needs for the measured ``force`` (n,) [N]; NaN counts as none."""
        peaks = np.zeros(int(episode.max()) + 1)
        np.maximum.at(peaks, episode, np.abs(np.nan_to_num(force)))
        white = np.hypot(self.normal_force, self.tolerance * peaks[episode])
        return ForceNoise(white, self.slow_force, self.slow_time)

    def tolerant(self, tolerance: float) -> "Noise":
        """Return the same noise, for a model that may be wrong by ``tolerance`` of the peak force."""
        return dataclasses.replace(self, tolerance=tolerance)


def noise_of(recording: Recording) -> Noise:
    """Return the noise of ``recording``: as it is stated, else from differences of neighbouring samples.

    The force is checked, and its slow wandering found, where nothing but noise acts: in the differences of
    replicate episodes if there are some, else at rest in air.
    """
    values: dict[str, float] = {}
    source: dict[str, str] = {}
    for channel in SERVED:
        if channel not in recording.columns:
            continue
        name, column = noise_name(channel), recording.columns[channel]
        stated = recording.sensors.get(name, math.nan)
        if stated > 0.0:
            values[name], source[name] = stated, STATED
        else:
            values[name], source[name] = rough(column, recording.episode), NEIGHBOURS
    doubts: list[str] = []
    found, where = _seen(recording, values)
    if found is not None:
        white = max(found.white, rounding(recording.columns["normal_force"]))
        ratio = white / values["normal_force"]
        if source["normal_force"] == NEIGHBOURS or not 1.0 / DISAGREE < ratio < DISAGREE:
            if source["normal_force"] == STATED:
                doubts.append(
                    f"the force scatters by {white:.3g} N ({where}), but its noise is stated as "
                    f"{values['normal_force']:.3g} N; the measured one is used"
                )
            values["normal_force"], source["normal_force"] = white, where
        source["slow_force"] = where if found.slow > 0.0 else f"none seen ({where})"
        if found.beyond:
            source["slow_force"] = "not believed"
            doubts.append(
                f"the force wanders by far more than noise ({where}): a zero that shifts, or what is left of "
                "a contact; it is not counted as noise"
            )
    return Noise(
        values.get("normal_force", math.nan),
        values.get("displacement", 0.0),
        values.get("tangential_force", math.nan),
        values.get("torque_z", math.nan),
        values.get("contact_radius", math.nan),
        found.slow if found is not None else 0.0,
        found.time if found is not None else 2.0,
        source=source,
        doubts=tuple(doubts),
    )


def _seen(recording: Recording, known: Mapping[str, float]) -> tuple[OuNoise | None, str]:
    """Return the noise of the force where nothing but noise acts, and where that was."""
    if not {"normal_force", "displacement"} <= set(recording.columns):
        return None, ""
    white = known["normal_force"]
    if not white > 0.0:
        return None, ""
    same = find_pairs(recording, known["displacement"])
    if same:
        plural = "s" if len(same) > 1 else ""
        return noise_of_pairs(recording, same, white), f"{len(same)} pair{plural} of replicate episodes"
    air = in_air(recording)
    rest = at_rest(recording, air, known["displacement"])
    if np.count_nonzero(rest) < LEAST_AIR:
        if np.count_nonzero(air) < LEAST_AIR:
            return None, ""
        scatter = rough(recording.columns["normal_force"][air], recording.episode[air])
        return OuNoise(scatter, 0.0, 2.0, 0.0), "scatter in air"
    t = recording.t
    y = np.where(rest, recording.columns["normal_force"], np.nan)
    first = np.r_[1.0, np.zeros(t.size - 1)]
    drift = (t - t.mean()) / max(t[-1] - t[0], 1e-300)
    guess = rough(recording.columns["normal_force"][rest], recording.episode[rest])
    return estimate_ou_noise(t, first, y, np.column_stack([np.ones(t.size), drift]), guess), "scatter in air"


def at_rest(recording: Recording, rows: np.ndarray, noise: float) -> np.ndarray:
    """Return those of ``rows`` (n,) about which the displacement stays within its ``noise`` [m]."""
    depth = recording.columns["displacement"]
    n = depth.size
    out = np.zeros(n, dtype=bool)
    middle = slice(ABOUT, n - ABOUT)
    moved = np.abs(depth[2 * ABOUT :] - depth[: -2 * ABOUT])
    same = recording.episode[2 * ABOUT :] == recording.episode[: -2 * ABOUT]
    calm = rows[middle] & rows[2 * ABOUT :] & rows[: -2 * ABOUT]
    out[middle] = calm & same & (moved <= 6.0 * noise)
    return out


def rough(values: Floats, episode: Floats | np.ndarray) -> float:
    """Return the std of the white part of ``values`` (n,), at least what rounding to their steps leaves."""
    jumps = np.diff(values, 3)[np.asarray(episode[3:] == episode[:-3])]
    jumps = jumps[np.isfinite(jumps)]
    if jumps.size < 8:
        return math.nan
    middle = float(np.median(np.abs(jumps))) / 0.6745 / math.sqrt(20.0)
    return max(middle, rounding(values), 1e-12)


def rounding(values: Floats) -> float:
    """Return the std of what rounding to the smallest step of ``values`` leaves, 0 where there is no step."""
    known = np.unique(values[np.isfinite(values)])
    steps = np.diff(known)
    steps = steps[steps > SAME_VALUE * np.ptp(known)] if steps.size else steps
    return float(steps.min()) / math.sqrt(12.0) if steps.size else 0.0


def in_air(recording: Recording) -> np.ndarray:
    """Return the rows (n,) in which the tip is clear of the surface, as far as the displacement tells."""
    depth = recording.columns.get("displacement")
    if depth is None:
        return np.zeros(len(recording), dtype=bool)
    clear = 5.0 * recording.sensors.get("displacement", 0.0)
    if np.isfinite(recording.fingertip.radius):
        clear = max(clear, 2e-3 * recording.fingertip.radius)
    return np.asarray(depth < -clear)
