"""What a virtual hand is made of: typed, bounded parameters with units."""

import math
from dataclasses import dataclass, replace

import numpy as np

from vegrip.config import parameter
from vegrip.errors import ConfigError
from vegrip.messages import USUAL_FINGERS
from vegrip.virtual.history import Relaxation, power_law, prony


@dataclass(frozen=True)
class FingertipSettings:
    """One soft fingertip: a sphere cap of viscoelastic material."""

    radius: float = parameter(9e-3, unit="m", low=1e-9, high=1.0, doc="radius of the tip")
    reference_indentation: float = parameter(1e-3, unit="m", low=1e-12, high=0.1, doc="indentation d0")
    reference_force: float = parameter(
        1.8, unit="N", low=1e-15, high=1e4, doc="force at d0, pressed infinitely fast"
    )
    exponent: float = parameter(1.5, unit="1", low=1.0, high=3.0, doc="p of N_e = F0 (delta/d0)^p")
    relaxation: str = parameter("prony", choices=("prony", "power_law"), doc="shape of g(t)")
    amplitudes: tuple[float, ...] = parameter((0.2, 0.1), unit="1", doc="c_i of g; one for a power law")
    rates: tuple[float, ...] = parameter((3.1, 0.15), unit="1/s", doc="nu_i of g; 1/tau of a power law")
    relaxation_exponent: float = parameter(0.15, unit="1", low=0.0, high=1.0, doc="alpha of a power law")
    friction: float = parameter(0.8, unit="1", low=0.01, high=5.0, doc="friction coefficient mu at 5 N")
    friction_exponent: float = parameter(
        0.0, unit="1", low=-0.5, high=0.9, doc="g of mu = friction (N / 5 N)^-g; 0 = Coulomb's law"
    )
    bristle_stiffness: float = parameter(
        8e7, unit="N/m^3", low=0.0, high=1e18, doc="tangential stiffness per area before slip"
    )
    bristle_damping: float = parameter(
        3e-3, unit="s", low=0.0, high=1.0, doc="tangential viscosity over stiffness"
    )

    def __post_init__(self) -> None:
        c, nu = self.amplitudes, self.rates
        if len(c) != len(nu) or any(v <= 0.0 for v in (*c, *nu)) or sum(c) >= 1.0:
            raise ConfigError(
                f"fingertip: amplitudes {c} and rates {nu} must be positive, equally many, and sum(c) < 1"
            )
        if self.relaxation == "power_law" and len(c) != 1:
            raise ConfigError("fingertip: a power law takes one amplitude and one rate")

    def with_one_rate(self) -> "FingertipSettings":
        """Return the tip without its slower relaxation: what the paper's model explains."""
        return replace(self, amplitudes=self.amplitudes[:1], rates=self.rates[:1])

    def relaxing(self, speed: float = 1.0) -> Relaxation:
        """Return g(t) with all rates multiplied by ``speed`` [-]."""
        if self.relaxation == "power_law":
            return power_law(self.amplitudes[0], 1.0 / (speed * self.rates[0]), self.relaxation_exponent)
        return prony(self.amplitudes, [speed * nu for nu in self.rates])


def random_fingertip(rng: np.random.Generator) -> FingertipSettings:
    """Draw a fingertip as different from the next one as soft fingertips are."""
    branches = int(rng.integers(1, 3))
    amplitudes = rng.uniform(0.08, 0.35, branches) / branches
    rates = np.sort(np.exp(rng.uniform(math.log(0.1), math.log(10.0), branches)))[::-1]
    return FingertipSettings(
        radius=float(rng.uniform(5e-3, 15e-3)),
        reference_force=float(np.exp(rng.uniform(math.log(0.5), math.log(4.0)))),
        exponent=float(rng.uniform(1.3, 2.0)),
        amplitudes=tuple(float(c) for c in amplitudes),
        rates=tuple(float(nu) for nu in rates),
        friction=float(rng.uniform(0.4, 1.2)),
        bristle_stiffness=float(np.exp(rng.uniform(math.log(3e7), math.log(3e8)))),
    )


