"""The generated module of an estimator: effects, limit surface and kernels in one flat file."""

from functools import lru_cache
from pathlib import Path
from types import ModuleType

from vegrip.contact import limit_surface
from vegrip.effects.contract import Effect
from vegrip.estimator.layout import Layout
from vegrip.model import ContactModel, cache, writer
from vegrip.model.composer import compose

KERNELS = (
    "state", "roots", "motion", "predict", "gain", "measure", "sight", "begin", "gap", "touch", "quantities", "report",
    "belief", "friction", "hold", "onset", "forecast", "update",
)  # fmt: skip
ENTRIES = ("update", "margin_of", "least_force", "filter_step", "many")


ELLIPSE = "RADIUS_TABLE = 0.0 * RADIUS_TABLE"
"""Takes the correction off the limit surface: what is left is the ellipse through the same two ends."""


def module_for(
    model: ContactModel, layout: Layout, *, plain: bool = False, ellipse: bool = False
) -> ModuleType:
    """Return the module; ``plain`` leaves it uncompiled, to step through with a debugger.

    With ``ellipse`` the limit surface is the usual one, (f / mu N)^2 + (m / m_max)^2 = 1, for comparisons.
    """
    text = _text(model.effects, layout, ellipse)
    return cache.load_plain(text) if plain else cache.load(text)


@lru_cache(maxsize=32)
def _text(effects: tuple[Effect, ...], layout: Layout, ellipse: bool) -> str:
    """Return the text of the module; the fingers of a hand share it, and writing it takes 0.1 s."""
    here = Path(__file__).parent / "kernels"
    surface = Path(limit_surface.__file__).with_name("fast.py").read_text(encoding="utf-8")
    kernels = [here.joinpath(f"{name}.py").read_text(encoding="utf-8") for name in KERNELS]
    surfaces = [surface, ELLIPSE] if ellipse else [surface]
    parts = [layout.constants(), *surfaces, *kernels]
    return writer.write(compose(effects), [effect.name for effect in effects], parts, ENTRIES)
