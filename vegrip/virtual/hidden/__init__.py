"""Hidden effects: what a trial can have beyond the plain fingertip, for finding out what a diagnosis finds.

They share nothing with :mod:`vegrip.effects` but the names: their parameters are plain SI numbers, their
memory is integrated in the small steps of the trial. They are switched on by
``run_trial(..., hidden={"adhesion": {"force": 0.05}})``.
"""

from collections.abc import Mapping
from dataclasses import fields

from vegrip.errors import ConfigError
from vegrip.virtual.hidden.adhesion import Adhesion
from vegrip.virtual.hidden.base import Hidden
from vegrip.virtual.hidden.depth import Drainage, NonSeparable
from vegrip.virtual.hidden.mount import Backlash, SeriesCompliance
from vegrip.virtual.hidden.patch import PressureProfile, RadiusLaw
from vegrip.virtual.hidden.relaxations import PowerLawRelaxation, SecondRelaxation
from vegrip.virtual.hidden.rubbing import (
    FrictionAgeing,
    LoadDependentFriction,
    RateDependentFriction,
    WetContact,
)
from vegrip.virtual.hidden.sensor import (
    CrossTalk,
    ForceDrift,
    GuideFriction,
    Saturation,
    SensorDelay,
    SensorLag,
)
from vegrip.virtual.hidden.stiffness import ExponentialStiffness, HardCore
from vegrip.virtual.hidden.unmodelled import (
    Cogging,
    Crack,
    DayAndNight,
    Magnet,
    ShearShrinking,
    SpeedBand,
    TransferFilm,
    Unknown,
    WarmPeak,
)
from vegrip.virtual.hidden.viscous import FastDamping, RateStiffening
from vegrip.virtual.hidden.warmth import Softening
from vegrip.virtual.hidden.wear import Mullins, PermanentSet

__all__ = ["HIDDEN", "UNMODELLED", "Hidden", "make"]

HIDDEN: Mapping[str, type[Hidden]] = {
    "adhesion": Adhesion,
    "second_relaxation": SecondRelaxation,
    "power_law_relaxation": PowerLawRelaxation,
    "series_compliance": SeriesCompliance,
    "displacement_backlash": Backlash,
    "permanent_set": PermanentSet,
    "mullins_softening": Mullins,
    "exponential_stiffness": ExponentialStiffness,
    "layer_over_core": HardCore,
    "sensor_lag": SensorLag,
    "sensor_delay": SensorDelay,
    "cross_talk": CrossTalk,
    "force_drift": ForceDrift,
    "load_dependent_friction": LoadDependentFriction,
    "rate_dependent_friction": RateDependentFriction,
    "friction_ageing": FrictionAgeing,
    "wet_contact": WetContact,
    "contact_radius_law": RadiusLaw,
    "pressure_profile": PressureProfile,
    "nonseparable_relaxation": NonSeparable,
    "poroelastic_drainage": Drainage,
    "rate_stiffening": RateStiffening,
    "fast_damping": FastDamping,
    "temperature_shift": Softening,
    "guide_friction": GuideFriction,
    "saturation": Saturation,
}
"""By the names that a diagnosis gives them."""

UNMODELLED: Mapping[str, type[Unknown]] = {
    "cogging": Cogging,
    "magnet": Magnet,
    "day_and_night": DayAndNight,
    "crack": Crack,
    "transfer_film": TransferFilm,
    "shear_shrinking": ShearShrinking,
    "speed_band": SpeedBand,
    "warm_peak": WarmPeak,
}
"""Effects that no catalogue has; each says in ``shows`` over which variables it is a curve."""


def make(settings: Mapping[str, Mapping[str, float]]) -> tuple[Hidden, ...]:
    """Return the hidden effects of ``settings``: name -> parameters, SI; those left out have their default.

    Raises:
        ConfigError: there is no such effect or parameter.

    """
    made = []
    for name, given in settings.items():
        every = {**HIDDEN, **UNMODELLED}
        if name not in every:
            raise ConfigError(f"hidden: there is no effect {name!r}; there are {', '.join(every)}")
        known = [f.name for f in fields(every[name]) if f.init]  # type: ignore[arg-type]
        for key in given:
            if key not in known:
                raise ConfigError(f"hidden {name}: unknown key {key!r}; known are {', '.join(known)}")
        made.append(every[name](**given))
    return tuple(made)
