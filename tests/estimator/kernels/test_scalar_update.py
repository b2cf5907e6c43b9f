"""What is remembered of innovations, and of which kind of motion."""

import numpy as np
import pytest


def test_a_cell_keeps_the_weighted_mean_of_its_innovations(kernels, m, rng) -> None:
    channel, cell, keep = 1, 4, 0.9
    m[kernels.MODE_CELL], m[kernels.MODE_HEALTH_DECAY] = cell, keep
    at = kernels.HEALTH0 + kernels.CELL_SIZE * (kernels.REGIMES * channel + cell)
    m[at : at + kernels.CELL_SIZE] = 0.0
    normalised, nis = 4.0 * rng.standard_normal(40), 50.0 * rng.chisquare(1.0, 40)
    before = m.copy()
    for one in zip(normalised, nis, strict=True):
        kernels.record_innovation(m, channel, *one)
    weights = keep ** np.arange(39, -1, -1)
    assert m[at + kernels.CELL_WEIGHT] == pytest.approx(weights.sum())
    mean = np.average(np.clip(normalised, -10.0, 10.0), weights=weights)
    assert m[at + kernels.CELL_MEAN] == pytest.approx(mean)
    assert m[at + kernels.CELL_NIS] == pytest.approx(np.average(np.minimum(nis, 100.0), weights=weights))
    m[at : at + kernels.CELL_SIZE] = before[at : at + kernels.CELL_SIZE]
    assert np.array_equal(m, before)


@pytest.mark.parametrize(
    ("contact", "stds", "regime"),
    [
        (0.0, 9.0, "AIR"),
        (1.0, 1.9, "HOLD"),
        (1.0, -1.9, "HOLD"),
        (1.0, 2.1, "LOADING"),
        (1.0, -2.1, "UNLOADING"),
    ],
)
def test_a_motion_is_one_from_two_standard_deviations_of_the_speed(
    kernels, m, P, contact, stds, regime
) -> None:
    P[kernels.SPEED, kernels.SPEED] = 1e-6
    m[kernels.REP_CONTACT], m[kernels.Y0 + kernels.SPEED] = contact, stds * 1e-3
    assert kernels.regime_of(m) == getattr(kernels, f"REGIME_{regime}")


@pytest.mark.parametrize("regime", ["AIR", "LOADING", "HOLD", "UNLOADING"])
@pytest.mark.parametrize("deep", [False, True])
@pytest.mark.parametrize("fast", [False, True])
@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("special", ["", "SLIDING", "JERK"])
def test_each_kind_of_motion_has_its_cell(kernels, m, regime, deep, fast, late, special) -> None:
    m[kernels.MODE_REGIME] = getattr(kernels, f"REGIME_{regime}")
    m[kernels.Y0 + kernels.DELTA] = m[kernels.SET_DEPTH] * (1.1 if deep else 0.9)
    sign = -1.0 if regime == "UNLOADING" else 1.0
    m[kernels.Y0 + kernels.SPEED] = sign * m[kernels.SET_DEPTH] * 2.0 * (1.1 if fast else 0.9)
    m[kernels.MODE_REST] = 1.1 if late else 0.9
    m[kernels.MODE_SINCE_JERK] = 0.05 * (0.9 if special == "JERK" else 1.1)
    m[kernels.FRI_SLIDING] = float(special == "SLIDING")
    expected = regime
    if special == "JERK" or (special and regime != "AIR"):
        expected = special
    elif regime in ("LOADING", "UNLOADING") and (fast or deep):
        expected = f"FAST_{regime}" if fast else f"DEEP_{regime}"
    elif regime == "HOLD" and (late or deep):
        expected = "LATE_HOLD" if late else "DEEP_HOLD"
    assert kernels.cell_of(m) == getattr(kernels, f"REGIME_{expected}")


def test_a_measurement_without_noise_leaves_a_millionth_of_the_deviation(kernels, m, P) -> None:
    m[kernels.H0 : kernels.H0 + kernels.N] = 0.0
    m[kernels.H0 + kernels.DELTA], before = 1.0, P[kernels.DELTA, kernels.DELTA]
    kernels.apply_measurement(m, kernels.CHANNEL_FORCE, 0.0, kernels.spread_of(m))
    assert P[kernels.DELTA, kernels.DELTA] == pytest.approx(1e-12 * before, rel=1e-6)
    place = kernels.CHANNEL0 + kernels.CHANNEL_SIZE * kernels.CHANNEL_FORCE
    assert m[place + kernels.CH_USED] == 1.0
