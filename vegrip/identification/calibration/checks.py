"""Checks of a trial: it shows what it is for, or a sentence says what to do when it is recorded again."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import RecordingError
from vegrip.identification.fit.noise import Noise, in_air, noise_of
from vegrip.identification.recording import Recording
from vegrip.types import Floats

FORCE_CHANNELS = ("normal_force", "tangential_force_x", "tangential_force_y", "torque_z")
LEAST_ROWS = 20  # in the air, from which a mean is better than the zero that was set
NOISES = 20.0  # standard deviations of the noise that a good press reaches at least
LEAST_NOISES = 8.0  # below, nothing is reported at all: noise alone reaches five
CLEAR_OF_NOISE_STD = 6.0  # standard deviations of the noise: what differs by more is no noise
MIN_AIR_S = 0.15  # [s] out of contact before the first touch
HOLD_S = 2.0  # [s] that a hold lasts at least
STILL = 0.04  # of the greatest value: what counts as still
SPEEDS = 4.0  # ratio of the fastest to the slowest press
SLID_ROWS = 10
TURNED = 8.0  # standard deviations of the noise that the torque must reach


def without_zeros(recording: Recording) -> Recording:
    """Return ``recording`` with its loads counted from their means in the air.

    A sensor is switched on, warms and is mounted anew between two trials, and a fit has one zero for all that
    it is given. A zero that differs from trial to trial by half the noise of the force put the stiffness of a
    soft fingertip ten standard errors off. Each trial begins in the air, so each shows its own.
    """
    air = in_air(recording)
    columns = dict(recording.columns)
    for name in FORCE_CHANNELS:
        values = columns.get(name)
        known = air & np.isfinite(values) if values is not None else air
        if values is not None and np.count_nonzero(known) >= LEAST_ROWS:
            columns[name] = values - float(np.mean(values[known]))
    return replace(recording, columns=columns)


def check_trial(kind: str, recording: Recording) -> list[str]:
    """Return what the recording of a trial lacks, a sentence each with the remedy; empty: it is good.

    Raises:
        RecordingError: it cannot be used at all; says why.

    """
    for name in ("normal_force", "displacement"):
        if name not in recording.columns:
            raise RecordingError(
                f"{recording.name} has no {name}; a calibration needs normal force and displacement"
            )
    noise = noise_of(recording)
    force = np.nan_to_num(recording.columns["normal_force"])
    rest = float(np.percentile(force, 5))
    peak = float(np.nanmax(force)) - rest
    if not peak > LEAST_NOISES * noise.normal_force:
        raise RecordingError(
            f"{recording.name}: nothing is pressed: the force rises by {peak:.3g} N, and its noise is "
            f"{noise.normal_force:.2g} N; press deeper (--depth allows it)"
        )
    if not peak > NOISES * noise.normal_force:
        return [
            f"it is pressed too gently: the force rises by {peak:.2g} N only, {NOISES:g} times its noise of "
            f"{noise.normal_force:.2g} N is needed: press deeper (--depth allows it)"
        ]
    touches = force - rest > max(0.1 * peak, CLEAR_OF_NOISE_STD * noise.normal_force)
    said = _air(recording, touches)
    if kind == "press":
        said += _speeds(recording, touches)
    elif kind == "hold":
        said += _holds(recording, force - rest, peak, noise)
    elif kind == "slide":
        said += _slides(recording, "pull")
    elif kind == "twist":
        said += _slides(recording, "twist") + _turns(recording, noise.torque_z)
    return said


def _air(recording: Recording, touches: NDArray[np.bool_]) -> list[str]:
    rows = np.flatnonzero(touches)
    before = float(recording.t[rows[0]] - recording.t[0]) if rows.size else 0.0
    if before >= MIN_AIR_S:
        return []
    return [
        f"it begins {before:.2g} s before the touch: begin half a second in the air, where the zeros are read"
    ]


def _speeds(recording: Recording, touches: NDArray[np.bool_]) -> list[str]:
    rises = []
    for one in dict.fromkeys(recording.episode.tolist()):
        rows = np.flatnonzero((recording.episode == one) & touches)
        if rows.size > 5:
            depth = np.nan_to_num(recording.columns["displacement"][rows])
            top = int(np.argmax(depth > depth[0] + 0.9 * (depth.max() - depth[0])))
            rises.append(max(float(recording.t[rows[top]] - recording.t[rows[0]]), 1e-3))
    if len(rises) >= 2 and max(rises) >= SPEEDS * min(rises):
        return []
    return ["all presses are about equally fast: press slowly (a second and more) as well as fast (0.1 s)"]


def _holds(recording: Recording, force: Floats, peak: float, noise: Noise) -> list[str]:
    depth = np.nan_to_num(recording.columns["displacement"])
    pressed = force > 0.25 * peak
    reach = float(np.ptp(depth[pressed])) if pressed.any() else 0.0
    still = STILL * max(reach, float(np.max(np.abs(depth))))
    longest = max(
        _longest(recording, pressed, depth, max(still, CLEAR_OF_NOISE_STD * noise.displacement)),
        _longest(recording, pressed, force, max(STILL * peak, CLEAR_OF_NOISE_STD * noise.normal_force)),
    )
    if longest >= 0.95 * HOLD_S:  # a drive needs a moment to stand still
        return []
    return [f"the longest hold lasts {longest:.2g} s: hold still for {HOLD_S:g} s and more"]


def _longest(recording: Recording, pressed: NDArray[np.bool_], values: Floats, still: float) -> float:
    """Return the longest time [s] in which ``values`` stay within ``still`` of where they began."""
    longest, since = 0.0, -1
    for i, is_pressed in enumerate(pressed.tolist()):
        if not is_pressed:
            since = -1
            continue
        is_new = since < 0 or recording.episode[i] != recording.episode[since]
        if is_new or abs(values[i] - values[since]) > still:
            since = i
        else:
            longest = max(longest, float(recording.t[i] - recording.t[since]))
    return longest


def _slides(recording: Recording, how: str) -> list[str]:
    columns = recording.columns
    if not {"tangential_force_x", "tangential_force_y", "torque_z"} & set(columns):
        return ["no tangential force is measured, so friction cannot be found from it"]
    if "slip" not in columns:
        return [
            "it has no slip column, so the load at slip is not known: mark the rows that slide with slip = 1"
        ]
    rows = int(np.count_nonzero(np.nan_to_num(columns["slip"]) == 1.0))
    if rows >= SLID_ROWS:
        return []
    return [f"it slides in {rows} rows only: {how} further, until it surely slides, or press less"]


def _turns(recording: Recording, noise: float) -> list[str]:
    torque = np.abs(np.nan_to_num(recording.columns.get("torque_z", np.zeros(len(recording)))))
    least, largest = TURNED * (noise or 1e-4), float(np.max(torque))
    if largest > least:
        return []
    if not largest > 0.0:
        return [
            "there is no torque in it: twist about the normal of the surface, or is torque_z not measured?"
        ]
    return [
        f"its torque reaches {largest:.2g} N m only, {TURNED:g} times its noise is {least:.2g} N m: press "
        "deeper and twist further; or leave twists out, with --torque 0"
    ]
