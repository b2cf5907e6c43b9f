"""The motion behind a noisy displacement."""

import numpy as np
import pytest

from vegrip.identification.fit.motion import motion_of

NOISE = 5e-6
T = np.arange(0.0, 6.0, 5e-3)


def path(kind: str) -> np.ndarray:
    if kind == "ramp and hold":
        return np.interp(T, [0.0, 0.5, 0.6, 3.0, 3.2, 6.0], [-1e-4, -1e-4, 1e-3, 1e-3, 0.0, 0.0])
    if kind == "jump":
        return np.where(T > 1.0, 5e-4, -1e-4)
    if kind == "creep":
        return 1e-3 - 3e-4 * np.exp(-3.0 * T)
    return 1e-3 + 2e-4 * np.sin(2.0 * np.pi * 2.0 * T)


def smoothed(kind, seed=0):
    first = np.zeros(T.size)
    first[0] = 1.0
    noise = NOISE * np.random.default_rng(seed).standard_normal(T.size)
    return motion_of(T, first, path(kind) + noise, NOISE)


@pytest.mark.parametrize("kind", ["ramp and hold", "jump", "creep", "sine"])
def test_error_of_the_motion_is_smaller_than_the_noise_and_as_large_as_it_says(kind) -> None:
    motions = [smoothed(kind, seed) for seed in range(5)]
    errors = np.array([m.displacement - path(kind) for m in motions])
    assert errors.std() < 0.8 * NOISE
    z = errors / np.array([m.std for m in motions])
    assert 0.7 < z.std() < 1.3
    assert np.abs(errors).max() < 5.0 * NOISE


def test_a_hold_is_smoothed_much_more_than_a_fast_motion() -> None:
    assert np.median(smoothed("ramp and hold").std[:80]) < 0.3 * NOISE
    assert np.median(smoothed("sine").std) > np.median(smoothed("ramp and hold").std)


def test_missing_samples_are_bridged_and_less_certain() -> None:
    first = np.zeros(T.size)
    first[0] = 1.0
    holes = path("ramp and hold").copy()
    holes[200:220] = np.nan
    motion = motion_of(T, first, holes, NOISE)
    assert motion.displacement[200:220] == pytest.approx(1e-3, abs=NOISE)
    assert motion.std[210] > motion.std[300]


def test_episodes_do_not_know_of_each_other() -> None:
    first = np.zeros(T.size)
    first[[0, 600]] = 1.0
    depth = path("sine")
    both = motion_of(T, first, depth, NOISE)
    alone = motion_of(T[:600], first[:600], depth[:600], NOISE)
    assert both.displacement[:600] == pytest.approx(alone.displacement, abs=1e-12)


def test_exact_displacement_is_left_alone() -> None:
    first = np.zeros(T.size)
    first[0] = 1.0
    motion = motion_of(T, first, path("sine"), 0.0)
    assert np.array_equal(motion.displacement, path("sine"))
    assert not motion.std.any()