def vary_fingertip(tip: FingertipSettings, spread: float, rng: np.random.Generator) -> FingertipSettings:
    """Return ``tip`` as another piece of the same make: parameters scatter by ``spread`` (relative std)."""
    factor = np.exp(spread * rng.standard_normal(4))
    return replace(
        tip,
        radius=float(tip.radius * factor[0]),
        reference_force=float(tip.reference_force * factor[1]),
        rates=tuple(float(nu * factor[2]) for nu in tip.rates),
        friction=float(tip.friction * factor[3]),
    )


@dataclass(frozen=True)
class ObjectSettings:
    """The plate that the hand holds."""

    mass: float = parameter(0.3, unit="kg", low=1e-3, high=20.0, doc="mass")
    inertia: float = parameter(6e-4, unit="kg m^2", low=1e-8, high=1.0, doc="about the face normal")
    offset_x: float = parameter(4e-3, unit="m", low=-0.2, high=0.2, doc="centre of mass from the grasp")
    offset_y: float = parameter(-0.01, unit="m", low=-0.2, high=0.2, doc="centre of mass from the grasp")
    gravity: float = parameter(9.81, unit="m/s^2", low=0.0, high=30.0, doc="along -y when not turned")
    drop_distance: float = parameter(0.04, unit="m", low=1e-3, high=1.0, doc="lost after sliding this far")
    drop_angle: float = parameter(1.2, unit="rad", low=0.05, high=6.3, doc="lost after turning this far")


@dataclass(frozen=True)
class ActuatorSettings:
    """The force-controlled drives behind the fingertips."""

    initial_force: float = parameter(3.0, unit="N", low=0.0, high=1e3, doc="of each opposed finger at start")
    close_time: float = parameter(
        0.6, unit="s", low=0.0, high=10.0, doc="the hand closes by itself, the object rests on a stand"
    )
    lift_time: float = parameter(0.4, unit="s", low=0.0, high=10.0, doc="the stand gives way after closing")
    bandwidth: float = parameter(12.0, unit="Hz", low=0.1, high=100.0, doc="of the force loop")
    force_rate: float = parameter(60.0, unit="N/s", low=0.1, high=1e5, doc="fastest change of force")
    speed: float = parameter(0.08, unit="m/s", low=1e-4, high=10.0, doc="fastest motion")
    stiction: float = parameter(0.01, unit="N", low=0.0, high=10.0, doc="force error that moves nothing")
    force_limit: float = parameter(
        20.0, unit="N", low=0.1, high=1e4, doc="greatest force of an opposed finger"
    )


@dataclass(frozen=True)
class SensorSettings:
    """What the fingertips report: standard deviations, resolutions, faults."""

    rate: float = parameter(500.0, unit="Hz", low=1.0, high=2000.0, doc="states per second and finger")
    normal_force: float = parameter(0.01, unit="N", low=0.0, high=1e3, doc="noise")
    tangential_force: float = parameter(0.01, unit="N", low=0.0, high=1e3, doc="noise")
    torque_z: float = parameter(1e-4, unit="N m", low=0.0, high=10.0, doc="noise")
    displacement: float = parameter(5e-6, unit="m", low=0.0, high=0.1, doc="noise")
    tangential_gain: float = parameter(
        1.0, unit="1", low=0.5, high=2.0, doc="measured tangential force over the true one"
    )
    temperature: float = parameter(0.05, unit="degC", low=0.0, high=10.0, doc="noise")
    slip_speed: float = parameter(5e-5, unit="m/s", low=0.0, high=1.0, doc="noise")
    contact_radius: float = parameter(5e-5, unit="m", low=0.0, high=0.1, doc="noise")
    force_bias: float = parameter(5e-3, unit="N", low=0.0, high=1e3, doc="std of the constant error")
    displacement_bias: float = parameter(2e-6, unit="m", low=0.0, high=0.1, doc="std of the constant error")
    force_step: float = parameter(2e-3, unit="N", low=0.0, high=10.0, doc="resolution, 0 = exact")
    displacement_step: float = parameter(1e-6, unit="m", low=0.0, high=0.1, doc="resolution, 0 = exact")
    torque_step: float = parameter(2e-5, unit="N m", low=0.0, high=1.0, doc="resolution, 0 = exact")
    slip_sensor: bool = parameter(True, doc="the tips feel slip and its speed")
    slip_threshold: float = parameter(
        1e-4, unit="m/s", low=0.0, high=1.0,
        doc="slip speed from which the tips feel slip; twice its noise: less is lost in that",
    )  # fmt: skip
    slip_delay: float = parameter(
        0.02, unit="s", low=0.0, high=0.1, doc="by which slip flag and slip speed are late"
    )
    radius_sensor: bool = parameter(False, doc="a camera or tactile array sees the contact radius")
    jitter: float = parameter(0.0, unit="s", low=0.0, high=0.01, doc="std of the time of a sample")
    dropout: float = parameter(0.0, unit="1", low=0.0, high=1.0, doc="share of the samples that get lost")


