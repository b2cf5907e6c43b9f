"""Three controllers of common practice, to compare with.

* :class:`ConstantGrip`: one force for everything, as a parallel gripper has.
* :class:`FrictionCone`: Coulomb's cone with a safety factor, ``N = (1 + safety) |f_t| / mu``
  [WestlingJohansson1984]_. It follows the load but knows neither torsion nor relaxation nor how sure
  the friction coefficient is.
* :class:`ElasticSurface`: a tenth more than the least force by the limit surface of an elastic contact, with
  friction and radius law set by hand for the object and a frozen pressure exponent
  [CostanzoDeMariaNatale2020]_. It knows torsion, but neither relaxation nor how sure anything is. (Their
  controller adds a term against felt motion, which is not part of this rule.)

All pass the same balance, fail-safe and limits as the margin grip. How they were tuned for the comparison is
in ``docs/demo.md``.
"""

import math
from dataclasses import dataclass

from vegrip.config import parameter
from vegrip.contact.limit_surface.fast import least_normal_force
from vegrip.grip.policies.demand import Demand
from vegrip.grip.policies.policy import PolicyKind
from vegrip.grip.safety.limits import MAX_FORCE_N
from vegrip.messages import Reason


@dataclass(frozen=True)
class ConstantSettings:
    """The constant grip."""

    force: float = parameter(5.0, unit="N", low=0.0, high=MAX_FORCE_N, doc="grip force of every finger")


@dataclass(frozen=True)
class ConeSettings:
    """Coulomb's cone with a safety factor."""

    friction: float = parameter(
        0.8, unit="1", low=0.01, high=10.0, doc="friction coefficient, believed known"
    )
    safety: float = parameter(0.5, unit="1", low=0.0, high=10.0, doc="part of the force on top")


@dataclass(frozen=True)
class ElasticSettings:
    """The limit surface of an elastic contact, ``a = radius N^power`` with N in newtons."""

    friction: float = parameter(
        0.8, unit="1", low=0.01, high=10.0, doc="friction coefficient, believed known"
    )
    safety: float = parameter(0.1, unit="1", low=0.0, high=10.0, doc="part of the force on top")
    radius: float = parameter(3.4e-3, unit="m", low=1e-9, high=1.0, doc="contact radius at 1 N")
    power: float = parameter(1.0 / 3.0, unit="1", low=0.0, high=1.0, doc="of the radius law; 1/3 is Hertz")
    exponent: float = parameter(4.0, unit="1", low=1.0, high=100.0, doc="pressure exponent k")


class ConstantGrip:
    """The same force, whatever happens."""

    uses_least_force = False

    def __init__(self, settings: ConstantSettings) -> None:
        self.settings = settings

    def reset(self) -> None:
        """Nothing to forget."""

    def wanted(self, held: float, demand: Demand, dt: float) -> tuple[float, Reason]:
        """Return the constant force [N]."""
        del demand, dt
        return self.settings.force, _direction(held, self.settings.force)


class FrictionCone:
    """Normal force in proportion to the present tangential force."""

    uses_least_force = False

    def __init__(self, settings: ConeSettings) -> None:
        self.settings = settings

    def reset(self) -> None:
        """Nothing to forget."""

    def wanted(self, held: float, demand: Demand, dt: float) -> tuple[float, Reason]:
        """Return ``(1 + safety) |f_t| / mu`` [N]; a load that was not measured holds."""
        del dt
        if not demand.tangential_force >= 0.0:  # NaN too
            return held, Reason.UNTRUSTED
        force = (1.0 + self.settings.safety) * demand.tangential_force / self.settings.friction
        return force, _direction(held, force)


class ElasticSurface:
    """A fixed share more than the least force of an elastic contact."""

    uses_least_force = False

    def __init__(self, settings: ElasticSettings) -> None:
        self.settings = settings

    def reset(self) -> None:
        """Nothing to forget."""

    def wanted(self, held: float, demand: Demand, dt: float) -> tuple[float, Reason]:
        """Return ``(1 + safety)`` times the least force [N]; a load that was not measured holds."""
        del dt
        s = self.settings
        torque = 0.0 if math.isnan(demand.torque) else demand.torque
        least = least_normal_force(
            demand.tangential_force, torque, s.friction, s.radius, s.exponent, 1.0, s.power, 0.0
        )
        if math.isnan(least):
            return held, Reason.UNTRUSTED
        force = (1.0 + s.safety) * least
        return force, _direction(held, force)


def _direction(held: float, force: float) -> Reason:
    if force > held:
        return Reason.RAISE
    return Reason.LOWER if force < held else Reason.HOLD


CONSTANT = PolicyKind(ConstantGrip, ConstantSettings, "constant")
CONE = PolicyKind(FrictionCone, ConeSettings, "cone")
ELASTIC = PolicyKind(ElasticSurface, ElasticSettings, "elastic")
