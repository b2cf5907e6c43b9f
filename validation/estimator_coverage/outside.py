"""A soft fingertip integrated on its own: power-law elastic force, one relaxing branch, free surface.

``N = N_e(x) - z >= 0``, ``dz/dt = nu (c N_e - z)``, ``N_e = K (10 x / R)^p``; where N would turn negative the
surface is free and recovers with ``N_e = z``. Steps of 0.1 ms, exact exponential. It shares no code with the
estimator or its model; only the limit in torsion is asked of the reference quadrature.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vegrip.contact.limit_surface.reference import torsion_limit
from vegrip.types import Floats

SIMULATION_STEP_S = 1e-4  # [s]
EPISODE_PAUSE_S = 5.0  # [s] between episodes, in the air, without samples
FLATTEST = 1e-4  # least C_k - 1, the end of the coupling law
EXPONENTS = np.geomspace(1.0, 200.0, 4000)


@dataclass(frozen=True)
class Finger:
    """True parameters of one fingertip."""

    radius: float  # R [m]
    stiffness: float  # K [N], elastic force at R/10
    exponent: float  # p
    share: float  # c, relaxing
    rate: float  # nu [1/s]
    friction: float  # mu
    k0: float  # exponent of the fresh pressure

    def elastic_force(self, depth: Floats) -> Floats:
        """Return N_e [N] at ``depth`` [m]."""
        force: Floats = self.stiffness * (np.maximum(depth, 0.0) * 10.0 / self.radius) ** self.exponent
        return force

    def depth(self, force: Floats | float) -> Floats:
        """Return the elastic indentation [m] under ``force`` [N]."""
        ratio = np.maximum(force, 0.0) / self.stiffness
        return np.asarray(0.1 * self.radius * ratio ** (1.0 / self.exponent))


class Segment(NamedTuple):
    """A piece of the drive: straight to a depth or a force, or a sine about the present depth."""

    seconds: float
    to: float = math.nan  # [m], or [N] in force control; NaN = stay
    by_force: bool = False
    amplitude: float = 0.0  # [m] of a sine
    hertz: float = 0.0  # [1/s] of a sine
    load: float = 0.0  # share of the limit at the end; from 1 on the contact slides
    twist: bool = False  # the load is a torque instead of a force


class Contact(NamedTuple):
    """What is true on the grid of STEP; arrays (n,)."""

    t: Floats  # [s]
    episode: Floats
    depth: Floats  # [m]
    force: Floats  # [N]
    radius: Floats  # [m]
    exponent: Floats  # k
    used: Floats  # share of the limit, 1 = sliding
    tangential: Floats  # [N]
    torque: Floats  # [N m]
    limit: Floats  # [N] distance to the limit surface along the load


def live(finger: Finger, episodes: Sequence[Sequence[Segment]], air: float) -> Contact:
    """Move the fingertip through ``episodes``, each begun at the height ``air`` [m] < 0."""
    tip, parts, start = Tip(finger), [], 0.0
    for number, segments in enumerate(episodes):
        tip.depth = air
        rows = np.concatenate([tip.follow(segment) for segment in segments], axis=1)
        t = start + SIMULATION_STEP_S * np.arange(1, rows.shape[1] + 1)
        parts.append(np.vstack([t, np.full(t.size, float(number)), rows]))
        start = float(t[-1]) + EPISODE_PAUSE_S
        tip.rest(EPISODE_PAUSE_S)
    t, episode, depth, force, used, twist = np.concatenate(parts, axis=1)
    touching = force > 0.0
    radius = np.where(touching, np.sqrt(2.0 * finger.radius * np.maximum(depth, 0.0)), 0.0)
    k = pressure_exponent(finger, depth, force)
    limit = finger.friction * force * np.where(twist > 0.0, torsion_limit(k), 1.0)
    load = np.minimum(used, 1.0) * limit
    tangential, torque = np.where(twist > 0.0, 0.0, load), np.where(twist > 0.0, load * radius, 0.0)
    return Contact(t, episode, depth, force, radius, k, used * touching, tangential, torque, limit)


class Tip:
    """The state of a fingertip between two segments of the drive."""

    def __init__(self, finger: Finger) -> None:
        self.finger = finger
        self.depth = self.force = self.load = 0.0
        self.relaxed = self.surface = 0.0  # z and N_e of the surface [N]

    def rest(self, seconds: float) -> None:
        """Recover freely in the air."""
        self.relaxed *= math.exp(-self.finger.rate * (1.0 - self.finger.share) * seconds)
        self.force, self.surface = 0.0, self.relaxed

    def follow(self, segment: Segment) -> Floats:
        """Return depth, force, share of the limit, whether it is a torque (4, n) along one segment."""
        n = max(round(segment.seconds / SIMULATION_STEP_S), 1)
        s = np.arange(1, n + 1) / n
        if segment.by_force:
            asked = self.force + s * (segment.to - self.force)
            force, surface = self._integrate(np.full(n, math.nan), asked)
            depth = self.finger.depth(surface)
        else:
            to = self.depth if math.isnan(segment.to) else segment.to
            wave = segment.amplitude * np.sin(2.0 * math.pi * segment.hertz * segment.seconds * s)
            depth = self.depth + s * (to - self.depth) + wave
            force, _ = self._integrate(self.finger.elastic_force(depth), np.full(n, math.nan))
        used = self.load + s * (segment.load - self.load)
        self.depth, self.force, self.load = float(depth[-1]), float(force[-1]), segment.load
        return np.vstack([depth, force, used, np.full(n, float(segment.twist))])

    def _integrate(self, elastic: Floats, asked: Floats) -> tuple[Floats, Floats]:
        """Return the normal force [N] and N_e of the surface [N] under imposed N_e, or imposed force."""
        c, lost = self.finger.share, -math.expm1(-self.finger.rate * SIMULATION_STEP_S)
        z, before = self.relaxed, self.surface
        forces, surfaces = [], []
        for imposed, wanted in zip(elastic.tolist(), asked.tolist(), strict=True):
            ahead = z + lost * (c * before - z)
            surface = wanted + ahead if wanted == wanted else max(imposed, ahead)  # noqa: PLR0124
            z += lost * (0.5 * c * (before + surface) - z)
            force = wanted if wanted == wanted else max(imposed - z, 0.0)  # noqa: PLR0124
            before = force + z
            forces.append(force)
            surfaces.append(before)
        self.relaxed, self.surface = z, before
        return np.array(forces), np.array(surfaces)


def pressure_exponent(finger: Finger, depth: Floats, force: Floats) -> Floats:
    """Return k by ``C_k = C_k0 / H``, H the depth over the elastic one under the contact's largest force."""
    largest = _largest_since_touch(force)
    fresh = finger.depth(largest)
    creep = np.maximum(np.divide(depth, fresh, out=np.ones_like(depth), where=fresh > 0.0), 1.0)
    table = np.array([_excess(k) for k in EXPONENTS])
    excess = np.maximum((1.0 + _excess(finger.k0)) / creep - 1.0, FLATTEST)
    return np.exp(np.interp(-np.log(excess), -np.log(table), np.log(EXPONENTS)))


def _excess(k: float) -> float:
    """Return C_k - 1 of the paper's equation (4)."""
    return math.expm1(math.lgamma(1.0 + 3.0 / k) - math.lgamma(1.0 + 1.0 / k) - math.lgamma(1.0 + 2.0 / k))


def _largest_since_touch(force: Floats) -> Floats:
    """Return the largest force [N] of each contact so far."""
    out = np.zeros_like(force)
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], (force > 0.0).astype(float), [0.0]])))
    for start, end in edges.reshape(-1, 2):
        out[start:end] = np.maximum.accumulate(force[start:end])
    return out
