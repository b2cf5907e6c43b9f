"""Three controllers of common practice, to compare with (:mod:`vegrip.grip.kernels.choice` computes them).

* ``constant``: one force for everything, as a parallel gripper has.
* ``cone``: Coulomb's cone with a safety factor, ``N = (1 + safety) |f_t| / mu``
  [WestlingJohansson1984]_. It follows the load but knows neither torsion nor relaxation nor how sure
  the friction coefficient is.
* ``elastic``: a tenth more than the least force by the limit surface of an elastic contact, with
  friction and radius law set by hand for the object and a frozen pressure exponent
  [CostanzoDeMariaNatale2020]_. It knows torsion, but neither relaxation nor how sure anything is. (Their
  controller adds a term against felt motion, which is not part of this rule.)

All pass the same balance, fail-safe and limits as the margin grip. How they were tuned for the comparison is
in ``docs/grip-quality.md``.
"""

from dataclasses import dataclass

from vegrip.config import constant, parameter
from vegrip.grip.policies.policy import PolicyKind
from vegrip.grip.safety import MAX_FORCE_N


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
    safety: float = parameter(0.5, unit="1", low=0.0, high=100.0, doc="part of the force on top")


@dataclass(frozen=True)
class ElasticSettings:
    """The limit surface of an elastic contact, ``a = radius N^power`` with N in newtons."""

    friction: float = parameter(
        0.8, unit="1", low=0.01, high=10.0, doc="friction coefficient, believed known"
    )
    safety: float = parameter(0.1, unit="1", low=0.0, high=10.0, doc="part of the force on top")
    radius: float = parameter(3.4e-3, unit="m", low=1e-9, high=1.0, doc="contact radius at 1 N")
    power: float = constant(1.0 / 3.0, unit="1", doc="of the radius law; 1/3 is Hertz")
    exponent: float = constant(4.0, unit="1", doc="pressure exponent k")


CONSTANT = PolicyKind(None, ConstantSettings)
CONE = PolicyKind(None, ConeSettings)
ELASTIC = PolicyKind(None, ElasticSettings)
