"""Parameters that nothing recorded feels: derivatives by them are nothing, and need no run of the model.

Stages that only read states change no force: the friction and the pressure show while a contact slides, the
area in the contact radius as well. A recording of force and displacement alone feels none of them.
"""

import inspect

from vegrip.effects.contract import READING
from vegrip.model import ContactModel


def unfelt(model: ContactModel, *, shows_slip: bool, shows_radius: bool) -> frozenset[str]:
    """Return the symbols of the parameters of ``model`` that no row of a recording feels."""
    silent = () if shows_slip else READING[1:] if shows_radius else READING
    hooks = [hook for effect in model.effects for hook in effect.hooks if hook.stage not in silent]
    taken = {name for hook in hooks for name in inspect.signature(hook.function).parameters}
    return frozenset(model.parameters) - taken
