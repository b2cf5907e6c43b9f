"""Friction summed over the elements of a patch, against points of the exact limit surface."""

import math

import numpy as np
import pytest

from tests.virtual.build import tips_of
from vegrip.virtual import kernels
from vegrip.virtual.fingertip import even_grid, utilisation

# (f / mu N, m / mu N a) at distances d/a of the centre of rotation, 30-digit quadrature
GOLDEN = {
    2.0: [
        (0.0, 0.0, 0.5890486225),
        (0.25, 0.2899223689, 0.5530959478),
        (0.5, 0.5522330836, 0.4555922940),
        (1.0, 0.8835729338, 0.2208932335),
        (2.0, 0.9742785793, 0.1019093329),
    ],
    3.0: [
        (0.0, 0.0, 0.6202450073),
        (0.25, 0.2709512205, 0.5865637746),
        (0.5, 0.5230228984, 0.4926471282),
        (1.0, 0.8707465984, 0.2440918149),
        (2.0, 0.9717643316, 0.1118024091),
    ],
    4.0: [
        (0.0, 0.0, 0.6354098136),
        (0.25, 0.2626505930, 0.6027363174),
        (0.5, 0.5094317274, 0.5107077864),
        (1.0, 0.8640993375, 0.2560114521),
        (2.0, 0.9704899177, 0.1168120772),
    ],
}


def largest_error(k: float, rings: int, spokes: int) -> float:
    golden, grid = np.array(GOLDEN[k]), even_grid(rings, spokes)
    load = grid.load(np.array([k]))[0]
    found = [kernels.limit_point(load, grid.rings, grid.rays, d) for d in golden[:, 0].tolist()]
    return float(np.abs(np.array(found) - golden[:, 1:]).max())


@pytest.mark.parametrize("k", GOLDEN)
def test_limit_surface_of_a_fine_patch_is_the_exact_one(k) -> None:
    assert largest_error(k, 64, 128) < 2e-4


@pytest.mark.parametrize("k", GOLDEN)
def test_limit_surface_converges_with_the_grid(k) -> None:
    errors = [largest_error(k, n, 2 * n) for n in (8, 16, 32)]
    assert errors[0] < 6e-3  # the grid of the hand
    assert errors[1] < 0.5 * errors[0]
    assert errors[2] < 0.5 * errors[1]


@pytest.mark.parametrize("k", GOLDEN)
def test_load_on_the_exact_limit_surface_uses_all_of_it(k) -> None:
    grid = even_grid(48, 96)
    for _, f, m in GOLDEN[k]:
        assert utilisation(grid, k, f, m) == pytest.approx(1.0, abs=5e-4)
        assert utilisation(grid, k, 0.4 * f, 0.4 * m) == pytest.approx(0.4, abs=2e-4)


def test_no_load_uses_nothing_and_pure_force_all_of_coulomb() -> None:
    grid = even_grid(8, 16)
    assert utilisation(grid, 2.0, 0.0, 0.0) == 0.0
    assert utilisation(grid, 2.0, 1.0, 0.0) == pytest.approx(1.0, rel=1e-9)


class Bench:
    """One patch under constant normal force, moved step by step."""

    def __init__(self, k: float = 2.0, rings: int = 16, spokes: int = 32, damping: float = 0.0) -> None:
        grid = even_grid(rings, spokes)
        self.tips = tips_of(1, mu=0.8, stiffness=1e8, damping=damping)
        self.contacts = grid.contacts(self.tips)
        self.contacts.load[:] = grid.load(np.array([k]))
        self.bristle = self.contacts.bristles[0]

    def move(self, vx: float, vy: float, spin: float, dt: float = 1e-3, N: float = 2.0, a: float = 4e-3):
        self.tips["force"], self.tips["a"] = N, a
        kernels.rub(self.contacts, 0, vx, vy, spin, dt)
        found = ("pull_x", "pull_y", "torque", "sliding_share", "slip_speed")
        return tuple(float(self.tips[name][0]) for name in found)


