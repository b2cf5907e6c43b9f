"""The load ahead: a ramp is foreseen by the drive's lag, a steady load is told without its noise."""

import math

import numpy as np
import pytest

from vegrip.grip.drive_lag import begin_drives, set_drives
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.load_lead import begin_lead, lead_load, lead_variance

DT, NOISE, TORQUE_NOISE, LAG = 0.002, 0.01, 1e-4, 0.01


def led(
    loads: list[tuple[float, float, float]], lag: float = LAG, measured: float = 0.0
) -> list[tuple[float, float]]:
    """Return what comes ahead of (x, y, torque) by sample; ``measured`` [s] is 0 where no lag is known."""
    q = GraspMemory()
    begin_drives(q, NOISE)
    set_drives(q, lag, burst=5.0)
    begin_lead(q, NOISE, TORQUE_NOISE)
    q.drive.lag[1], q.drive.known[1] = measured, float(measured > 0.0)
    return [lead_load(q, 1, DT, *load) for load in loads]


def test_a_ramp_is_told_as_it_will_be_a_lag_later() -> None:
    slope = 20.0
    loads = [(0.0, slope * k * DT, 0.0) for k in range(100)]
    now = loads[-1][1]
    assert led(loads)[-1][0] - now == pytest.approx(slope * LAG, rel=0.15)


def test_a_ramp_of_torque_is_led_with_the_same_sign() -> None:
    loads = [(0.0, 0.0, -0.4 * k * DT) for k in range(100)]
    assert led(loads)[-1][1] > abs(loads[-1][2])


def test_a_falling_load_is_led_downwards() -> None:
    loads = [(5.0 - 10.0 * k * DT, 0.0, 0.0) for k in range(100)]
    assert led(loads)[-1][0] < loads[-1][0]


@pytest.mark.parametrize("lag", [0.01, 0.05, 0.2])
@pytest.mark.parametrize("seconds", [0.0, 0.02, 0.05])
def test_a_load_that_vanishes_is_never_led_to_more_than_it_was(lag: float, seconds: float) -> None:
    fall = max(round(seconds / DT), 1)
    loads = [(0.0, -4.9 + 4.65 * min(max(k - 50, 0) / fall, 1.0), 0.02 * float(k < 50)) for k in range(120)]
    ahead = led(loads, lag)
    assert max(force for force, _ in ahead) <= 4.9 + 1e-9
    assert max(torque for _, torque in ahead) <= 0.02 + 1e-9
    assert ahead[-1] == pytest.approx((0.25, 0.0), abs=1e-3)


def test_the_noise_of_a_steady_load_is_less_than_half_of_what_is_felt() -> None:
    rng = np.random.default_rng(4)
    loads = [(1.0 + NOISE * rng.standard_normal(), 0.0, 0.0) for _ in range(5000)]
    ahead = [force for force, _ in led(loads)][100:]
    assert np.std(ahead) < 0.75 * NOISE
    assert np.mean(ahead) == pytest.approx(1.0, abs=0.002)


@pytest.mark.parametrize(
    ("load", "told"),
    [
        ((math.nan, 0.0, 0.0), (math.nan, 0.0)),
        ((0.0, math.nan, -0.2), (math.nan, 0.2)),
        ((3.0, -4.0, -math.inf), (5.0, math.inf)),
        ((-math.inf, 4.0, 0.1), (math.inf, 0.1)),
    ],
)
def test_an_unknown_load_is_told_as_it_is_and_the_next_one_begins_anew(load, told) -> None:
    ahead = led([(1.0, 0.0, 0.0)] * 50 + [load, (3.0, 4.0, 0.01)])
    assert ahead[-2] == pytest.approx(told, nan_ok=True)
    assert ahead[-1] == pytest.approx((5.0, 0.01))


def test_a_torque_that_is_not_measured_leaves_the_force() -> None:
    ahead = led([(1.0, 0.0, math.nan)] * 3)
    assert ahead[-1] == pytest.approx((1.0, 0.0))


def test_a_measured_lag_counts_instead_of_the_one_that_is_told() -> None:
    loads = [(0.0, 20.0 * k * DT, 0.0) for k in range(100)]
    now = loads[-1][1]
    assert led(loads, LAG, measured=0.004)[-1][0] - now == pytest.approx(20.0 * 0.004, rel=0.15)


def test_of_a_long_measured_lag_a_part_is_led_and_more_is_held_for_the_rest() -> None:
    steady = [(2.0, 0.0, 0.01)] * 100
    force, torque = led(steady, measured=0.035)[-1]
    assert force == pytest.approx(2.0 * held_for(0.035), rel=1e-3)
    assert torque == pytest.approx(0.01 * held_for(0.035), rel=1e-3)
    assert led(steady, measured=0.015)[-1] == pytest.approx((2.0, 0.01))


@pytest.mark.parametrize(("keep", "hold"), [(0.5, 0.9), (0.0, 0.99), (0.9, 0.9), (0.3, 0.0)])
def test_the_variance_of_fast_minus_slow_is_that_of_its_weights(keep, hold) -> None:
    """Both are sums of the past with weights (1 - a) a^n."""
    n = np.arange(5000)
    weights = (1.0 - keep) * keep**n - (1.0 - hold) * hold**n
    assert lead_variance(keep, hold) == pytest.approx(float(np.sum(weights**2)), abs=1e-9)


def test_two_that_keep_everything_have_no_variance() -> None:
    assert lead_variance(1.0, 1.0) == 0.0


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_step_is_followed_in_3_and_12_ms_and_two_deviations_of_their_difference_do_not_count(
    noise, sign
) -> None:
    q = GraspMemory()
    begin_lead(q, noise, 0.0)
    lead_load(q, 0, 0.003, 0.0, 0.0, 0.0)
    begin_drives(q, NOISE)
    set_drives(q, 0.01, burst=5.0)
    ahead, _ = lead_load(q, 0, 0.003, 0.0, sign, 0.0)
    fast, slow = 1.0 - math.exp(-1.0), 1.0 - math.exp(-0.25)
    n = np.arange(2000)
    weights = fast * (1.0 - fast) ** n - slow * (1.0 - slow) ** n
    off = max(fast - slow - 2.0 * noise * math.sqrt(float(np.sum(weights**2))), 0.0)
    assert ahead == pytest.approx(fast + 0.013 * off / 0.009)


@pytest.mark.parametrize("measured", [0.015, 0.025, 0.05])
def test_a_drive_that_holds_more_beforehand_has_what_a_burst_asks_for_at_its_end(measured) -> None:
    held = led([(2.0, 0.0, 0.0)] * 50, measured=measured)[-1][0] / 2.0
    assert held == pytest.approx(held_for(measured), rel=1e-3)
    ramp = [(0.0, 20.0 * k * DT, 0.0) for k in range(100)]
    lead = led(ramp, measured=measured)[-1][0] / held - ramp[-1][1]
    assert lead == pytest.approx(20.0 * 0.015, rel=0.1)


def held_for(lag: float) -> float:
    """Return the reserve that a drive needs whose load grows by half at 5 a second, step by step."""
    dt, force, k = 1e-5, 1.0, 0
    while k * dt < 0.1:
        k += 1
        force += dt / lag * (1.0 + 5.0 * (k * dt + 0.015) - force)
    return 1.5 / force
