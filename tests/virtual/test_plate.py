"""The held object: momentum and energy are accounted for."""

import numpy as np
import pytest

from tests.virtual.build import body_of, hand_of, tips_of
from vegrip.virtual import kernels
from vegrip.virtual.disturbance import NO_BURDEN, Burden
from vegrip.virtual.fingertip import even_grid
from vegrip.virtual.settings import ObjectSettings

DT = 1e-3
GRID = even_grid(8, 16)
PLACE = np.array([[0.0, 0.0], [-0.03, 0.01], [0.03, 0.0]])
SETTINGS = ObjectSettings(mass=0.3, inertia=6e-4, offset_x=0.0, offset_y=0.0)


class Held:
    """A plate between three contacts of one size."""

    def __init__(self, damping: float = 3e-3, settings: ObjectSettings = SETTINGS) -> None:
        self.body = body_of(settings, step=DT, close_time=1.0)
        self.body["x"] = self.body["start_x"] = settings.offset_x
        self.body["y"] = self.body["start_y"] = settings.offset_y
        x, y = PLACE.T
        self.tips = tips_of(3, x=x, y=y, a=5e-3, k=2.0, mu=0.8, stiffness=8e7, damping=damping)
        self.hand = hand_of(self.body, self.tips, GRID)

    def carry(self, duration: float, N: float, burden: Burden = NO_BURDEN, stand: float = 0.0) -> None:
        b = burden
        row = np.array([b.force_x, b.force_y, b.torque, b.mass, b.turn, b.friction])
        self.tips["force"] = N
        for _ in range(round(duration / DT)):
            kernels.hold_object(self.hand, row, 0.5 if stand else 2.0)

    @property
    def shift(self) -> np.ndarray:
        b = self.body
        return np.array([b["x"] - b["start_x"], b["y"] - b["start_y"], b["angle"]]).ravel()

    @property
    def motion(self) -> np.ndarray:
        return np.array([self.body[name][0] for name in ("vx", "vy", "spin")])


def test_nothing_moves_without_force() -> None:
    held = Held()
    held.carry(1.0, N=3.0, stand=1.0)
    assert not held.shift.any()


def test_it_falls_freely_when_nobody_holds_it() -> None:
    held = Held()
    held.carry(0.1, N=0.0)
    assert held.motion[1] == pytest.approx(-9.81 * 0.1, rel=1e-9)
    assert held.shift[1] == pytest.approx(-0.5 * 9.81 * 0.1**2, rel=0.02)
    assert held.shift[0] == held.shift[2] == 0.0


def test_free_plate_keeps_the_momentum_of_a_push_and_a_twist() -> None:
    held = Held()
    held.carry(0.2, N=0.0, burden=Burden(force_x=0.6, torque=3e-4), stand=1.0)
    assert held.motion[0] == pytest.approx(0.6 * 0.2 / 0.3, rel=1e-9)
    assert held.motion[2] == pytest.approx(3e-4 * 0.2 / 6e-4, rel=1e-9)


def test_at_rest_friction_balances_weight_and_torque() -> None:
    held = Held(settings=ObjectSettings(mass=0.3, inertia=6e-4, offset_x=0.01, offset_y=-0.02))
    held.carry(1.0, N=3.0, burden=Burden(force_x=0.5, mass=0.1))
    force = held.tips["pull_x"].sum(), held.tips["pull_y"].sum()
    assert force == pytest.approx([0.5, -0.4 * 9.81], rel=1e-6)
    x, y = PLACE[:, 0] - held.body["x"], PLACE[:, 1] - held.body["y"]
    turning = held.tips["torque"] + x * held.tips["pull_y"] - y * held.tips["pull_x"]
    assert turning.sum() == pytest.approx(0.0, abs=1e-7)
    assert held.motion == pytest.approx(0.0, abs=1e-7)


def test_turned_gravity_pulls_sideways() -> None:
    held = Held()
    held.carry(1.0, N=3.0, burden=Burden(turn=np.pi / 2))
    assert (held.tips["pull_x"].sum(), held.tips["pull_y"].sum()) == pytest.approx(
        [0.3 * 9.81, 0.0], abs=1e-5
    )


def test_kinetic_and_elastic_energy_only_fall_after_a_push() -> None:
    """Elastic energy of the bristles is that of their stiffness: nothing is gained by the integration."""
    held = Held(damping=0.0)
    held.carry(0.01, N=3.0, burden=Burden(force_x=2.0, torque=0.01), stand=1.0)
    element = 8e7 * np.pi * (5e-3) ** 2 * GRID.rings["area"]

    def energy() -> float:
        m, inertia = SETTINGS.mass, SETTINGS.inertia
        v = held.motion
        kinetic = 0.5 * m * (v[0] ** 2 + v[1] ** 2) + 0.5 * inertia * v[2] ** 2
        bent = (held.hand.contacts.bristles**2).sum(axis=(0, 2, 3))
        return float(kinetic + 0.5 * element @ bent)

    peaks = []
    for _ in range(10):
        samples = []
        for _ in range(50):
            held.carry(DT, N=3.0, stand=1.0)
            samples.append(energy())
        peaks.append(float(np.mean(samples)))
    assert peaks[-1] <= peaks[0] * (1.0 + 1e-3)
    assert peaks[0] > 0.0


def test_damped_vibration_dies_out() -> None:
    held = Held()
    held.carry(0.02, N=3.0, burden=Burden(force_x=2.0), stand=1.0)
    held.carry(1.0, N=3.0, stand=1.0)
    assert np.abs(held.motion).max() < 1e-6


def test_a_light_plate_does_not_blow_up() -> None:
    """Substeps follow from stiffness, damping and mass."""
    held = Held(settings=ObjectSettings(mass=1e-3, inertia=1e-7))
    held.carry(0.05, N=3.0, burden=Burden(force_x=0.1, torque=1e-4))
    assert np.abs(held.shift[:2]).max() < 1e-4
    assert kernels.substeps(held.body[0], held.tips, 1e-3) > 10


@pytest.mark.parametrize(("axis", "moved"), [("x", 0.05), ("angle", 1.3)])
def test_it_is_lost_after_sliding_or_turning_far(axis: str, moved: float) -> None:
    held = Held()
    held.carry(DT, N=3.0, stand=1.0)
    assert not held.body["dropped"][0]
    held.body[axis] += moved
    held.carry(DT, N=3.0, stand=1.0)
    assert held.body["dropped"][0]
    assert not held.tips["pull_y"].any()
