"""Hidden effects: what a trial can have beyond the plain fingertip, for finding out what a diagnosis finds.

They share nothing with :mod:`vegrip.effects` but the names: their parameters are plain SI numbers, their
memory is integrated in the small steps of the trial. They are switched on by
``run_trial(..., hidden={"adhesion": {"force": 0.05}})``.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from vegrip.errors import ConfigError
from vegrip.types import Floats
from vegrip.virtual.history import Relaxation, prony

HIDDEN: dict[str, type["Hidden"]] = {}
"""By the names that a diagnosis gives them."""
LAG_SUBSTEPS = 8  # steps of the lag within a step of the trial


def lasting(value: Any = 0.0) -> Any:
    return field(default=value, init=False)


def fresh(value: Any = 0.0) -> Any:
    return field(default=value, init=False, metadata={"fresh": value})


@dataclass
class Hidden:
    """Something that the simulated fingertip has beyond the plain one. All quantities are scalars, SI.

    Each method leaves things as they are.
    """

    compliance = 0.0
    """Of what carries the tip [m/N]."""

    def __init_subclass__(cls, name: str = "") -> None:
        if name:
            HIDDEN[name] = cls

    def start(self, pause: float) -> None:
        """Begin an episode after ``pause`` [s] of rest, in which what recovers has recovered."""
        for one in fields(self):
            if "fresh" in one.metadata:
                setattr(self, one.name, one.metadata["fresh"])

    def relaxation(self, g: Relaxation) -> Relaxation:
        return g

    def moved(self, position: float) -> float:
        """Return how far the mount of the tip moves [m] when the drive stands at ``position``."""
        return position

    def drive(self, mount: float) -> float:
        """Return where the drive stands [m] when the mount is at ``mount``; the inverse of :meth:`moved`."""
        return mount

    def indentation(self, x: float) -> float:
        """Return the indentation that the material feels [m] of the geometric one."""
        return x

    def elastic(self, force: float, x: float) -> float:
        """Return the elastic force [N] at the indentation ``x`` that is felt."""
        return force

    def more(self, x: float, elastic: float) -> float:
        """Return what the material pushes more [N] at the end of a step than its relaxing past implies.

        There the indentation is ``x`` [m] and the elastic force ``elastic`` [N].
        """
        return 0.0

    def pull(self, x: float) -> float:
        """Return the attraction of the surfaces [N] at indentation ``x``; negative x is a gap."""
        return 0.0

    def remember(self, x: float, force: float, dt: float) -> None:
        """Close a step of ``dt`` [s] that ended at indentation ``x`` [m] and normal force ``force`` [N]."""

    def strained(self, elastic: float, x: float, dt: float) -> None:
        """Close a step of ``dt`` [s] that ended at the elastic force ``elastic`` [N], indentation ``x``."""

    def warmed(self, temperature: float) -> None:
        """Take the temperature [degrees Celsius] of the coming episode."""

    def radius(self, a: float, x: float, tip_radius: float) -> float:
        """Return the contact radius [m]."""
        return a

    def flattened(self, k: float) -> float:
        """Return the pressure exponent [-]."""
        return k

    def friction(self, mu: float, force: float, speed: float) -> float:
        """Return the friction coefficient at normal force [N] and slip speed [m/s] of the step before."""
        return mu

    def rubbed(self, force: float, speed: float, dt: float) -> None:
        """Close the tangential step of ``dt`` [s] in which the patch slid at ``speed`` [m/s]."""

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        """Return what the normal force sensor shows [N], the drive at ``drive`` [m]; once in every step."""
        return shown


@dataclass
class Clocked(Hidden):
    """Knows how late it is in the session [s], pauses included."""

    time_passed: float = lasting()
    _started: bool = lasting(False)

    def start(self, pause: float) -> None:
        super().start(pause)
        self.time_passed += pause if self._started else 0.0
        self._started = True

    def remember(self, x: float, force: float, dt: float) -> None:
        self.time_passed += dt


# the material


@dataclass
class SecondRelaxation(Hidden, name="second_relaxation"):
    """One more exponential."""

    amplitude: float = 0.1  # [-]
    rate: float = 0.2  # [1/s]

    def relaxation(self, g: Relaxation) -> Relaxation:
        def more(t: Floats) -> Floats:
            left: Floats = g(t) + self.amplitude * np.expm1(-self.rate * t)
            return left

        return more


@dataclass
class PowerLawRelaxation(Hidden, name="power_law_relaxation"):
    """A share that relaxes as ``(1 + t / time)^-exponent``."""

    amplitude: float = 0.3  # [-]
    time: float = 0.01  # [s]
    exponent: float = 0.1  # [-]

    def relaxation(self, g: Relaxation) -> Relaxation:
        def more(t: Floats) -> Floats:
            left: Floats = g(t) - self.amplitude * (1.0 - (1.0 + t / self.time) ** -self.exponent)
            return left

        return more


@dataclass
class RelaxationSpectrum(Hidden, name="relaxation_spectrum"):
    """Two more exponentials, one slower and one faster than the fingertip's own."""

    amplitude: float = 0.08  # [-] of each
    slow: float = 0.1  # [1/s]
    fast: float = 40.0  # [1/s]

    def relaxation(self, g: Relaxation) -> Relaxation:
        more = prony((self.amplitude, self.amplitude), (self.slow, self.fast))

        def all_three(t: Floats) -> Floats:
            left: Floats = g(t) + more(t) - 1.0
            return left

        return all_three


