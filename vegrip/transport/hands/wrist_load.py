r"""The load of opposed fingers from a force and torque sensor at the wrist. Pure.

What is squeezed cancels at the wrist, so the sensor there feels the gripper, the object, and what pulls at
it. With the reading :math:`F_0` of the empty gripper (the tare), the slow mean :math:`W` of
:math:`F - F_0` is the object's weight, of the mass :math:`m = |W| / g`, and the rest :math:`D` is inertia,
of object and gripper together, or a pull at the object. Of inertia the object's share is
:math:`\rho = m / (m + m_g)` with the stated mass of the gripper, of a pull all of it: it is loaded with the
mean of both, give or take half their difference, which counts as two standard deviations. A finger carries
``share`` of that (0.5 +- 0.15: two pads shared 64 : 36 at 750 g, robertburk/ME_THESIS_ROBERT_BURKE), which
enters as the uncertain gain of a tangential force. Both are independent, so with b, two relative standard
deviations of the share, the load

.. math:: L = \frac{L_0 + \sqrt{(b L_0)^2 + (1 - \rho)^2 |D|^2 / 4}}{1 + b},
          \qquad L_0 = \left| W + \frac{1 + \rho}{2} D \right|

is that whose bound of two, :math:`L (1 + b)`, is that of both together. Directions are not told apart: what
lies along the closing direction counts as tangential, too.

The contacts of two jaws lie on the closing direction, z here, so that tangential forces there have no arm
about it: a torque about it is carried by the torsional friction of both contacts alone, which the limit
surface of each weighs against its tangential force. It is, with the grip at :math:`(r_x, r_y)` of the sensor,

.. math:: M = m_z - (r_x F_y - r_y F_x)

and is shared, tared and bounded as the force is. Turning the wrist after the
tare moves the gripper's weight, by up to twice that weight: ``vegrip zero`` takes the tare again.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np

from vegrip.clock import NS
from vegrip.config import build, parameter
from vegrip.errors import ConfigError, suggestion
from vegrip.messages import FingertipState

GRAVITY: Final = 9.81  # [m/s^2]
TARE_NS: Final = NS  # [ns] in which the empty gripper is weighed
WEIGHT_S: Final = 3.0  # [s] of the slow mean, which shaking at 2 Hz moves by a fortieth
MOST_REACH: Final = 1.0  # [m]
LATE_NS: Final = NS // 5  # [ns] after which a reading says nothing of now


@dataclass(frozen=True)
class LoadSettings:
    """``[load]`` of a launch file."""

    source: str = parameter(doc="'from': the map of the sensor at the wrist, or PRODUCT@PORT")
    mass: float = parameter(unit="kg", low=0.01, high=50.0, doc="of what hangs at the sensor: the gripper")
    share: float = parameter(0.5, unit="1", low=0.05, high=1.0, doc="of the load that a finger carries")
    share_std: float = parameter(0.15, unit="1", low=0.0, high=0.5, doc="its standard deviation")
    reach: tuple[float, ...] = parameter(
        (),
        unit="m",
        doc="from the sensor to the grip, along its x and y, z closing; none: torque is not known",
    )

    def __post_init__(self) -> None:
        if self.reach and not (len(self.reach) == 2 and math.hypot(*self.reach) < MOST_REACH):
            raise ConfigError(
                f"'reach' is {list(self.reach)}; it has two values in m, each below {MOST_REACH:g}"
            )

    @property
    def needs(self) -> frozenset[str]:
        """What the sensor must feel."""
        forces = {"tangential_force_x", "tangential_force_y", "normal_force"}
        return frozenset(forces | ({"torque_z"} if self.reach else set()))

    @property
    def parameters(self) -> dict[str, Any]:
        """What the grip controller believes of tangential forces that are so shared."""
        return {"tangential_gain": 1.0, "tangential_gain_std": round(self.share_std / self.share, 4)}


class WristLoad:
    """From readings of the wrist to the tangential force and the torque of a finger."""

    def __init__(self, settings: LoadSettings) -> None:
        self._mass, self._share, self._reach = settings.mass, settings.share, settings.reach
        self._spread = 2.0 * settings.share_std / settings.share
        self._load = self._torque = math.nan
        self._stamp = 0
        self.take_tare()
        self.is_begun = False
        """Whether the gripper has been weighed, or is, or was asked to be."""

    @property
    def is_known(self) -> bool:
        """Whether a load has been told since the gripper was weighed."""
        return not math.isnan(self._load)

    def take_tare(self) -> None:
        """Weigh the gripper anew from the next reading on: it must be empty."""
        self.is_begun = True
        self._tare, self._count, self._began = np.zeros(4), 0, 0
        self._weight = np.zeros(4)
        self._load = self._torque = math.nan

    def note(self, state: FingertipState) -> None:
        """Take in a reading; its normal force lies along z of the sensor."""
        x, y = state.tangential_force_x, state.tangential_force_y
        felt = np.array([x, y, state.normal_force, self._about_grip(x, y, state.torque_z)])
        if not np.isfinite(felt).all():
            return
        self.is_begun = True
        elapsed = max(state.stamp - self._stamp, 0) / NS
        self._stamp = state.stamp
        self._began = self._began or state.stamp
        if state.stamp - self._began < TARE_NS:
            self._count += 1
            self._tare += (felt - self._tare) / self._count
            return
        net = felt - self._tare
        self._weight += -math.expm1(-elapsed / WEIGHT_S) * (net - self._weight)
        rest = net - self._weight
        mass = math.hypot(*self._weight[:3]) / GRAVITY
        part = mass / (mass + self._mass)
        mean, half = self._weight + 0.5 * (1.0 + part) * rest, 0.5 * (1.0 - part)
        self._load = self._bounded(math.hypot(*mean[:3]), half * math.hypot(*rest[:3]))
        if self._reach:
            self._torque = self._bounded(abs(mean[3]), half * abs(rest[3]))

    def share(self, now: int) -> tuple[float, float]:
        """Return tangential force [N] and torque [N m] of a finger at ``now`` [ns], NaN what is not known."""
        share = self._share if now - self._stamp < LATE_NS else math.nan
        return share * self._load, share * self._torque

    def _bounded(self, load: float, unsure: float) -> float:
        """Return the load which, with the spread of its share, bounds one that is ``unsure`` besides."""
        return (load + math.hypot(self._spread * load, unsure)) / (1.0 + self._spread)

    def _about_grip(self, x: float, y: float, torque: float) -> float:
        """Return the torque [N m] about the closing direction at the grip, 0 where nothing is said of it."""
        if not self._reach:
            return 0.0
        arm_x, arm_y = self._reach
        return torque - (arm_x * y - arm_y * x)


def read_load(table: Mapping[str, Any], where: str) -> LoadSettings:
    """Build what a table says whose ``from``, which is no name in Python, is called ``source`` here."""
    names = {"from" if field.name == "source" else field.name: field.name for field in fields(LoadSettings)}
    for key in table:
        if key not in names:
            raise ConfigError(f"{where}: unknown key {key!r}; {suggestion(key, names, 'known are')}")
    if not isinstance(table.get("from"), str):
        raise ConfigError(f"{where} needs from = 'wrist.toml', the map of the sensor at the wrist")
    try:
        return build(LoadSettings, {names[key]: value for key, value in table.items()}, where)
    except ConfigError as error:
        said = str(error)
        raise ConfigError(said if said.startswith(where) else f"{where}: {said}") from None
