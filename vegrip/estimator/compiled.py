"""The generated module of an estimator: effects, limit surface and kernels in one flat file."""

import ctypes
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from vegrip.c99 import LONGS, MEMORY, REAL
from vegrip.contact import limit_surface
from vegrip.effects.contract import Effect
from vegrip.estimator.layout import Layout
from vegrip.estimator.memory import SampleLayout
from vegrip.estimator.origins import Origins
from vegrip.model import ContactModel, native, writer
from vegrip.model.composer import compose

KERNELS = (
    "state", "covariance_root", "load_law", "motion", "predict", "scalar_update", "measure",
    "displacement_loss", "initialisation", "gap", "touch_detection", "quantities", "report", "consistency",
    "friction", "load_loss", "hold_model", "slip_probability", "forecast", "update",
)  # fmt: skip
SHARED = ("elapsed", "normal_law")
"""Texts that Python imports too."""
ENTRIES = ("update", "margin_of", "least_force", "filter_step")
NODE_ENTRIES = ("look_at_cells",)
"""What only a node calls; the firmware that is exported does not have it."""
CLOCK_ENTRIES = ("assimilate",)
KINDS: Final[native.Entries] = {
    "update": (MEMORY, *[REAL] * 7),
    "filter_step": (MEMORY, *[REAL] * 4),
    "margin_of": (MEMORY, REAL, REAL, MEMORY),
    "least_force": (MEMORY, *[REAL] * 4),
    "look_at_cells": (MEMORY, REAL, MEMORY),
    "assimilate": (MEMORY, LONGS),
}
"""Of the arguments of all of them."""
WRITTEN: Final = {"margin_of": 5, "look_at_cells": 6}
"""How many numbers an entry writes besides the memory."""

ELLIPSE = "RADIUS_TABLE = 0.0 * RADIUS_TABLE"
"""Takes the correction off the limit surface: what is left is the ellipse through the same two ends."""

Kernels = Any
"""A generated module, or what stands for it: :class:`vegrip.model.native.ModuleC`."""


def module_for(
    model: ContactModel, layout: Layout, *, late: int = 0, plain: bool = False, ellipse: bool = False
) -> Kernels:
    """Return the module; ``plain`` leaves it uncompiled, to step through with a debugger.

    In single precision the memory stays an array of doubles, which are copied at each call.
    With ``ellipse`` the limit surface is the usual one, (f / mu N)^2 + (m / m_max)^2 = 1, for comparisons.
    """
    text = node_text_of(model, layout, late=late, ellipse=ellipse)
    single: dict[str, tuple[int, ...]] = {name: (layout.size, WRITTEN.get(name, 0)) for name in KINDS}
    single["assimilate"] = (SampleLayout(layout, late).n_reals,)
    return native.run_by(
        "python" if plain else native.kernel_mode(), text, KINDS, Origins(model.effects).place,
        single=single, results={"least_force": ctypes.c_double},
    )  # fmt: skip


def text_of(model: ContactModel, layout: Layout, *, ellipse: bool = False) -> str:
    """Return the text of the filter alone; its hash marks what firmware saves."""
    return _text(model.effects, layout, ellipse)


def node_text_of(model: ContactModel, layout: Layout, *, late: int = 0, ellipse: bool = False) -> str:
    """Return the text of the module that a node has, to be compiled by numba or translated to C."""
    health = kernel_text("health")
    parts = [health, *clock_parts(SampleLayout(layout, late))]
    return text_with(model, layout, parts, (*NODE_ENTRIES, *CLOCK_ENTRIES), ellipse=ellipse)


def clock_text_of(model: ContactModel, layout: Layout, *, ellipse: bool = False) -> str:
    return text_with(model, layout, clock_parts(SampleLayout(layout)), CLOCK_ENTRIES, ellipse=ellipse)


def clock_parts(layout: SampleLayout) -> list[str]:
    """Return the texts of the clock of the samples: places and kernel."""
    return [layout.constants(), kernel_text("sense")]


def kernel_text(name: str) -> str:
    return Path(__file__).with_name("kernels").joinpath(f"{name}.py").read_text(encoding="utf-8")


def text_with(
    model: ContactModel,
    layout: Layout,
    parts: Sequence[str],
    entries: Sequence[str],
    *,
    ellipse: bool = False,
) -> str:
    return _text(model.effects, layout, ellipse, tuple(parts), tuple(entries))


@lru_cache(maxsize=32)
def _text(
    effects: tuple[Effect, ...],
    layout: Layout,
    ellipse: bool,
    more: tuple[str, ...] = (),
    entries: tuple[str, ...] = (),
) -> str:
    """Return the text of the module; the fingers of a hand share it, and writing it takes 0.1 s."""
    parts = [*estimator_parts(layout, ellipse=ellipse), *more]
    names = [effect.name for effect in effects]
    return writer.write(compose(effects), names, parts, (*ENTRIES, *entries))


def estimator_parts(layout: Layout, *, ellipse: bool = False) -> list[str]:
    """Return the texts that stand below the model: places, limit surface, kernels."""
    surface = Path(limit_surface.__file__).with_name("fast.py").read_text(encoding="utf-8")
    parts = [layout.constants(), f"{surface}\n{ELLIPSE}\n" if ellipse else surface]
    shared = [Path(__file__).with_name(f"{name}.py").read_text(encoding="utf-8") for name in SHARED]
    return [*parts, *shared, *map(kernel_text, KERNELS)]
