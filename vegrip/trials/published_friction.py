"""Friction of soft fingertips as published: what the objects of the published world are made of.

No belief of an estimator is taken from here, and none of its own from there. A contact has
``mu(N) = mu (N / 5 N)^-g``. A spread that the source does not state is 0.25 of ln mu and 0.05 of g; of g the
world has 0 to 1/3, of mu 0.2 to 1.1, and what is drawn beyond is moved there.
"""

import math
from dataclasses import dataclass

import numpy as np

MU_RANGE = (0.2, 1.1)
EXPONENT_RANGE = (0.0, 1.0 / 3.0)
TANGENTIAL_GAIN_RANGE = (0.8, 1.05)
"""Of what tactile pads measured of a known weight: 0.81 and 0.95 ([Burke2023]_)."""


@dataclass(frozen=True)
class PublishedFriction:
    """One kind of contact."""

    name: str
    mu: float  # [-] at 5 N
    spread: float  # [-] of ln mu, one std
    exponent: float  # [-] g
    exponent_spread: float  # [-] one std
    source: str


PUBLISHED = (
    PublishedFriction("finger pad on aluminium", 0.60, 0.25, 0.21, 0.05, "[SeoArmstrongDrinkaus2009]_"),
    PublishedFriction("finger pad on rubber hose", 0.90, 0.25, 0.21, 0.05, "[SeoArmstrongDrinkaus2009]_"),
    PublishedFriction("fingertip on sandpaper", 0.93, 0.10, 0.15, 0.10, "[SavescuLatashZatsiorsky2008]_"),
    PublishedFriction("fingertip on rayon", 0.36, 0.28, 0.0, 0.0, "[SavescuLatashZatsiorsky2008]_"),
    PublishedFriction("finger pad on wet glass", 0.78, 0.43, 1.0 / 3.0, 0.05, "[DerlerRotaru2013]_"),
    PublishedFriction("silicone pillars on wood", 0.33, 0.10, 0.25, 0.05, "[Burke2023]_"),
)
"""The rows. Seo et al.: means over twelve persons and 1 to 20 N, over which mu falls by 46 %. Savescu et al.:
0.96 +- 0.09 at 4 N, and by how much it falls is not said; 0.36 +- 0.10 at 4, 8 and 12 N. Derler and Rotaru:
0.78 +- 0.35, with the load dependence of adhesion ([Schallamach1952]_). Burke: from the outcomes of 70 lifts.
"""


def draw_friction(rng: np.random.Generator) -> tuple[PublishedFriction, float, float]:
    """Draw a row; return it, friction at 5 N and exponent of one object."""
    row = PUBLISHED[int(rng.integers(len(PUBLISHED)))]
    mu = row.mu * math.exp(row.spread * rng.standard_normal())
    exponent = row.exponent + row.exponent_spread * rng.standard_normal()
    return row, float(np.clip(mu, *MU_RANGE)), float(np.clip(exponent, *EXPONENT_RANGE))
