"""The held object: a plate with parallel faces that moves in its own plane, carried by friction alone."""

import math

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import kernels
from vegrip.virtual.disturbance import Burden
from vegrip.virtual.patch import Grid
from vegrip.virtual.settings import FingertipSettings, ObjectSettings

COURANT = 0.4
"""Greatest phase and damping per substep of the fastest vibration of the plate on its bristles."""


class Plate:
    """Pose and motion of the plate, and the friction patches that carry it.

    Hand frame: x, y in the plane of the plate, y up; the centre of mass starts at the offset of the
    settings. The faces stay parallel: what would tilt the plate out of its plane is not modelled.
    """

    def __init__(
        self,
        settings: ObjectSettings,
        tips: tuple[FingertipSettings, ...],
        place: Floats,
        grid: Grid,
    ) -> None:
        n = len(tips)
        self.settings, self.grid, self.place = settings, grid, place
        self.pose = np.array([settings.offset_x, settings.offset_y, 0.0, 0.0, 0.0, 0.0])  # and its rate
        self.start = self.pose[:3].copy()
        self.stiffness = np.array([tip.bristle_stiffness for tip in tips])
        self.damping = np.array([tip.bristle_damping for tip in tips])
        self.bristle = grid.bristles(n)
        self.laws = np.array([
            settings.mass, settings.inertia, settings.gravity, settings.drop_distance, settings.drop_angle,
            COURANT,
        ])  # fmt: skip
        self.wrench = np.zeros(
            (n, 3)
        )  # of the plate on each finger, hand frame: force x, y [N], torque [N m]
        self.slip = np.zeros((n, 3))  # sliding [-], slip speed [m/s], distance slid so far [m]

    @property
    def shift(self) -> Floats:
        """How far the plate has moved from where it was grasped: x, y [m], angle [rad]."""
        moved: Floats = self.pose[:3] - self.start
        return moved

    @property
    def lost(self) -> bool:
        """Whether the plate has slid or turned out of the grasp."""
        x, y, angle = self.shift
        s = self.settings
        return math.hypot(x, y) > s.drop_distance or abs(angle) > s.drop_angle

    def carry(
        self, a: Floats, N: Floats, load: Floats, mu: Floats, burden: Burden, stand: float, dt: float
    ) -> None:
        """Move for ``dt`` [s] with contact radii a [m], normal forces N [N], friction mu and what acts on it.

        ``load`` is the pressure on the grid (n, R); ``stand`` the share of gravity carried by a stand.
        """
        s, grid = self.settings, self.grid
        mass = s.mass + burden.mass
        weight = (1.0 - stand) * mass * s.gravity
        applied = np.array([
            burden.force_x + weight * math.sin(burden.turn),
            burden.force_y - weight * math.cos(burden.turn),
            burden.torque,
        ])  # fmt: skip
        substeps = self.substeps(a, mass, dt)
        kernels.carry(
            self.pose, self.bristle, self.wrench, self.slip,
            load, grid.area, grid.reach, grid.cosine, grid.sine,
            a, N, mu, self.stiffness, self.damping, self.place,
            mass, s.inertia, applied, substeps, dt / substeps,
        )  # fmt: skip

    def substeps(self, a: Floats, mass: float, dt: float) -> int:
        """Return how finely to divide a step to stay far inside the stability limit."""
        return kernels.substeps_of(
            self.pose, self.place, a, self.stiffness, self.damping, mass, self.settings.inertia, COURANT, dt
        )
