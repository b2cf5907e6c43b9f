"""Rows that are lost in a contact: what moved meanwhile is not known, and the memory of it is no evidence."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from vegrip.identification.fit import fit
from vegrip.identification.fit.gaps import find_gaps, unseen_bumps
from vegrip.identification.recording import Recording

LOST = ((1.5, 0.3), (3.1, 0.4), (4.6, 0.25))  # [s] of an episode, from when and how long


def lossy(whole: Recording, without: tuple[str, ...]) -> Recording:
    """Lose rows, or only what they hold of some channels."""
    keep = np.ones(len(whole), dtype=bool)
    for episode in np.unique(whole.episode):
        since = whole.t - whole.t[whole.episode == episode][0]
        for begin, lasts in LOST:
            keep &= ~((whole.episode == episode) & (since > begin) & (since < begin + lasts))
    if not without:
        return whole.select(keep)
    empty = {name: np.where(keep, whole.columns[name], np.nan) for name in without}
    return replace(whole, columns={**whole.columns, **empty})


def off(recording: Recording) -> tuple[float, float]:
    """Return the error over noise of a fit, and how many standard errors its relaxation time is off."""
    found = fit(recording)
    nu1 = found.model.values["nu1"]
    return found.error, math.log(nu1.value / 3.0) / found.std["nu1"]


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("without", [(), ("displacement",), ("displacement", "normal_force")])
def test_a_fit_is_at_the_noise_and_its_memory_within_its_errors_though_rows_are_lost(
    tip: Callable[..., Recording], seed: int, without: tuple[str, ...]
) -> None:
    error, rate = off(lossy(tip(seed, kinds=("wander",) * 4), without))
    assert error < 1.03
    assert abs(rate) < 3.0


def test_a_gap_is_a_step_far_longer_than_those_around_it_and_no_pause_between_episodes() -> None:
    rng = np.random.default_rng(0)
    uneven = np.cumsum(rng.uniform(0.004, 0.006, 400))
    lost = uneven[np.r_[0:100, 110:200, 230:400]]
    first = np.zeros(lost.size)
    first[[0, 100]] = 1.0  # the first gap is between two episodes
    assert find_gaps(lost, first, np.zeros(lost.size)).tolist() == [[189, 190]]
    thinner = np.cumsum(0.01 * 1.2 ** np.arange(40.0))  # as a relaxation is often sampled
    assert not find_gaps(thinner, first[:40], np.zeros(40)).size
    silent = np.zeros(lost.size)
    silent[[*range(250, 260), 300]] = np.nan  # and a single one, which is an outlier
    assert find_gaps(lost, first, silent).tolist() == [[189, 190], [249, 260]]


def test_a_bump_is_what_the_motion_does_in_other_stretches_as_long() -> None:
    t = np.arange(0.0, 20.0, 0.005)
    depth = 1e-3 * (1.0 + 0.3 * np.sin(2.0 * np.pi * t / 2.0))
    keep = (t < 8.3) | (t > 8.6975)  # over a crest
    first = np.r_[1.0, np.zeros(np.count_nonzero(keep) - 1)]
    gaps = find_gaps(t[keep], first, depth[keep])
    bump = unseen_bumps(t[keep], first, depth[keep], gaps)
    assert t[keep][gaps[0]] == pytest.approx([8.295, 8.7])
    # of a sine with w L = 1.27 the mean differs from the chord's by 0.3 (cos(wL/2) - sin(wL/2) / (wL/2))
    half = np.pi * 0.405 / 2.0
    usual = 0.3e-3 * (np.sin(half) / half - np.cos(half)) / np.sqrt(2.0)
    assert bump[gaps[:, 0]] == pytest.approx(2.0 * usual, rel=0.1)
    assert np.count_nonzero(bump) == 1
