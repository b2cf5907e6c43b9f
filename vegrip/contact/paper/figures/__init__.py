"""The figures of the paper that show results, one function each, drawn with matplotlib (extra ``plot``)."""

import importlib
from pathlib import Path
from typing import TYPE_CHECKING

from vegrip.errors import UsageError
from vegrip.spelling import suggestion
from vegrip.whole_file import whole_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURES = {
    "fig02": ("pressures", "profiles"),
    "fig04": ("pressures", "relaxation"),
    "fig05": ("pressures", "coupled_growth"),
    "fig06": ("couplings", "power_law"),
    "fig07": ("couplings", "exponent"),
    "fig08": ("pressures", "creep"),
    "fig09": ("limit_surfaces", "constant_area"),
    "fig10": ("limit_surfaces", "constant_load"),
    "fig12": ("couplings", "radius_fit"),
}


def draw(name: str) -> "Figure":
    """Draw one figure of :data:`FIGURES`.

    Raises:
        UsageError: there is no such figure, or matplotlib is not installed.

    """
    if name not in FIGURES:
        raise UsageError(f"there is no figure {name!r}; {suggestion(name, FIGURES)}")
    module, function = FIGURES[name]
    try:
        drawn: Figure = getattr(importlib.import_module(f"{__name__}.{module}"), function)()
    except ModuleNotFoundError as error:
        if error.name != "matplotlib":
            raise
        raise UsageError("drawing needs matplotlib: pip install 'vegrip[plot]'") from None
    return drawn


def save_all(folder: Path) -> list[Path]:
    """Draw every figure as PNG into ``folder``, which is made when it is missing; return the files.

    Raises:
        UsageError: the folder cannot be written, or matplotlib is not installed.

    """
    files = [folder / f"{name}.png" for name in FIGURES]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for file in files:
            with whole_file(file) as part:
                draw(file.stem).savefig(part)
    except OSError as error:
        raise UsageError(f"cannot write figures into {folder}: {error.strerror}") from None
    return files
