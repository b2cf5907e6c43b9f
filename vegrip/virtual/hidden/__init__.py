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
from vegrip.virtual.hidden.mount import Backlash, SeriesCompliance
from vegrip.virtual.hidden.patch import PressureProfile, RadiusLaw
from vegrip.virtual.hidden.relaxations import PowerLawRelaxation, SecondRelaxation
from vegrip.virtual.hidden.rubbing import (
    FrictionAgeing,
    LoadDependentFriction,
    RateDependentFriction,
    WetContact,
)
from vegrip.virtual.hidden.sensor import CrossTalk, ForceDrift, SensorLag
from vegrip.virtual.hidden.stiffness import ExponentialStiffness, HardCore
from vegrip.virtual.hidden.wear import Mullins, PermanentSet

__all__ = ["HIDDEN", "Hidden", "make"]

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
    "cross_talk": CrossTalk,
    "force_drift": ForceDrift,
    "load_dependent_friction": LoadDependentFriction,
    "rate_dependent_friction": RateDependentFriction,
    "friction_ageing": FrictionAgeing,
    "wet_contact": WetContact,
    "contact_radius_law": RadiusLaw,
    "pressure_profile": PressureProfile,
}
"""By the names that a diagnosis gives them."""


def make(settings: Mapping[str, Mapping[str, float]]) -> tuple[Hidden, ...]:
    """Return the hidden effects of ``settings``: name -> parameters, SI; those left out have their default.

    Raises:
        ConfigError: there is no such effect or parameter.

    """
    made = []
    for name, given in settings.items():
        if name not in HIDDEN:
            raise ConfigError(f"hidden: there is no effect {name!r}; there are {', '.join(HIDDEN)}")
        known = [f.name for f in fields(HIDDEN[name]) if f.init]  # type: ignore[arg-type]
        for key in given:
            if key not in known:
                raise ConfigError(f"hidden {name}: unknown key {key!r}; known are {', '.join(known)}")
        made.append(HIDDEN[name](**given))
    return tuple(made)
