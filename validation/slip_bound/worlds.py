"""Where grasps come from: friction as published, or as the grip believes it at first.

A grasp is drawn whole: its friction, its load and shares, what its sensors hide, and the force that is set.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vegrip.estimator.friction_prior import PUBLISHED_COEFFICIENT, PUBLISHED_SPREAD
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.trials.published_friction import TANGENTIAL_GAIN_RANGE, draw_friction

STATED_AT = 5.0  # [N] at which friction is mu

WEIGHT_RANGE = (0.5, 6.0)  # [N] of 50 g to 600 g, drawn evenly in the logarithm
LIGHT = 1.7  # [N] below it a load is light: half of them
FORCE_RANGE = (0.6, 3.0)  # of the least force that holds, drawn evenly in the logarithm
SHARE_RANGE = (0.36, 0.64)  # of the weight on the first finger: 64 : 36 was measured ([Burke2023]_)
OWN_STD = 0.05  # of ln mu between the fingers on one object, in the published world
EXTREME_BELOW, EXTREME_ABOVE = 0.25, 1.0  # [-] mu at 5 N
LOW = 0.45  # [-] mu at 5 N below which friction counts as low
WOOD = "silicone pillars on wood"


@dataclass(frozen=True)
class Grasp:
    """An object between two fingers that press alike, and all that is true of it."""

    contact: str
    mu: tuple[float, float]  # [-] of each finger at 5 N
    exponent: float  # [-] g
    weight: float  # [N]
    share: float  # of the weight on the first finger, as long as neither slides
    gain: float  # of the tangential channels
    force_ratio: float  # force that is set over the least that holds
    seed: int  # of the noise

    @property
    def least_force(self) -> float:
        """The least normal force [N] of each finger with which both together hold the weight."""
        return least_force(sum(self.mu), self.exponent, self.weight)

    @property
    def friction(self) -> float:
        """Geometric mean of mu of both fingers at 5 N."""
        return math.sqrt(self.mu[0] * self.mu[1])

    def limits(self, force: float) -> tuple[float, float]:
        """Return what each finger can carry [N] at a normal force [N]: ``mu (N / 5 N)^-g N``."""
        factor = force * (force / STATED_AT) ** -self.exponent if force > 0.0 else 0.0
        return self.mu[0] * factor, self.mu[1] * factor


def least_force(mu: float, exponent: float, load: float) -> float:
    """Return N with ``mu (N / 5 N)^-g N = load`` [N]."""
    plain = load / mu
    return float(plain * (plain / STATED_AT) ** (exponent / (1.0 - exponent)))


def published(rng: np.random.Generator) -> tuple[str, float, float, float, float]:
    """Return contact, mu, exponent, gain of the sensors, and the std of ln mu of a finger of its own."""
    row, mu, exponent = draw_friction(rng)
    return row.name, mu, exponent, float(rng.uniform(*TANGENTIAL_GAIN_RANGE)), OWN_STD


def belief(rng: np.random.Generator) -> tuple[str, float, float, float, float]:
    """Return the same as the grip believes it at first, where nothing is stated."""
    settings = FrictionSettings()
    prior, own = settings.prior_of(), settings.own_spread
    common = math.sqrt(PUBLISHED_SPREAD**2 - own**2)
    mu = PUBLISHED_COEFFICIENT * math.exp(common * rng.standard_normal())
    exponent = prior.load_exponent + prior.load_exponent_std * rng.standard_normal()
    gain = prior.tangential_gain * math.exp(prior.tangential_gain_std * rng.standard_normal())
    return "as believed", mu, exponent, gain, own


WORLDS: dict[str, Callable[[np.random.Generator], tuple[str, float, float, float, float]]] = {
    "published": published,
    "belief": belief,
}


def draw_grasp(world: str, seed: int) -> Grasp:
    """Return grasp number ``seed`` of a world."""
    rng = np.random.default_rng([seed, 51])
    contact, mu, exponent, gain, own = WORLDS[world](rng)
    one, other = (mu * np.exp(own * rng.standard_normal(2))).tolist()
    weight = _log_uniform(rng, *WEIGHT_RANGE)
    share = float(rng.uniform(*SHARE_RANGE))
    return Grasp(contact, (one, other), exponent, weight, share, gain, _log_uniform(rng, *FORCE_RANGE), seed)


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def friction_class(world: str, grasp: Grasp) -> str:
    """Return the one class of friction that a grasp belongs to."""
    if world == "published" and not EXTREME_BELOW <= grasp.friction <= EXTREME_ABOVE:
        return "extreme friction"
    if grasp.contact == WOOD:
        return "wood-like"
    return "other low friction" if grasp.friction < LOW else "the rest"


def load_class(grasp: Grasp) -> str:
    return "light load" if grasp.weight < LIGHT else "heavy load"