@pytest.mark.parametrize("k", GOLDEN)
@pytest.mark.parametrize("point", [1, 2, 3, 4])
def test_sliding_about_a_centre_ends_on_the_exact_limit_surface(k, point) -> None:
    """The bristles find the limit surface by themselves: it is nowhere in their law."""
    d, f, m = GOLDEN[k][point]
    bench, a, mu_N = Bench(k, 32, 64), 4e-3, 1.6
    for _ in range(4000):
        fx, fy, torque, sliding, _ = bench.move(0.0, -1.0 * d * a, 1.0)
    assert sliding > 0.95
    assert fx == pytest.approx(0.0, abs=1e-3)
    assert abs(fy) / mu_N == pytest.approx(f, abs=3e-3)
    assert abs(torque) / (mu_N * a) == pytest.approx(m, abs=3e-3)


def test_presliding_is_elastic_and_as_stiff_as_the_bristles() -> None:
    bench = Bench()
    fx, _, _, sliding, _ = bench.move(1e-6, 0.0, 0.0, dt=1e-3)
    assert fx == pytest.approx(1e8 * np.pi * (4e-3) ** 2 * 1e-9, rel=1e-9)
    assert sliding == 0.0


def test_pull_never_exceeds_coulomb_and_slides_at_it() -> None:
    bench = Bench(damping=3e-3)
    forces = [bench.move(1e-3, 0.0, 0.0)[0] for _ in range(2000)]
    assert max(forces) <= 1.6 * (1.0 + 1e-12)
    assert forces[-1] == pytest.approx(1.6, rel=1e-9)
    assert np.all(np.diff(forces) > -1e-9)


def test_patch_slips_from_the_rim_inwards() -> None:
    bench = Bench()
    while (moved := bench.move(1e-3, 0.0, 0.0))[4] == 0.0:
        pass
    assert moved[0] < 1.6
    tension = np.hypot(*np.moveaxis(bench.bristle, -1, 0))
    assert tension[-1].max() < tension[0].min()  # the rim has let go, the middle holds


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)])
def test_pull_gives_a_force_in_its_own_direction_and_no_torque(direction) -> None:
    bench = Bench()
    for _ in range(1500):
        fx, fy, torque, _, _ = bench.move(1e-3 * direction[0], 1e-3 * direction[1], 0.0)
    assert (fx, fy) == pytest.approx((1.6 * direction[0], 1.6 * direction[1]), abs=1e-6)
    assert torque == pytest.approx(0.0, abs=1e-9)


def test_a_closed_cycle_of_motion_only_costs_energy() -> None:
    bench, work = Bench(), 0.0
    for phase in np.linspace(0.0, 6.0 * np.pi, 3000):
        v, spin = 2e-3 * np.cos(phase), 0.2 * np.sin(phase)
        fx, fy, torque, _, _ = bench.move(v, 0.3 * v, spin)
        work += (fx * v + fy * 0.3 * v + torque * spin) * 1e-3
    assert work > 1e-3 * 1.6 * 2e-3  # a good part of the limit force times the path


def test_lifted_patch_forgets_its_bristles() -> None:
    bench = Bench()
    bench.move(1e-3, 0.0, 0.0)
    assert bench.move(0.0, 0.0, 0.0, N=0.0) == (0.0, 0.0, 0.0, 0.0, 0.0)
    assert not bench.bristle.any()


def test_less_normal_force_sheds_traction() -> None:
    bench = Bench()
    for _ in range(1000):
        bench.move(1e-3, 0.0, 0.0)
    assert bench.move(0.0, 0.0, 0.0, N=1.0)[0] == pytest.approx(0.8, rel=1e-9)


def limit_by_bisection(load, grid, f, m):
    low, high = 0.0, 1.0
    while high - low >= 1e-13:
        part = 0.5 * (low + high)
        there_f, there_m = kernels.limit_point(load, grid.rings, grid.rays, part / (1.0 - part))
        low, high = (part, high) if there_f * m < there_m * f else (low, part)
    return math.hypot(there_f, there_m)


def test_the_limit_along_a_load_is_that_of_bisection():
    grid, rng = even_grid(8, 16), np.random.default_rng(0)
    loads = [(1.0, 0.0), (0.0, 1.0), (1.0, 1e-9), (1e-9, 1.0), *10.0 ** rng.uniform(-4.0, 0.0, (60, 2))]
    for f, m in loads:
        load = grid.load(rng.uniform(1.5, 8.0, 1))[0]
        found = kernels.limit_along(load, grid.rings, grid.rays, f, m)
        assert found == pytest.approx(limit_by_bisection(load, grid, f, m), rel=1e-12)
