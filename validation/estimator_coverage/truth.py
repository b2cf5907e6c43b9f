"""Random fingertips with a life of presses, holds, loads, slips; what is true and what the sensors say."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.contact.limit_surface.fast import gauges
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import ContactModel, Simulation
from vegrip.types import Floats


@dataclass(frozen=True)
class Truth:
    """One fingertip and its history; arrays of shape (n,)."""

    model: ContactModel
    t: Floats  # [s], unevenly spaced
    indentation: Floats  # imposed [m]
    contact: Simulation
    tangential: Floats  # [N]
    torque: Floats  # [N m]
    utilisation: Floats  # gauge of the load, 1 = slipping; NaN out of contact
    states: list[FingertipState]  # what the sensors say
    friction: Floats  # of each loading over the mean, as slips scatter

    def limit_radius(self, i: int) -> float:
        """True distance [N] to the limit surface along the load of sample i; NaN without load or contact."""
        a = self.contact.contact_radius[i]
        load = math.hypot(self.tangential[i], self.torque[i] / a) if a > 0.0 else 0.0
        return load / self.utilisation[i] if load > 0.0 else math.nan


def utilisation(contact: Simulation, tangential: Floats, torque: Floats) -> Floats:
    """Load over limit at every sample; NaN out of contact."""
    limit = contact.friction_coefficient * contact.normal_force
    with np.errstate(divide="ignore", invalid="ignore"):
        f, m = tangential / limit, torque / (limit * contact.contact_radius)
    found: Floats = gauges(contact.pressure_exponent, f, m)
    return found


def draw(prior: ContactModel, rng: np.random.Generator) -> ContactModel:
    """Return a fingertip as the prior says they are."""
    model = prior
    for symbol, (_, declared) in prior.parameters.items():
        known = prior.values[symbol]
        step = known.std * rng.standard_normal()
        value = known.value * math.exp(step) if declared.transform == "log" else known.value + step
        low, high = max(known.low, 0.2 * known.value), min(known.high, 5.0 * known.value)
        model = model.with_value(symbol, min(max(value, low), high))
    return model


def live(
    prior: ContactModel,
    noise: SensorNoise,
    settings: EstimatorSettings,
    rng: np.random.Generator,
    *,
    duration: float = 12.0,
    rate: float = 500.0,
    start_in_contact: bool = False,
) -> Truth:
    """Draw a fingertip and let it live for ``duration`` [s]; samples jitter by 30 % of their spacing."""
    model = draw(prior, rng)
    n = int(duration * rate)
    t = np.cumsum((1.0 + 0.3 * rng.uniform(-1.0, 1.0, n)) / rate)
    delta, share, number = motion(t, model.tip_radius, rng, start_in_contact=start_in_contact)
    contact, friction = model.simulate(t, delta), scattered(number, settings, rng)
    tangential, torque, slip = _loading(contact, share, friction, rng)
    used = utilisation(contact, tangential, torque) / friction
    record = Truth(model, t, delta, contact, tangential, torque, used, [], friction)
    record.states.extend(sensed(record, slip, noise, settings, rng))
    return record


def motion(
    t: Floats, R: float, rng: np.random.Generator, *, start_in_contact: bool
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Indentation [m], share of its limit that the load shall have, number of the loading."""
    air = -0.02 * R
    knots, depth, load = [0.0], [0.08 * R if start_in_contact else air], [0.0]
    begun = [0.0]  # [s] of each loading

    def go(seconds: float, to: float, share: float) -> None:
        knots.append(knots[-1] + seconds)
        depth.append(to)
        load.append(share)

    go(rng.uniform(0.2, 0.6), depth[-1], 0.0)
    while knots[-1] < t[-1]:
        press = rng.uniform(0.04, 0.16) * R
        go(rng.uniform(0.15, 0.6), press, 0.0)
        for _ in range(rng.integers(1, 4)):
            press *= rng.uniform(0.85, 1.15)
            begun.append(knots[-1])
            peak = rng.uniform(1.05, 1.3) if rng.random() < 0.3 else rng.uniform(0.5, 0.97)
            go(rng.uniform(0.1, 0.4), press, 0.1)
            go(rng.uniform(0.3, 0.8), press, peak)
            go(rng.uniform(0.1, 0.6), press, min(peak, 0.97))
            go(rng.uniform(0.1, 0.3), press, 0.05)
        if rng.random() < 0.5:
            go(0.1, press, 0.0)
            go(rng.uniform(0.1, 0.4), air, 0.0)
            go(rng.uniform(0.1, 0.5), air, 0.0)
    return np.interp(t, knots, depth), np.interp(t, knots, load), np.searchsorted(begun, t, side="right")


def scattered(number: NDArray[np.int64], settings: EstimatorSettings, rng: np.random.Generator) -> Floats:
    """Friction over its mean: another one for each loading, as the settings say that slips scatter."""
    return np.exp(settings.friction_scatter * rng.standard_normal(int(number.max()) + 1))[number]


def _loading(
    contact: Simulation, share: Floats, friction: Floats, rng: np.random.Generator
) -> tuple[Floats, Floats, Floats]:
    """Tangential force [N], torque [N m] and slip flag; beyond its limit the load stays on it and slips."""
    slip = (share >= 1.0) & (contact.normal_force > 0.0)
    reach = np.minimum(share, 1.0)
    psi = rng.uniform(0.0, 1.2)
    one = np.ones_like(share)
    limit = friction * contact.friction_coefficient * contact.normal_force
    gauge = gauges(contact.pressure_exponent, math.cos(psi) * one, math.sin(psi) * one)
    tangential = reach * limit * math.cos(psi) / gauge
    torque = reach * limit * contact.contact_radius * math.sin(psi) / gauge
    return tangential, torque, slip.astype(float)


def _wandering(n: int, dt: float, std: float, tau: float, rng: np.random.Generator) -> Floats:
    """An Ornstein-Uhlenbeck process."""
    keep = math.exp(-dt / tau)
    kicks = std * math.sqrt(1.0 - keep * keep) * rng.standard_normal(n)
    out = np.empty(n)
    x = std * rng.standard_normal()
    for i in range(n):
        x = keep * x + kicks[i]
        out[i] = x
    return out


def sensed(
    record: Truth, slip: Floats, noise: SensorNoise, settings: EstimatorSettings, rng: np.random.Generator
) -> list[FingertipState]:
    """What the sensors say: white noise, slow disturbance, constant errors as the settings have them."""
    n, dt = record.t.size, float(np.mean(np.diff(record.t)))
    drift = settings.force_drift * noise.normal_force, settings.displacement_drift * noise.displacement
    force = record.contact.sensed_force + noise.normal_force * rng.standard_normal(n)
    force += _wandering(n, dt, drift[0], settings.force_drift_time, rng)
    force += settings.force_bias * noise.normal_force * rng.standard_normal()
    displacement = record.indentation + noise.displacement * rng.standard_normal(n)
    displacement += _wandering(n, dt, drift[1], settings.displacement_drift_time, rng)
    displacement += settings.offset * record.model.tip_radius * rng.standard_normal()
    fx = record.tangential + noise.tangential_force * rng.standard_normal(n)
    fy = noise.tangential_force * rng.standard_normal(n)
    torque = record.torque + noise.torque_z * rng.standard_normal(n)
    rows = zip(record.t, force, fx, fy, torque, displacement, slip, strict=True)
    return [
        FingertipState(round(t * NS), "tip", i, N, x, y, m, d, slip=s)
        for i, (t, N, x, y, m, d, s) in enumerate(rows)
    ]
