"""The held object: momentum and energy are accounted for."""

import numpy as np
import pytest

from vegrip.virtual.disturbance import NO_BURDEN, Burden
from vegrip.virtual.patch import even_grid
from vegrip.virtual.plate import Plate
from vegrip.virtual.settings import FingertipSettings, ObjectSettings

DT = 1e-3
GRID = even_grid(8, 16)
PLACE = np.array([[0.0, 0.0], [-0.03, 0.01], [0.03, 0.0]])
SETTINGS = ObjectSettings(mass=0.3, inertia=6e-4, offset_x=0.0, offset_y=0.0)


def plate(damping: float = 3e-3, settings: ObjectSettings = SETTINGS) -> Plate:
    return Plate(settings, (FingertipSettings(bristle_damping=damping),) * 3, PLACE, GRID)


def carry(held: Plate, duration: float, N: float, burden: Burden = NO_BURDEN, stand: float = 0.0) -> None:
    load = GRID.load(np.full(3, 2.0))
    for _ in range(round(duration / DT)):
        held.carry(np.full(3, 5e-3), np.full(3, N), load, np.full(3, 0.8), burden, stand, DT)


def test_nothing_moves_without_force() -> None:
    held = plate()
    carry(held, 1.0, N=3.0, stand=1.0)
    assert not held.shift.any()


def test_it_falls_freely_when_nobody_holds_it() -> None:
    held = plate()
    carry(held, 0.1, N=0.0)
    assert held.pose[4] == pytest.approx(-9.81 * 0.1, rel=1e-9)
    assert held.shift[1] == pytest.approx(-0.5 * 9.81 * 0.1**2, rel=0.02)
    assert held.shift[0] == held.shift[2] == 0.0


def test_free_plate_keeps_the_momentum_of_a_push_and_a_twist() -> None:
    held = plate()
    carry(held, 0.2, N=0.0, burden=Burden(force_x=0.6, torque=3e-4), stand=1.0)
    assert held.pose[3] == pytest.approx(0.6 * 0.2 / 0.3, rel=1e-9)
    assert held.pose[5] == pytest.approx(3e-4 * 0.2 / 6e-4, rel=1e-9)


def test_at_rest_friction_balances_weight_and_torque() -> None:
    held = plate(settings=ObjectSettings(mass=0.3, inertia=6e-4, offset_x=0.01, offset_y=-0.02))
    carry(held, 1.0, N=3.0, burden=Burden(force_x=0.5, mass=0.1))
    force = held.wrench[:, :2].sum(axis=0)
    assert force == pytest.approx([0.5, -0.4 * 9.81], rel=1e-6)
    lever = PLACE - held.pose[:2]
    turning = held.wrench[:, 2] + lever[:, 0] * held.wrench[:, 1] - lever[:, 1] * held.wrench[:, 0]
    assert turning.sum() == pytest.approx(0.0, abs=1e-7)
    assert held.pose[3:] == pytest.approx(0.0, abs=1e-7)


def test_turned_gravity_pulls_sideways() -> None:
    held = plate()
    carry(held, 1.0, N=3.0, burden=Burden(turn=np.pi / 2))
    assert held.wrench[:, :2].sum(axis=0) == pytest.approx([0.3 * 9.81, 0.0], abs=1e-5)


def test_kinetic_and_elastic_energy_only_fall_after_a_push() -> None:
    """Elastic energy of the bristles is that of their stiffness: nothing is gained by the integration."""
    held = plate(damping=0.0)
    carry(held, 0.01, N=3.0, burden=Burden(force_x=2.0, torque=0.01), stand=1.0)
    element = 8e7 * np.pi * (5e-3) ** 2 * GRID.area

    def energy() -> float:
        m, inertia = SETTINGS.mass, SETTINGS.inertia
        v = held.pose[3:]
        kinetic = 0.5 * m * (v[0] ** 2 + v[1] ** 2) + 0.5 * inertia * v[2] ** 2
        bent = (held.bristle**2).sum(axis=(0, 2, 3))
        return float(kinetic + 0.5 * element @ bent)

    peaks = []
    for _ in range(10):
        samples = []
        for _ in range(50):
            carry(held, DT, N=3.0, stand=1.0)
            samples.append(energy())
        peaks.append(float(np.mean(samples)))
    assert peaks[-1] <= peaks[0] * (1.0 + 1e-3)
    assert peaks[0] > 0.0


def test_damped_vibration_dies_out() -> None:
    held = plate()
    carry(held, 0.02, N=3.0, burden=Burden(force_x=2.0), stand=1.0)
    carry(held, 1.0, N=3.0, stand=1.0)
    assert np.abs(held.pose[3:]).max() < 1e-6


def test_a_light_plate_does_not_blow_up() -> None:
    """Substeps follow from stiffness, damping and mass."""
    held = plate(settings=ObjectSettings(mass=1e-3, inertia=1e-7))
    carry(held, 0.05, N=3.0, burden=Burden(force_x=0.1, torque=1e-4))
    assert np.abs(held.shift[:2]).max() < 1e-4
    assert held.substeps(np.full(3, 5e-3), 1e-3, DT) > 10


def test_it_is_lost_after_sliding_or_turning_far() -> None:
    held = plate()
    assert not held.lost
    held.pose[0] += 0.05
    assert held.lost
    held = plate()
    held.pose[2] += 1.3
    assert held.lost
