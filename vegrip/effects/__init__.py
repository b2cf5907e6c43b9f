"""Physical effects, one per file. A name leads to a module with an ``EFFECT``; other packages add theirs.

A package of your own adds an effect by an entry point in the group ``vegrip.effects``::

    [project.entry-points."vegrip.effects"]
    my_effect = "my_package.my_effect:EFFECT"
"""

import importlib
from collections.abc import Sequence
from importlib.metadata import entry_points
from pathlib import Path

from vegrip.effects.contract import Effect, Hook, State, hook
from vegrip.effects.file import read_effect
from vegrip.errors import ModelError, suggestion

__all__ = ["BUILT_IN", "Effect", "Hook", "State", "effect", "hook", "names", "place"]

BUILT_IN = (
    "displacement_lag",
    "displacement_backlash",
    "inclination",
    "series_compliance",
    "permanent_set",
    "jkr_adhesion",
    "power_law_stiffness",
    "exponential_stiffness",
    "layer_over_core",
    "second_contact",
    "mullins_softening",
    "healing_softening",
    "temperature_shift",
    "nonseparable_relaxation",
    "poroelastic_drainage",
    "relaxation",
    "second_relaxation",
    "power_law_relaxation",
    "relaxation_spectrum",
    "rate_stiffening",
    "fast_damping",
    "adhesion",
    "inertia",
    "rolling",
    "guide_friction",
    "approach_tilt",
    "cross_talk",
    "sensor_lag",
    "sensor_delay",
    "force_drift",
    "saturation",
    "geometric_radius",
    "contact_radius_law",
    "pressure_coupling",
    "pressure_profile",
    "coulomb_friction",
    "load_dependent_friction",
    "rate_dependent_friction",
    "friction_ageing",
    "wet_contact",
    "presliding",
)
"""In the order in which they act, from the drive over the contact to the sensor's output."""

GROUP = "vegrip.effects"


def names() -> list[str]:
    """Return the names of all effects, built in and added by other packages."""
    return [*BUILT_IN, *sorted(point.name for point in entry_points(group=GROUP))]


def effect(name: str) -> Effect:
    """Return the effect called ``name``, or that in the file ``name`` if it ends in ``.py``.

    Raises:
        InputError: the file cannot be read.
        ModelError: there is no such effect, or the package or file that has it does not hold to the contract.

    """
    if name.endswith(".py"):
        return read_effect(Path(name))
    if name in BUILT_IN:
        found: object = importlib.import_module(f"{__name__}.{name}").EFFECT
    else:
        point = next(iter(entry_points(group=GROUP, name=name)), None)
        if point is None:
            raise ModelError(f"there is no effect {name!r}; {suggestion(name, names())}")
        found = point.load()
    if not isinstance(found, Effect):
        raise ModelError(f"the effect {name!r} is not an Effect; its entry point must name one")
    return found


def place(present: Sequence[str], name: str) -> int:
    """Return where ``name`` belongs among the effects ``present``: before the first that acts later.

    An effect of another package goes to the end.
    """
    if name in BUILT_IN:
        later = BUILT_IN[BUILT_IN.index(name) + 1 :]
        return next((i for i, other in enumerate(present) if other in later), len(present))
    return len(present)
