"""The generated module of an estimator: effects, limit surface and kernels in one flat file."""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from vegrip.c99 import UntranslatableError
from vegrip.c99.host import CompilerError
from vegrip.contact import limit_surface
from vegrip.effects.contract import Effect
from vegrip.estimator import kernels_c
from vegrip.estimator.layout import Layout
from vegrip.estimator.origins import Origins
from vegrip.model import ContactModel, cache, writer
from vegrip.model.composer import compose
from vegrip.model.native import kernel_mode, tell_once

KERNELS = (
    "state", "covariance_root", "motion", "predict", "scalar_update", "measure", "displacement_loss",
    "initialisation", "gap", "touch_detection", "quantities", "report", "consistency", "friction",
    "load_loss", "hold_model", "slip_probability", "forecast", "update",
)  # fmt: skip
ENTRIES = ("update", "margin_of", "least_force", "filter_step")
BESIDE_FIRMWARE = ("health",)
"""Kernels that only a node calls; the firmware that is exported does not have them."""
NODE_ENTRIES = ("look_at_cells",)

ELLIPSE = "RADIUS_TABLE = 0.0 * RADIUS_TABLE"
"""Takes the correction off the limit surface: what is left is the ellipse through the same two ends."""

Kernels = Any
"""A generated module, or what stands for it: :class:`vegrip.estimator.kernels_c.KernelsC`."""


def module_for(model: ContactModel, layout: Layout, *, plain: bool = False, ellipse: bool = False) -> Kernels:
    """Return the module; ``plain`` leaves it uncompiled, to step through with a debugger.

    Where C cannot be had, numba runs it; the reason is told once if C was asked for, or the compiler failed.
    With ``ellipse`` the limit surface is the usual one, (f / mu N)^2 + (m / m_max)^2 = 1, for comparisons.
    """
    text, mode = node_text_of(model, layout, ellipse=ellipse), kernel_mode()
    if plain or mode == "python":
        return cache.load_plain(text)
    if mode in {"c", "c-float"}:
        try:
            single = layout.size if mode == "c-float" else 0
            return kernels_c.load(text, Origins(model.effects).place, single=single)
        except (CompilerError, UntranslatableError) as error:
            tell_once(str(error))
    return cache.load(text)


def text_of(model: ContactModel, layout: Layout, *, ellipse: bool = False) -> str:
    """Return the text of the module that firmware has."""
    return _text(model.effects, layout, ellipse)


def node_text_of(model: ContactModel, layout: Layout, *, ellipse: bool = False) -> str:
    """Return the text of the module that a node has, to be compiled by numba or translated to C."""
    here = Path(__file__).parent / "kernels"
    more = [here.joinpath(f"{name}.py").read_text(encoding="utf-8") for name in BESIDE_FIRMWARE]
    return text_with(model, layout, more, NODE_ENTRIES, ellipse=ellipse)


def text_with(
    model: ContactModel,
    layout: Layout,
    parts: Sequence[str],
    entries: Sequence[str],
    *,
    ellipse: bool = False,
) -> str:
    """Return the text of a module with ``parts`` after the kernels, called through ``entries`` too."""
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
    here = Path(__file__).parent
    surface = Path(limit_surface.__file__).with_name("fast.py").read_text(encoding="utf-8")
    names = ("elapsed", *(f"kernels/{name}" for name in KERNELS))
    kernels = [here.joinpath(f"{name}.py").read_text(encoding="utf-8") for name in names]
    parts = [layout.constants(), f"{surface}\n{ELLIPSE}\n" if ellipse else surface]
    return [*parts, *kernels]