@dataclass
class NonSeparable(Hidden, name="nonseparable_relaxation"):
    """The share that relaxes grows with the depth at which it was loaded: ``c (1 + growth (x / depth - 1))``.

    A single integral with a kernel that depends on the strain at the time of loading (Pipkin and Rogers).
    """

    growth: float = 0.3  # [-]
    depth: float = 1e-3  # [m]
    amplitude: float = 0.2  # [-] of the material's relaxation
    rate: float = 2.0  # [1/s] of it
    _relaxed: float = fresh()

    def more(self, x: float, elastic: float) -> float:
        return -self.growth * self.amplitude * self._relaxed

    def strained(self, elastic: float, x: float, dt: float) -> None:
        excess = elastic * (max(x, 0.0) / self.depth - 1.0)
        self._relaxed += -math.expm1(-self.rate * dt) * (excess - self._relaxed)


@dataclass
class Drainage(Hidden, name="poroelastic_drainage"):
    """All that relaxes does so by flow over the contact radius: the rate falls with the depth."""

    exponent: float = 1.0  # [-] by which it falls
    depth: float = 1e-3  # [m] where it is the nominal one
    amplitude: float = 0.2  # [-]
    rate: float = 2.0  # [1/s]
    shallow: float = 0.05  # least depth over ``depth`` that counts
    _drained: float = fresh()
    _speed: float = fresh()
    _elastic: float = fresh()

    def relaxation(self, g: Relaxation) -> Relaxation:
        """Return no relaxation: it is all in :meth:`more`."""
        return lambda t: 1.0 + 0.0 * t

    def more(self, x: float, elastic: float) -> float:
        """Return what has drained, as a negative force [N], carried on to the end of this step."""
        return -self.amplitude * (self._drained + self._speed)

    def strained(self, elastic: float, x: float, dt: float) -> None:
        rate = self.rate * max(x / self.depth, self.shallow) ** -self.exponent
        middle = 0.5 * (elastic + self._elastic)
        self._drained += -math.expm1(-rate * dt) * (middle - self._drained)
        self._speed = -math.expm1(-rate * dt) * (elastic - self._drained)
        self._elastic = elastic


@dataclass
class FastDamping(Hidden, name="fast_damping"):
    """A dashpot beside the spring: it pushes with the rate of the elastic force.

    The rate is that at the end of a step, to second order: the mean rate over the step is half a step old,
    which is no small part of the time constant.
    """

    time: float = 4e-3  # [s]
    _elastic: float = fresh()
    _before: float = fresh()
    _dt: float = lasting(1.0)

    def more(self, x: float, elastic: float) -> float:
        return self.time * (1.5 * elastic - 2.0 * self._elastic + 0.5 * self._before) / self._dt

    def strained(self, elastic: float, x: float, dt: float) -> None:
        self._before, self._elastic, self._dt = self._elastic, elastic, dt


@dataclass
class RateStiffening(Hidden, name="rate_stiffening"):
    """While the indentation grows the elastic force is higher, by the logarithm of the speed."""

    growth: float = 0.03  # [-] per e-fold
    slow: float = 2e-4  # [m/s] where the growth begins
    _x: float = fresh()
    _dt: float = lasting(1.0)

    def more(self, x: float, elastic: float) -> float:
        return self.growth * elastic * math.log1p(max(x - self._x, 0.0) / self._dt / self.slow)

    def strained(self, elastic: float, x: float, dt: float) -> None:
        self._x, self._dt = x, dt


