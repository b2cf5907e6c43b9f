"""How much of each effect is hidden: in proportion to fingertip, depth and noise."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vegrip.virtual.settings import FingertipSettings, SensorSettings

WEAK = 0.4
"""A weak effect has this share of a strong one."""


@dataclass(frozen=True)
class Setting:
    """What an amount is measured by.

    Attributes:
        tip: the fingertip.
        sensors: noise.
        depth: [m] the deepest press.
        size: 1 for a strong effect.
        rng: for what only shapes an effect.

    """

    tip: FingertipSettings
    sensors: SensorSettings
    depth: float
    size: float
    rng: np.random.Generator

    @property
    def force(self) -> float:
        """Elastic force [N] at the deepest press."""
        tip = self.tip
        return float(tip.reference_force * (self.depth / tip.reference_indentation) ** tip.exponent)

    @property
    def noise(self) -> float:
        """Of the force [N]."""
        return self.sensors.normal_force

    @property
    def viscosity(self) -> dict[str, float]:
        """The tip's own relaxation, for effects that take its place, and the depth at which it is nominal."""
        return {
            "amplitude": self.tip.amplitudes[0],
            "rate": self.tip.rates[0],
            "depth": 0.6 * self.depth,
        }

    def other_rate(self) -> float:
        """Return a rate of relaxation well apart from the tip's own [1/s]."""
        apart = float(np.exp(self.rng.uniform(np.log(8.0), np.log(20.0))))
        own = self.tip.rates[0]
        return own / apart if self.rng.random() < 0.6 else own * apart


Amount = Callable[[Setting], Mapping[str, float]]

CATALOGUE_AMOUNTS: Mapping[str, Amount] = {
    "adhesion": lambda s: {"force": 6.0 * s.noise * s.size, "stretch": 0.08 * s.depth},
    "second_relaxation": lambda s: {"amplitude": 0.12 * s.size, "rate": s.other_rate()},
    "power_law_relaxation": lambda s: {"amplitude": 0.35 * s.size},
    "relaxation_spectrum": lambda s: {
        "amplitude": 0.1 * s.size,
        "slow": s.tip.rates[0] / float(np.exp(s.rng.uniform(np.log(8.0), np.log(20.0)))),
        "fast": s.tip.rates[0] * float(np.exp(s.rng.uniform(np.log(8.0), np.log(20.0)))),
    },
    "series_compliance": lambda s: {"compliance": 0.2 * s.size * s.depth / s.force},
    "displacement_backlash": lambda s: {"width": 8.0 * s.sensors.displacement * s.size},
    "permanent_set": lambda s: {"share": 0.04 * s.size, "threshold": 0.15 * s.depth},
    "mullins_softening": lambda s: {"loss": 0.15 * s.size, "width": 0.3 * s.depth},
    "healing_softening": lambda s: {
        "loss": 0.15 * s.size,
        "width": 0.3 * s.depth,
        "rate": float(np.exp(s.rng.uniform(np.log(5e-3), np.log(0.1)))),
    },
    "exponential_stiffness": lambda s: {"length": 1.2 * s.depth / s.size},
    "layer_over_core": lambda s: {"thickness": 0.9 * s.tip.radius / s.size, "tip_radius": s.tip.radius},
    "sensor_lag": lambda s: {"time": 6e-3 * s.size},
    "cross_talk": lambda s: {"share": 0.04 * s.size},
    "force_drift": lambda s: {"rate": 0.02 * s.noise * s.size},
    "load_dependent_friction": lambda s: {"exponent": 0.15 * s.size, "at": 0.4 * s.force},
    "rate_dependent_friction": lambda s: {"kinetic": 1.0 - 0.2 * s.size, "growth": 0.03 * s.size},
    "friction_ageing": lambda s: {"growth": 0.06 * s.size},
    "wet_contact": lambda s: {"loss": 0.3 * s.size},
    "contact_radius_law": lambda s: {"kappa": 2.0 - 0.6 * s.size},
    "pressure_profile": lambda s: {"k": 2.0 + 4.0 * s.size},
    "nonseparable_relaxation": lambda s: {"growth": 0.5 * s.size, **s.viscosity},
    "poroelastic_drainage": lambda s: {"exponent": 1.0 * s.size, **s.viscosity},
    "rate_stiffening": lambda s: {"growth": 0.03 * s.size, "slow": 0.1 * s.depth},
    "fast_damping": lambda s: {"time": 5e-3 * s.size},
    "temperature_shift": lambda s: {"softening": 0.01 * s.size, "quickening": 0.06 * s.size},
    "guide_friction": lambda s: {"force": 3.0 * s.noise * s.size, "speed": 0.05 * s.depth},
    "approach_tilt": lambda s: {"stiffness": 6.0 * s.noise * s.size / s.depth},
    "jkr_adhesion": lambda s: {
        "work": 6.0 * s.noise * s.size / (1.5 * np.pi * s.tip.radius),
        "tip_radius": s.tip.radius,
        "force": s.tip.reference_force,
        "depth": s.tip.reference_indentation,
        "exponent": s.tip.exponent,
    },
    "second_contact": lambda s: {
        "force": 0.1 * s.force * s.size,
        "reach": 0.4 * s.depth,
        "gap": 0.6 * s.depth,
        "exponent": float(s.rng.choice([1.0, 1.5])),
    },
    "saturation": lambda s: {"limit": (1.0 - 0.35 * s.size) * s.force},
}
"""Strong: what leaves about as much as the noise, or more, once the plain model is refitted."""

DRAWN_BY_NAME = (
    "approach_tilt",
    "healing_softening",
    "jkr_adhesion",
    "relaxation_spectrum",
    "second_contact",
)
"""Only where one asks for them: with them the published seeds would hide something else."""

UNMODELLED_AMOUNTS: Mapping[str, Amount] = {
    "cogging": lambda s: {"force": 4.0 * s.noise, "period": 0.3 * s.depth},
    "magnet": lambda s: {"force": 10.0 * s.noise, "reach": 0.1 * s.depth},
    "day_and_night": lambda s: {"share": 0.04, "period": float(s.rng.uniform(120.0, 250.0))},
    "crack": lambda s: {"share": 0.06, "at": float(s.rng.uniform(200.0, 400.0))},
    "transfer_film": lambda s: {"loss": 0.3, "time": float(s.rng.uniform(100.0, 200.0))},
    "shear_shrinking": lambda s: {"share": 0.15, "friction_at": s.tip.friction},
    "speed_band": lambda s: {"force": 6.0 * s.noise, "speed": 1.5 * s.depth},
    "warm_peak": lambda s: {"share": 0.05, "peak": float(s.rng.uniform(24.0, 28.0))},
}
