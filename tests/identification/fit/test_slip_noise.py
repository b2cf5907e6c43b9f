"""What noise of the load makes of the logarithm of a utilisation, against drawn noise."""

from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.identification.fit.problem import AT, Problem

LIMIT, TORSION, FORCE = 2.0, 4e-3, 3.0
FORCE_NOISE, TORQUE_NOISE, NORMAL_NOISE = 0.05, 1.5e-4, 0.06


def stated(fx, fy, torque, *, rows=1, normal=NORMAL_NOISE):
    here = np.zeros((1, len(AT)))
    here[0, AT["limit_force"]], here[0, AT["limit_torque"]] = LIMIT, TORSION
    here[0, AT["contact_force"]] = FORCE
    noise = SimpleNamespace(tangential_force=FORCE_NOISE, torque_z=TORQUE_NOISE, normal_force=normal)
    measured = SimpleNamespace(noise=noise, sliding=np.array([0]), stretch=np.array([rows]))
    loads = tuple(np.array([value]) for value in (fx, fy, torque))
    problem = SimpleNamespace(measured=measured, _loads=lambda: loads)
    std, bias = Problem._slip_noise(problem, here)
    return float(std[0]), float(bias[0])


@pytest.mark.parametrize(
    ("fx", "fy", "torque"),
    [(2.0, 0.0, 0.0), (1.2, -1.6, 0.0), (0.0, 0.0, -4e-3), (1.2, 0.6, 2.8e-3), (0.4, 0.0, 3.9e-3)],
)
def test_std_and_mean_are_those_of_drawn_noise(fx, fy, torque) -> None:
    rng, n = np.random.default_rng(0), 2_000_000
    f = np.hypot(fx + FORCE_NOISE * rng.standard_normal(n), fy + FORCE_NOISE * rng.standard_normal(n))
    q = torque + TORQUE_NOISE * rng.standard_normal(n)
    scale = FORCE / (FORCE + NORMAL_NOISE * rng.standard_normal(n))  # limits in proportion to N
    drawn = np.log(np.hypot(f / LIMIT, q / TORSION) * scale)
    true = np.log(np.hypot(np.hypot(fx, fy) / LIMIT, torque / TORSION))
    std, bias = stated(fx, fy, torque)
    assert std == pytest.approx(drawn.std(), rel=0.02)
    assert bias == pytest.approx(drawn.mean() - true, abs=1.2e-4)


def test_the_mean_of_a_stretch_has_less_noise_by_its_root() -> None:
    one, nine = stated(1.6, 0.0, 1e-3), stated(1.6, 0.0, 1e-3, rows=9)
    assert nine[0] == pytest.approx(one[0] / 3.0)
    assert nine[1] == pytest.approx(one[1] / 9.0)


@pytest.mark.parametrize(("load", "counts"), [(0.74, True), (0.70, False)])
def test_a_load_of_which_noise_is_more_than_seven_hundredths_does_not_count(load, counts) -> None:
    std, bias = stated(load, 0.0, 0.0, normal=0.0)
    assert np.isfinite(std) == counts
    assert (bias != 0.0) == counts
