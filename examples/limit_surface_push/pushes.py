"""A block pushed over a plate: measured loads and slips, and what a pressure distribution says of them.

Loads (f_x [N], f_y [N], m [N m]) and slips (d_x [m], d_y [m], d_theta [rad]) are about the centre of mass, in
the frame of the block. Angles and lengths of loads and slips are taken with torques divided, and rotations
multiplied, by the size of the support, so that all three components count alike.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vegrip.contact.limit_surface import queries
from vegrip.contact.limit_surface.pressure_map import PressureMap, bound_gauge, polygon_map

Array = NDArray[np.float64]

CORNERS = np.array([[-0.05, -0.05], [0.10, -0.05], [-0.05, 0.10]])  # [m] from the centre of mass
NEAR = 0.25  # of the size: as near to a foot the measured slip centre counts as on it


def feet(low: float, high: float) -> PressureMap:
    """Three feet at (low, low), (high, low), (low, high) [m] from the right-angled corner."""
    return PressureMap(CORNERS[0] + [[low, low], [high, low], [low, high]], np.ones(3))


def rim(points: int = 60) -> PressureMap:
    """The face resting on its three edges alone, evenly."""
    s = (np.arange(points) + 0.5)[:, None] / points
    edges = [
        (p + s * (q - p), np.linalg.norm(q - p))
        for p, q in zip(CORNERS, np.roll(CORNERS, -1, 0), strict=True)
    ]
    return PressureMap(
        np.concatenate([e for e, _ in edges]), np.repeat([length for _, length in edges], points)
    )


SUPPORTS = {
    "hardboard_patch": polygon_map(CORNERS, order=24),
    "hardboard_3pt_30_90": feet(0.03, 0.09),
    "hardboard_3pt_10_130": feet(0.01, 0.13),
    "plywood_3pt_30_90": feet(0.03, 0.09),
}


@dataclass(frozen=True)
class Pushes:
    """Loads (n, 3) and slips (n, 3) of one set of pushes."""

    loads: Array
    slips: Array


def read_pushes(folder: Path, name: str) -> Pushes:
    """Read the loads and slips derived from the force and pose logs of one set."""
    table = np.genfromtxt(folder / f"{name}_wrench_derived.csv", delimiter=",", names=True)
    columns = ("fx_obj_N", "fy_obj_N", "tau_com_Nm"), ("dx_obj_m", "dy_obj_m", "dtheta_rad")
    return Pushes(*(np.stack([table[column] for column in group], axis=1) for group in columns))


class Surface(Protocol):
    """A limit surface in newtons over mu N: of a pressure map or of the smooth profile."""

    def limit(self, loads: Array) -> tuple[Array, Array]:
        """Gauge (n,) of the loads (n, 3), which is their mu N at the limit, and slips (n, 3) they start."""

    def load(self, slips: Array, near: Array) -> Array:
        """Load (n, 3) per mu N of the slips (n, 3); where several are possible the nearest to `near`."""


@dataclass(frozen=True)
class Mapped:
    """The surface of the points that really carry the block."""

    support: PressureMap

    def limit(self, loads: Array) -> tuple[Array, Array]:
        """By the certified gauge, load after load."""
        bounds = [bound_gauge(self.support, load) for load in loads]
        return np.array([b.upper for b in bounds]), np.array([b.twist for b in bounds])

    def load(self, slips: Array, near: Array) -> Array:
        """By the friction of every point; of a foot that stands still it may be any."""
        loads = self.support.load(slips)
        if len(self.support.shares) > 3:
            return loads  # facets too small to matter
        centres = slip_centres(slips)
        for i, centre in enumerate(centres):
            distance = np.linalg.norm(self.support.positions - centre, axis=1)
            if distance.min() < NEAR * self.support.size:
                loads[i] = self._on_facet(int(distance.argmin()), slips[i, 2], near[i])
        return loads

    def _on_facet(self, foot: int, spin: float, near: Array) -> Array:
        facet = self.support.facet(foot, spin)
        scale = np.array([1.0, 1.0, 1.0 / self.support.size])
        friction, *_ = np.linalg.lstsq((facet.axes * scale).T, (near - facet.centre) * scale)
        return facet.centre + friction / max(1.0, float(np.linalg.norm(friction))) @ facet.axes


@dataclass(frozen=True)
class Smooth:
    """The surface of a round contact with the smooth profile of exponent k and the radius a [m]."""

    a: float
    k: float = 2.0

    def limit(self, loads: Array) -> tuple[Array, Array]:
        """By the fast limit surface."""
        force = np.linalg.norm(loads[:, :2], axis=1)
        gauge = queries.gauge(self.k, force, loads[:, 2] / self.a)
        v, omega = queries.slip_twist(self.k, force, loads[:, 2] / self.a)
        return gauge, np.column_stack([loads[:, :2] / force[:, None] * v[:, None], omega / self.a])

    def load(self, slips: Array, near: Array) -> Array:  # noqa: ARG002 - a smooth surface has one load a slip
        """By the point of the slip centre's distance."""
        speed = np.linalg.norm(slips[:, :2], axis=1)
        f, m = queries.point(self.k, speed / np.abs(slips[:, 2]) / self.a)
        return np.column_stack([slips[:, :2] * (f / speed)[:, None], m * self.a * np.sign(slips[:, 2])])


@dataclass(frozen=True)
class Errors:
    """How far a surface is from one set of pushes."""

    friction: float  # [N] mu N, the median over the pushes
    limit_scatter: float  # standard deviation of the limit along the measured load, over mu N
    slip_angle: float  # [deg] median angle between predicted and measured slip
    load_error: float  # median distance of the load predicted from the slip, over mu N


def judge(surface: Surface, pushes: Pushes, size: float) -> Errors:
    """Predict slips and limits from loads, and loads from slips; mu N is fitted, nothing else."""
    gauges, slips = surface.limit(pushes.loads)
    friction = float(np.median(gauges))
    loads = surface.load(pushes.slips, pushes.loads / friction)
    off = (loads - pushes.loads / friction) / [1.0, 1.0, size]
    return Errors(
        friction,
        float(np.std(gauges) / friction),
        float(np.median(angles(slips, pushes.slips, size))),
        float(np.median(np.linalg.norm(off, axis=1))),
    )


def angles(one: Array, two: Array, size: float) -> Array:
    """Angles [deg] between slips (n, 3)."""
    one, two = (slip * [1.0, 1.0, size] for slip in (one, two))
    cosine = (one * two).sum(axis=1) / np.linalg.norm(one, axis=1) / np.linalg.norm(two, axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def slip_centres(slips: Array) -> Array:
    """Centres of rotation (n, 2) [m] of the slips (n, 3)."""
    return np.column_stack([-slips[:, 1], slips[:, 0]]) / slips[:, 2:]