@dataclass(frozen=True)
class ThermalSettings:
    """Slow warming of the tips by the drives and the grasp."""

    warming: bool = parameter(False, doc="temperature changes, and the material with it")
    start: float = parameter(22.0, unit="degC", low=-40.0, high=100.0, doc="at the beginning")
    rise: float = parameter(8.0, unit="degC", low=-50.0, high=50.0, doc="in the long run")
    time: float = parameter(300.0, unit="s", low=1.0, high=1e6, doc="time constant")
    softening: float = parameter(4e-3, unit="1/degC", low=0.0, high=0.05, doc="relative loss of stiffness")
    quickening: float = parameter(0.03, unit="1/degC", low=0.0, high=0.3, doc="rates grow as exp(this dT)")


@dataclass(frozen=True)
class HandSettings:
    """The whole virtual hand. The first finger opposes all the others."""

    fingers: tuple[str, ...] = parameter(USUAL_FINGERS, doc="names")
    x: tuple[float, ...] = parameter((0.0, -0.033, -0.011, 0.011, 0.033), unit="m", doc="contact places")
    y: tuple[float, ...] = parameter((0.0, 0.0, 0.004, 0.003, -0.004), unit="m", doc="contact places")
    opposing_radius: float = parameter(13e-3, unit="m", low=1e-9, high=1.0, doc="tip radius, first finger")
    opposing_stiffness: float = parameter(
        2.0, unit="1", low=0.01, high=100.0, doc="stiffness of the first finger against the others"
    )
    spread: float = parameter(0.08, unit="1", low=0.0, high=0.5, doc="scatter between fingertips")
    step: float = parameter(1e-3, unit="s", low=1e-5, high=2e-3, doc="of the simulation")
    rings: int = parameter(8, unit="1", low=2, high=200, doc="of elements of a contact patch")
    spokes: int = parameter(16, unit="1", low=4, high=400, doc="elements on a ring")
    tip: FingertipSettings = FingertipSettings()  # an opposed fingertip
    plate: ObjectSettings = ObjectSettings()  # the object
    actuator: ActuatorSettings = ActuatorSettings()  # the drives
    sensor: SensorSettings = SensorSettings()  # what is reported
    thermal: ThermalSettings = ThermalSettings()  # warming

    def __post_init__(self) -> None:
        if not len(self.fingers) == len(self.x) == len(self.y) or len(self.fingers) < 2:
            raise ConfigError("hand: fingers, x and y must be equally many, two or more")
        if len(set(self.fingers)) != len(self.fingers):
            raise ConfigError(f"hand: a finger is named twice in {', '.join(self.fingers)}")

    def tips(self, rng: np.random.Generator) -> tuple[FingertipSettings, ...]:
        """Return the fingertips of one hand of this make, in the order of ``fingers``."""
        opposing = replace(
            self.tip,
            radius=self.opposing_radius,
            reference_force=self.opposing_stiffness * self.tip.reference_force,
        )
        makes = [opposing] + [self.tip] * (len(self.fingers) - 1)
        return tuple(vary_fingertip(make, self.spread, rng) for make in makes)
