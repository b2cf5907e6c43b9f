"""What an estimator must be given: the noise of the sensors, and how it shall behave."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vegrip.config import build, constant, fixed_parameter, parameter
from vegrip.errors import ConfigError
from vegrip.estimator.friction_prior import FrictionPrior


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviation of the white noise of each channel (resolution / sqrt(12) counts as noise)."""

    normal_force: float = parameter(0.01, unit="N", low=1e-18, high=1e6, doc="normal force")
    displacement: float = parameter(5e-6, unit="m", low=1e-18, high=1.0, doc="displacement")
    tangential_force: float = parameter(0.01, unit="N", low=0.0, high=1e6, doc="each component")
    torque_z: float = parameter(1e-4, unit="N m", low=0.0, high=1e6, doc="torque about the normal")
    contact_radius: float = parameter(5e-5, unit="m", low=1e-18, high=1.0, doc="contact radius")
    temperature: float = parameter(0.1, unit="degC", low=0.0, high=100.0, doc="temperature")


@dataclass(frozen=True)
class Sensors:
    """By how much sensors read wrong in proportion: ``read = gain * true``.

    A weight that is lifted measures it (:mod:`vegrip.identification.tangential_gain`). Two silicone pads read
    0.81 to 0.95 of the weight that they held (robertburk/ME_THESIS_ROBERT_BURKE at 6575ffb).
    """

    tangential_gain: float = fixed_parameter(
        0.92, unit="1", low=0.5, high=2.0, doc="tangential force read over the true one"
    )
    tangential_gain_std: float = fixed_parameter(
        0.1,
        unit="1",
        low=0.0,
        high=1.0,
        doc="relative std of the gain; vegrip calibrate --weight measures it",
    )
    fingers: dict[str, Any] = fixed_parameter({}, doc="what is different at a finger, by its name")

    def __post_init__(self) -> None:
        for finger in self.fingers:
            self.of(finger)  # says what cannot be used

    def of(self, finger: str) -> "Sensors":
        """Return those of ``finger``."""
        own = self.fingers.get(finger, {})
        where = f"sensors.fingers.{finger}"
        if not isinstance(own, Mapping):
            raise ConfigError(f"{where} is {own!r}; it must be a table, as {{ tangential_gain = 0.93 }}")
        usual = {"tangential_gain": self.tangential_gain, "tangential_gain_std": self.tangential_gain_std}
        return build(Sensors, usual | dict(own), where)


@dataclass(frozen=True)
class EstimatorSettings:
    """How the estimator behaves; all is relative to the fingertip or the sensors, so any scale works."""

    confidence: float = parameter(0.95, unit="1", low=0.5, high=0.9999, doc="one-sided, of all bounds")
    horizon: float = constant(1.0, unit="s", low=0.0, high=3600.0, doc="forecast of the least force")
    hold: str = parameter("position", choices=("position", "force", "mixed"), doc="what the forecast holds")
    hold_stiffness: float = parameter(
        1000.0, unit="N/m", low=0.0, high=1e12, doc="of the drive behind the tip in a mixed hold"
    )
    surface: str = constant(
        "exact",
        choices=("exact", "ellipse"),
        doc='limit surface; "ellipse", up to 6.5 % too large, to compare',
    )
    agility: float = parameter(
        3.0, unit="1/s", low=1e-3, high=1e4, doc="white acceleration has the density R^2 agility^3"
    )
    force_drift: float = constant(0.1, unit="1", doc="slow force disturbance, in units of the noise")
    force_drift_time: float = constant(2.0, unit="s", low=1e-3, high=1e6, doc="its time constant")
    displacement_drift: float = constant(
        0.1, unit="1", doc="slow displacement disturbance, in units of the noise"
    )
    displacement_drift_time: float = constant(0.5, unit="s", low=1e-3, high=1e6, doc="its time constant")
    force_bias: float = constant(2.0, unit="1", doc="unknown at start, in units of noise")
    offset: float = constant(0.002, unit="1", doc="std of where displacement is zero, in units of the radius")
    learning_rest: float = parameter(
        20.0, unit="s", low=0.0, high=1e6, doc="learned parameters stay after so long without motion"
    )
    longest_gap: float = constant(0.25, unit="s", low=0.0, high=3600.0, doc="beyond it the motion is unknown")
    late: int = constant(16, unit="1", low=0, high=1000, doc="samples among which a late one finds its place")
    recovery: int = constant(15, unit="1", low=1, high=1_000_000, doc="rejections in a row before widening")
    health_time: float = constant(2.0, unit="s", low=1e-3, high=1e6, doc="memory of the consistency check")
    friction_scatter: float = constant(
        0.06, unit="1", doc="of ln mu from one slip to the next, about its mean"
    )
    friction_drift: float = constant(0.03, unit="1/sqrt(s)", doc="forgetting: random walk of ln mu")
    regrasp: float = constant(0.05, unit="1", doc="change of ln mu with a new contact")
    friction: FrictionPrior = constant(
        FrictionPrior(),
        doc="what is believed of friction at first; in a grasp the section 'friction' says it",
    )