@dataclass
class ExponentialStiffness(Hidden, name="exponential_stiffness"):
    """The force grows by ``(e^s - 1) / s``, s the depth over a length."""

    length: float = 1.5e-3  # [m]

    def elastic(self, force: float, x: float) -> float:
        s = max(x, 0.0) / self.length
        return force * math.expm1(s) / s if s > 0.0 else force


@dataclass
class HardCore(Hidden, name="layer_over_core"):
    """A rigid core under the soft layer, as Garcia and Garcia (Biophysical Journal 114, 2018) have it.

    The force on the layer grows with the radius of the contact over the thickness.
    """

    thickness: float = 8e-3  # [m] of the layer
    tip_radius: float = 9e-3  # [m]

    def elastic(self, force: float, x: float) -> float:
        X = math.sqrt(self.tip_radius * max(x, 0.0)) / self.thickness
        return force * (1.0 + X * (1.133 + X * (1.497 + X * (1.469 + X * 0.755))))


@dataclass
class SecondContact(Hidden, name="second_contact"):
    """Another body stands behind a gap: a stop with a spring (exponent 1), or a ball."""

    force: float = 0.3  # [N] at ``reach`` beyond the gap
    reach: float = 5e-4  # [m]
    gap: float = 3e-4  # [m]
    exponent: float = 1.0  # [-]

    def elastic(self, force: float, x: float) -> float:
        pressed = max(x - self.gap, 0.0) / self.reach
        return float(force + self.force * pressed**self.exponent)


@dataclass
class Softening(Hidden, name="temperature_shift"):
    """Stiffness falls and rates grow exponentially with the temperature of the episode."""

    softening: float = 0.006  # [1/K]
    quickening: float = 0.05  # [1/K]
    nominal: float = 20.0  # [degrees Celsius]
    _above: float = lasting()

    def warmed(self, temperature: float) -> None:
        self._above = temperature - self.nominal

    def relaxation(self, g: Relaxation) -> Relaxation:
        return lambda t: g(t * math.exp(self.quickening * self._above))

    def elastic(self, force: float, x: float) -> float:
        return force * math.exp(-self.softening * self._above)


@dataclass
class PermanentSet(Hidden, name="permanent_set"):
    """The surface keeps a share of its deepest indentation beyond a threshold, and never recovers."""

    share: float = 0.03  # [-]
    threshold: float = 3e-4  # [m]
    _deepest: float = lasting()

    def indentation(self, x: float) -> float:
        return x - self.share * max(self._deepest - self.threshold, 0.0)

    def remember(self, x: float, force: float, dt: float) -> None:
        self._deepest = max(self._deepest, x)


@dataclass
class Mullins(Hidden, name="mullins_softening"):
    """Below the deepest indentation so far the material is softer; it does not heal."""

    loss: float = 0.12  # [-] of the force far below it
    width: float = 4e-4  # [m]
    _deepest: float = lasting()

    def elastic(self, force: float, x: float) -> float:
        return force * (1.0 - self.loss * math.tanh(max(self._deepest - x, 0.0) / self.width))

    def remember(self, x: float, force: float, dt: float) -> None:
        self._deepest = max(self._deepest, x)


@dataclass
class HealingSoftening(Mullins, name="healing_softening"):
    """The same, but the deepest indentation is forgotten while nothing touches, in small steps."""

    rate: float = 0.02  # [1/s]

    def start(self, pause: float) -> None:
        super().start(pause)
        self._deepest *= math.exp(-self.rate * pause)

    def remember(self, x: float, force: float, dt: float) -> None:
        super().remember(x, force, dt)
        if force <= 0.0:
            self._deepest -= self.rate * dt * self._deepest


# between the drive and the surfaces


@dataclass
class SeriesCompliance(Hidden, name="series_compliance"):
    """The mount gives way in proportion to the normal force."""

    compliance: float = 5e-5  # [m/N]


@dataclass
class Backlash(Hidden, name="displacement_backlash"):
    """Play: the mount stands still until the drive has crossed the gap, and is pushed by a flank then."""

    width: float = 3e-5  # [m]
    _mount: float = lasting()
    _drive: float = lasting()

    def moved(self, position: float) -> float:
        half = 0.5 * self.width
        self._mount = min(max(self._mount, position - half), position + half)
        self._drive = position
        return self._mount

    def drive(self, mount: float) -> float:
        if mount != self._mount:
            self._drive = mount + (0.5 if mount > self._mount else -0.5) * self.width
            self._mount = mount
        return self._drive


