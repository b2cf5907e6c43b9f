"""The error of every channel: in its own unit and against its noise, its whiteness, its coverage."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, ndtri

from vegrip.identification.fit.problem import AT, Problem
from vegrip.types import Floats

LAGS = 20  # of the test for whiteness


@dataclass(frozen=True)
class ChannelError:
    """The error of one channel."""

    rmse: float  # of the residual, in the unit of the channel
    noise: float  # rms of what its noise (and that of the displacement) leaves of a perfect model, same unit
    ratio: float  # rms of the standardised residual; 1 is the noise
    whiteness_p: float  # probability of so much correlation between neighbours by chance (Ljung-Box, 20 lags)
    coverage95: float  # share of residuals within 1.96 standard deviations
    rows: int  # how many


def overall_error(problem: Problem, u: Floats) -> float:
    """Return the rms of the whitened residuals over all channels; 1 is the noise."""
    return rms(problem.residual(u)[problem.counted])


def channel_errors(problem: Problem, u: Floats) -> dict[str, ChannelError]:
    """Return the errors by channel, of those that were measured."""
    table = problem.table(u)
    raw = problem.raw(table)
    white = problem.white(raw)
    m = problem.measured
    n, k = len(m.recording), m.sliding.size
    used, touching = problem.used, problem.stiffness > 0.0
    episode = problem.episodes
    out = {"normal_force": _error(raw[0], problem.force_std, white[:n], used, episode)}
    if np.count_nonzero(used & touching) > 10:
        # the same residual, read along the other axis: the displacement that would have given the force
        stiffness = np.where(touching, problem.stiffness, 1.0)
        firm = used & touching & (problem.stiffness > 0.1 * problem.stiffness.max())
        out["displacement"] = _error(
            -raw[0] / stiffness, problem.force_std / stiffness, white[:n], firm, episode
        )
    for name, size, rows in loads_at_slip(problem, table):
        z = white[n : n + k]
        out[name] = _error(raw[1] * size, problem.slip_std * size, z, rows, episode[m.sliding])
    if m.seen.size:
        everything = np.isfinite(problem.radius_std)
        out["contact_radius"] = _error(
            raw[2], problem.radius_std, white[n + k :], everything, episode[m.seen]
        )
    return out


def loads_at_slip(problem: Problem, table: Floats) -> Iterator[tuple[str, Floats, NDArray[np.bool_]]]:
    """Yield pull [N] and torque [N m] of the rows that slide (k,), and where each is most of the load.

    ``table``: the prediction of ``problem``.
    """
    rows = problem.measured.sliding
    pull, turn = (np.abs(table[rows, AT[name]]) for name in ("tangential_force", "torque_z"))
    force, torque = (np.maximum(table[rows, AT[name]], 0.0) for name in ("limit_force", "limit_torque"))
    pulled, sure = pull * torque >= turn * force, np.isfinite(problem.slip_std)
    for name, size, which in (("tangential_force", pull, pulled), ("torque_z", turn, ~pulled)):
        if (which & sure).any():
            yield name, size, which & sure


def _error(raw: Floats, std: Floats, white: Floats, rows: np.ndarray, episode: np.ndarray) -> ChannelError:
    raw, std, white = raw[rows], std[rows], white[rows]
    z = raw / std
    return ChannelError(
        rms(raw),
        rms(std),
        rms(z),
        whiteness(white, episode[rows]),
        float(np.mean(np.abs(z) < ndtri(0.975))),
        raw.size,
    )


def rms(values: Floats) -> float:
    """Return the root mean square; NaN of nothing."""
    return math.sqrt(float(np.mean(values**2))) if values.size else math.nan


def whiteness(values: Floats, episode: np.ndarray, lags: int = LAGS) -> float:
    """Return the p-value of [LjungBox1978]_ over pairs within the same episode."""
    n = values.size
    power = float(values @ values)
    if n <= 3 * lags or power == 0.0:
        return math.nan
    Q = 0.0
    for lag in range(1, lags + 1):
        same = episode[lag:] == episode[:-lag]
        r = float(np.sum((values[lag:] * values[:-lag])[same])) / power
        Q += n * (n + 2.0) * r * r / max(int(np.count_nonzero(same)), 1)
    return float(chdtrc(lags, Q))
