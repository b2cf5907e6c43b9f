"""Delay of a slip channel, and the slip speed from which on it speaks: from slides that the load shows.

While a fingertip sticks, the utilisation u = |tangential force| / normal force follows the load; from the
moment it slides, u = mu, however the load goes on. So a slide begins where u stops growing: at t0 of

    u = a - b (t0 - t)^q   for t < t0,      u = a - d + c (t - t0)   for t >= t0,      b > 0, c < b / 2,

with the least squares around the moment at which the flag rises; q = 1 where the load is imposed, and more
where the motion is and the patch slides from its rim inwards. The flag is late by that moment minus t0, which
is the surer the shorter u has grown: a bend as round as q > 1 hides t0 by up to a fifth of the growth. The
threshold lies between the fastest slide that shows in the load and not in the flag, and the slowest above it
that the flag shows: by the median of the slip speed where it is measured, else by a speed that is known. The
upper one is used.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from vegrip.identification.recording import Recording
from vegrip.types import Floats

BEFORE_S: Final = 0.5  # [s] before the flag in which a slide may have begun
AFTER_S: Final = 0.05  # [s] after it that are looked at, while it is up
AHEAD_S: Final = 0.02  # [s] by which it may be ahead
RISEN: Final = 0.3  # of its peak from which on u is fitted: before, the load may not have begun
LONGEST_ROUND_S: Final = 0.25  # [s] of growth, after which a round bend no longer shows a moment
MIN_ROWS: Final = 4  # on each side of the beginning
CLEAR_STD: Final = 6.0  # standard errors by which u must grow before and stop
PRESSED: Final = 0.1  # of the greatest normal force below which u is not known
ORDERS: Final = (1.0, 1.5, 2.0, 3.0)
MOST_AFTER: Final = 0.5  # of the growth before
MOST_JUMP: Final = 0.1  # of it, upwards: noise
SLIDING: Final = 0.8  # of the usual u of slides that are felt: below, a pull has ended and nothing slides
MIN_SLIDES: Final = 3


@dataclass(frozen=True, slots=True)
class Slide:
    """One slide that the flag has shown, or the load alone."""

    delay: float  # [s] NaN: its beginning does not show in the load; infinite: the flag does not show it
    rise: float  # [s] for which the load has grown before
    speed: float  # [m/s]; NaN: not known


@dataclass(frozen=True)
class SlipChannel:
    """Delay and threshold of a slip channel; NaN: not measured."""

    threshold: float  # slip speed from which it speaks [m/s]
    delay: float  # by which it is late [s]
    slides: int  # from which the delay was found
    unfelt: float = math.nan  # fastest slip speed that it was silent at [m/s]

    @property
    def lacking(self) -> str:
        """What must be recorded for it to be known, empty when it is."""
        if math.isnan(self.delay):
            return (
                f"the delay of the slip channel is not known: {self.slides} slides begin clearly in the "
                f"load, {MIN_SLIDES} are needed; pull fast until it slides, several times"
            )
        if math.isnan(self.threshold):
            return (
                "the slip speed from which slip is felt is not known: no slip speed is measured, and no "
                "slide that is felt has a known one"
            )
        return ""

    @property
    def bracket(self) -> str:
        """Between which slip speeds it begins to speak."""
        upper = f"{1e3 * self.threshold:.2g} mm/s"
        if math.isnan(self.unfelt):
            return f"at {upper}, the slowest slide, and perhaps at less"
        return f"from a slip speed between {1e3 * self.unfelt:.2g} and {upper} on"

    @property
    def settings(self) -> dict[str, Any]:
        """The parameters ``friction`` of a grip controller that learns by it; empty while it is not known."""
        if self.lacking:
            return {}
        found = {"slip_threshold": self.threshold, "slip_delay": self.delay}
        return {"learning": True, **{name: float(f"{v:.3g}") for name, v in found.items()}}


def slip_channel(slides: Sequence[Slide]) -> SlipChannel:
    """Return what ``slides`` show of their channel: the median of the delays, weighted, and its threshold."""
    clear = sorted((one for one in slides if math.isfinite(one.delay)), key=lambda one: one.delay)
    unfelt = max((one.speed for one in slides if math.isinf(one.delay)), default=math.nan)
    speeds = [one.speed for one in slides if not (math.isinf(one.delay) or one.speed <= unfelt)]
    threshold = min((speed for speed in speeds if not math.isnan(speed)), default=math.nan)
    if len(clear) < MIN_SLIDES:
        return SlipChannel(threshold, math.nan, len(clear), unfelt)
    weights = np.cumsum([1.0 / one.rise for one in clear])
    middle = clear[int(np.searchsorted(weights, 0.5 * weights[-1]))]
    return SlipChannel(threshold, max(middle.delay, 0.0), len(clear), unfelt)


def slides_of(recording: Recording, speeds: Sequence[float] = ()) -> list[Slide]:
    """Return the slides of a recording that its slip flag shows, and those of a known speed that it does not.

    Args:
        recording: of one fingertip, its forces without zeros.
        speeds: of the slide of each episode, where they are known [m/s].

    """
    columns, t = recording.columns, recording.t
    if not {"slip", "normal_force", "tangential_force_x", "tangential_force_y"} <= set(columns):
        return []
    force = np.nan_to_num(columns["normal_force"])
    load = np.hypot(columns["tangential_force_x"], columns["tangential_force_y"])
    pressed = force > PRESSED * float(np.max(force, initial=0.0))
    u = np.divide(load, force, out=np.full(len(t), np.nan), where=pressed)
    felt = np.nan_to_num(columns["slip"]) >= 0.5
    speed = np.abs(columns.get("slip_speed", np.full(len(t), np.nan)))
    known = dict(zip(dict.fromkeys(recording.episode.tolist()), speeds, strict=False))
    found = []
    usual = float(np.median(u[felt & pressed])) if np.any(felt & pressed) else 0.0
    for first in np.flatnonzero(felt[1:] & ~felt[:-1]) + 1:
        own = recording.episode == recording.episode[first]
        down = np.flatnonzero(~felt[first:] | ~own[first:])
        last = first + int(down[0]) if len(down) else len(t)
        fast = speed[first:last][speed[first:last] > 0.0]
        up = felt[:first] | ~own[:first]
        begin = int(np.flatnonzero(up)[-1]) + 1 if np.any(up) else 0
        window = np.arange(begin, last)
        near = (t[window] >= t[first] - BEFORE_S) & (t[window] <= t[first] + AFTER_S)
        rows = window[near & own[window] & np.isfinite(u[window])]
        began, rise, order = _beginning(t[rows], u[rows], float(t[first]) + AHEAD_S)
        if order > 1.0 and rise > LONGEST_ROUND_S:
            began = math.nan
        stated = known.get(int(recording.episode[first]), math.nan) or math.nan
        found.append(Slide(float(t[first]) - began, rise, float(np.median(fast)) if len(fast) else stated))
    for episode, pulled in known.items():
        rows = np.flatnonzero((recording.episode == episode) & np.isfinite(u))
        if pulled > 0.0 and len(rows) and not np.any(felt[recording.episode == episode]):
            rows = rows[: _falls(force[rows])]
            began, rise, _ = _beginning(t[rows], u[rows], math.inf)
            slides = not math.isnan(began) and np.median(u[rows][t[rows] >= began]) > SLIDING * usual
            if slides:
                found.append(Slide(math.inf, rise, pulled))
    return found


def _falls(force: Floats) -> int:
    """Return the row at which a press ends: the last one above half of its greatest force."""
    return int(np.flatnonzero(force > 0.5 * np.max(force))[-1]) + 1


def _beginning(t: Floats, u: Floats, latest: float) -> tuple[float, float, float]:
    """Return when ``u`` stops growing [s], at the ``latest``, how long it grew [s], and q; NaN: not clear."""
    unclear = math.nan, math.nan, math.nan
    if not len(u):
        return unclear
    peak = int(np.argmax(np.where(t <= latest, u, 0.0)))
    low = np.flatnonzero(u[:peak] < RISEN * u[peak])
    begin = int(low[-1]) if len(low) else 0
    t, u = t[begin:], u[begin:]
    best, found = math.inf, unclear
    for k in range(MIN_ROWS, len(t) - MIN_ROWS):
        if t[k] > latest:
            break
        away = (t - t[k]) / (t[-1] - t[0])
        for order in ORDERS:
            before, after = np.maximum(-away, 0.0) ** order, np.maximum(away, 0.0)
            a = np.column_stack([np.ones(len(t)), -before, after, away >= 0.0])
            solution, *_ = np.linalg.lstsq(a, u, rcond=None)
            left = float(np.sum((u - a @ solution) ** 2))
            if left >= best:
                continue
            error = math.sqrt(left / max(len(t) - 6, 1) * np.linalg.inv(a.T @ a)[1, 1])
            _, grown, goes_on, jump = solution
            begins = grown > CLEAR_STD * error and goes_on < MOST_AFTER * grown and jump < MOST_JUMP * grown
            best, found = left, (float(t[k]), float(t[k] - t[0]), order) if begins else unclear
    return found