@dataclass
class Adhesion(Hidden, name="adhesion"):
    """A constant pull in contact; in the gap it falls evenly to zero over the stretch of the neck.

    No pull on approach: the neck forms at touch, and holds until it is stretched too far.
    """

    force: float = 0.03  # [N]
    stretch: float = 1e-4  # [m] of the neck when it tears
    _touching: bool = fresh(False)

    def pull(self, x: float) -> float:
        if x > 0.0:
            return self.force
        return self.force * max(1.0 + x / self.stretch, 0.0) if self._touching else 0.0

    def remember(self, x: float, force: float, dt: float) -> None:
        self._touching = x > (-self.stretch if self._touching else 0.0)


@dataclass
class JkrAdhesion(Hidden, name="jkr_adhesion"):
    """A soft sphere that sticks (Johnson, Kendall, Roberts), solved for the radius of its contact.

    The edge is pulled back by ``sqrt(2 pi w a / E)``, as a flat punch is, from the depth ``a^2 / R`` of a
    contact that does not stick. The tip's law is repeated, for its slope.
    """

    work: float = 1.5  # [J/m^2] of adhesion
    tip_radius: float = 9e-3  # [m]
    force: float = 1.8  # [N] at ``depth``
    depth: float = 1e-3  # [m]
    exponent: float = 1.5  # [-]
    _sticks: bool = fresh(False)

    @property
    def modulus(self) -> float:
        """Of a sphere of this force at this depth [Pa]."""
        return 0.75 * self.force / math.sqrt(self.tip_radius * self.depth**3)

    def back(self, a: float) -> float:
        """Return how far the edge is pulled back [m]."""
        return math.sqrt(2.0 * math.pi * self.work * a / self.modulus)

    def _radius(self, x: float) -> float:
        """Return the radius of the contact [m] at ``x``; 0 where nothing sticks or touches.

        Of its root s: ``s^4 / R - c s = x`` is convex, so Newton's steps from above fall to the larger root.
        """
        R, E = self.tip_radius, self.modulus
        least = math.cbrt(math.pi * self.work * R**2 / (8.0 * E))
        if x < least**2 / R - self.back(least) or (x < 0.0 and not self._sticks):
            return 0.0
        c = math.sqrt(2.0 * math.pi * self.work / E)
        s, before = math.sqrt(math.sqrt(R * max(x, 0.0)) + 5.0 * least), math.inf
        while s < before:
            before, slope = s, 4.0 * s**3 / R - c
            s -= (s**4 / R - c * s - x) / slope if slope > 0.0 else 0.0
        return max(before * before, least)

    def indentation(self, x: float) -> float:
        a = self._radius(x)
        return a * a / self.tip_radius if a > 0.0 else min(x, 0.0)

    def pull(self, x: float) -> float:
        a = self._radius(x)
        x_H = a * a / self.tip_radius
        slope = self.exponent * self.force / self.depth * (x_H / self.depth) ** (self.exponent - 1.0)
        return float(slope * self.back(a)) if a > 0.0 else 0.0

    def remember(self, x: float, force: float, dt: float) -> None:
        self._sticks = self._radius(x) > 0.0


# the patch and its friction


@dataclass
class RadiusLaw(Hidden, name="contact_radius_law"):
    """``a^2 = kappa R x``; the plain tip has ``kappa = 2``."""

    kappa: float = 1.4  # [-]

    def radius(self, a: float, x: float, tip_radius: float) -> float:
        return math.sqrt(self.kappa * tip_radius * x) if a > 0.0 else 0.0


@dataclass
class PressureProfile(Hidden, name="pressure_profile"):
    """One pressure exponent, whatever the contact has been through."""

    k: float = 5.0  # [-]

    def flattened(self, k: float) -> float:
        return self.k


@dataclass
class LoadDependentFriction(Hidden, name="load_dependent_friction"):
    """A power of the normal force."""

    exponent: float = 0.15  # [-] by which it falls
    at: float = 1.0  # [N] where it is the nominal one

    def friction(self, mu: float, force: float, speed: float) -> float:
        return float(mu * (max(force, 1e-3 * self.at) / self.at) ** -self.exponent)


@dataclass
class RateDependentFriction(Hidden, name="rate_dependent_friction"):
    """Static friction that gives way to a kinetic one, which grows with the logarithm of the speed."""

    kinetic: float = 0.85  # [-] over static
    stribeck: float = 1e-3  # [m/s]
    growth: float = 0.03  # [-] per e-fold
    slow: float = 1e-4  # [m/s] where the growth begins

    def friction(self, mu: float, force: float, speed: float) -> float:
        ratio = speed / self.stribeck
        falling = self.kinetic + (1.0 - self.kinetic) * math.exp(-ratio * ratio)
        return mu * (falling + self.growth * math.log(1.0 + speed / self.slow))


