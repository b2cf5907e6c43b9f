"""Physical effects, one per file. A name leads to a module with an ``EFFECT``; other packages add theirs.

A package of your own adds an effect by an entry point in the group ``vegrip.effects``::

    [project.entry-points."vegrip.effects"]
    my_effect = "my_package.my_effect:EFFECT"
"""

import importlib
from importlib.metadata import entry_points

from vegrip.effects.contract import Effect, Hook, State, hook
from vegrip.errors import ModelError

__all__ = ["BUILT_IN", "Effect", "Hook", "State", "effect", "hook", "names"]

BUILT_IN = (
    "power_law_stiffness",
    "relaxation",
    "second_relaxation",
    "series_compliance",
    "geometric_radius",
    "pressure_coupling",
    "coulomb_friction",
)
GROUP = "vegrip.effects"


def names() -> list[str]:
    """Return the names of all effects, built in and added by other packages."""
    return [*BUILT_IN, *sorted(point.name for point in entry_points(group=GROUP))]


def effect(name: str) -> Effect:
    """Return the effect called ``name``.

    Raises:
        ModelError: there is no such effect, or the package that adds it does not hold to the contract.

    """
    if name in BUILT_IN:
        found: object = importlib.import_module(f"{__name__}.{name}").EFFECT
    else:
        point = next(iter(entry_points(group=GROUP, name=name)), None)
        if point is None:
            raise ModelError(f"there is no effect {name!r}; there are {', '.join(names())}")
        found = point.load()
    if not isinstance(found, Effect):
        raise ModelError(f"the effect {name!r} is not an Effect; its entry point must name one")
    return found
