r"""The load of opposed fingers from a force sensor at the wrist. Pure.

What is squeezed cancels at the wrist, so the sensor there feels the gripper, the object, and what pulls at
it. With the reading :math:`F_0` of the empty gripper (the tare), the slow mean :math:`W` of
:math:`F - F_0` is the object's weight, of the mass :math:`m = |W| / g`, and the rest :math:`D` is inertia,
of object and gripper together, or a pull at the object. Of inertia the object's share is
:math:`\rho = m / (m + m_g)` with the stated mass of the gripper; that it may all be a pull is the uncertainty
:math:`(1 - \rho) |D| / 2`, of which two standard deviations are counted::

    L = |W + rho D| + (1 - rho) |D|

Of the load L a finger carries ``share`` (0.5 +- 0.15: two pads shared 64 : 36 at 750 g,
robertburk/ME_THESIS_ROBERT_BURKE), which enters as the uncertain gain of a tangential force. Directions are
not distinguished: what lies along the closing direction counts as tangential, too. Turning the wrist after
the tare moves the gripper's weight, by up to twice that weight: ``vegrip zero`` takes the tare again.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.messages import FingertipState

GRAVITY: Final = 9.81  # [m/s^2]
TARE_NS: Final = NS  # [ns] in which the empty gripper is weighed
WEIGHT_S: Final = 3.0  # [s] of the slow mean, which shaking at 2 Hz moves by a fortieth
LATE_NS: Final = NS // 5  # [ns] after which a reading says nothing of now


@dataclass(frozen=True)
class LoadSettings:
    """``[load]`` of a launch file."""

    source: str = parameter(doc="'from': the map of the sensor at the wrist, or PRODUCT@PORT")
    mass: float = parameter(unit="kg", low=0.01, high=50.0, doc="of what hangs at the sensor: the gripper")
    share: float = parameter(0.5, unit="1", low=0.05, high=1.0, doc="of the load that a finger carries")
    share_std: float = parameter(0.15, unit="1", low=0.0, high=0.5, doc="its standard deviation")

    @property
    def parameters(self) -> dict[str, Any]:
        """What the grip controller believes of tangential forces that are so shared."""
        return {"tangential_gain": 1.0, "tangential_gain_std": round(self.share_std / self.share, 4)}


class WristLoad:
    """From readings of the wrist to the tangential force of a finger."""

    def __init__(self, settings: LoadSettings) -> None:
        self._mass, self._share = settings.mass, settings.share
        self._load, self._stamp = math.nan, 0
        self.take_tare()

    def take_tare(self) -> None:
        """Weigh the gripper anew from the next reading on: it must be empty."""
        self._tare, self._count, self._began = np.zeros(3), 0, 0
        self._weight = np.zeros(3)
        self._load = math.nan

    def note(self, state: FingertipState) -> None:
        """Take in a reading; its normal force lies along z of the sensor."""
        force = np.array([state.tangential_force_x, state.tangential_force_y, state.normal_force])
        if not np.isfinite(force).all():
            return
        elapsed = max(state.stamp - self._stamp, 0) / NS
        self._stamp = state.stamp
        self._began = self._began or state.stamp
        if state.stamp - self._began < TARE_NS:
            self._count += 1
            self._tare += (force - self._tare) / self._count
            return
        net = force - self._tare
        self._weight += -math.expm1(-elapsed / WEIGHT_S) * (net - self._weight)
        rest = net - self._weight
        mass = math.hypot(*self._weight) / GRAVITY
        part = mass / (mass + self._mass)
        self._load = math.hypot(*(self._weight + part * rest)) + (1.0 - part) * math.hypot(*rest)

    def share(self, now: int) -> float:
        """Return the tangential force of a finger [N] at ``now`` [ns], NaN while it is not known."""
        return self._share * self._load if now - self._stamp < LATE_NS else math.nan


def without_source(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``[load]`` with its key ``from``, which is no name in Python, called ``source``."""
    return {"source" if key == "from" else key: value for key, value in table.items()}