@dataclass
class FrictionAgeing(Hidden, name="friction_ageing"):
    """Friction grows with the logarithm of the age of the contact; sliding renews it."""

    growth: float = 0.05  # [-] per e-fold
    time: float = 0.1  # [s] where it begins
    distance: float = 1e-5  # [m] of slip that renews the contact
    _age: float = fresh()

    def friction(self, mu: float, force: float, speed: float) -> float:
        return mu * (1.0 + self.growth * math.log(1.0 + self._age / self.time))

    def rubbed(self, force: float, speed: float, dt: float) -> None:
        kept = 1.0 - min(speed * dt / self.distance, 1.0)
        self._age = (self._age * kept + dt) if force > 0.0 else 0.0


@dataclass
class WetContact(Hidden, name="wet_contact"):
    """A film that is squeezed out while the contact lasts."""

    loss: float = 0.3  # [-] of friction at first touch
    time: float = 1.0  # [s]
    _film: float = fresh(1.0)

    def friction(self, mu: float, force: float, speed: float) -> float:
        return mu * (1.0 - self.loss * self._film)

    def rubbed(self, force: float, speed: float, dt: float) -> None:
        self._film = self._film * (1.0 - dt / self.time) if force > 0.0 else 1.0


# a sensor that shows something else than the normal force


@dataclass
class SensorLag(Hidden, name="sensor_lag"):
    """The sensor follows with a time constant; integrated in small steps."""

    time: float = 5e-3  # [s]
    _shown: float = fresh()
    _before: float = fresh()

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        gain = -math.expm1(-dt / LAG_SUBSTEPS / self.time)
        for i in range(LAG_SUBSTEPS):
            there = self._before + (i + 0.5) / LAG_SUBSTEPS * (shown - self._before)
            self._shown += gain * (there - self._shown)
        self._before = shown
        return self._shown


@dataclass
class SensorDelay(Hidden, name="sensor_delay"):
    """The sensor shows what was felt some time ago, from a tape of times and forces."""

    time: float = 5e-3  # [s]
    _tape: tuple[tuple[float, float], ...] = fresh(((0.0, 0.0),))

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        now = self._tape[-1][0] + dt
        tape = (*self._tape, (now, shown))
        while len(tape) > 2 and tape[1][0] <= now - self.time:
            tape = tape[1:]
        self._tape = tape
        (t0, y0), (t1, y1) = tape[:2]
        share = (now - self.time - t0) / (t1 - t0)
        return y0 + min(max(share, 0.0), 1.0) * (y1 - y0)


@dataclass
class CrossTalk(Hidden, name="cross_talk"):
    """The sensor shows a share of the tangential force."""

    share: float = 0.02  # [-]

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        return shown + self.share * tangential


@dataclass
class Saturation(Hidden, name="saturation"):
    """The sensor ends at its full scale."""

    limit: float = 0.8  # [N]

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        return min(shown, self.limit)


@dataclass
class GuideFriction(Hidden, name="guide_friction"):
    """The guide of the drive drags against its motion; at rest it releases."""

    force: float = 0.02  # [N]
    speed: float = 1e-4  # [m/s] where 70 % of it is reached
    _before: float = fresh()

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        speed = (drive - self._before) / dt
        self._before = drive
        return shown + self.force * speed / math.hypot(speed, self.speed)


@dataclass
class ApproachTilt(Hidden, name="approach_tilt"):
    """A cable goes along with the drive, and pulls at the sensor as a spring."""

    stiffness: float = 30.0  # [N/m]

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        return shown + self.stiffness * drive


@dataclass
class ForceDrift(Clocked, name="force_drift"):
    """The zero of the sensor runs away at a constant rate, in the pauses too."""

    rate: float = 2e-4  # [N/s]

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        return shown + self.rate * self.time_passed


def make(
    settings: Mapping[str, Mapping[str, float]], known: Mapping[str, type[Hidden]] = HIDDEN
) -> tuple[Hidden, ...]:
    """Return the effects of ``settings``: name -> parameters, SI; those left out have their default."""
    made = []
    for name, given in settings.items():
        if name not in known:
            raise ConfigError(f"hidden: there is no effect {name!r}; there are {', '.join(known)}")
        keys = [each.name for each in fields(known[name]) if each.init]
        for key in given:
            if key not in keys:
                raise ConfigError(f"hidden {name}: unknown key {key!r}; known are {', '.join(keys)}")
        made.append(known[name](**given))
    return tuple(made)
