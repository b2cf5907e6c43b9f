"""Figures as files, in one way for all commands: no window, no global state; matplotlib is an extra."""

import logging
from pathlib import Path
from typing import TYPE_CHECKING

from vegrip.errors import InputError, UsageError
from vegrip.whole_file import whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 110


def new_figure(
    rows: int = 1, *, size: tuple[float, float], share_x: bool = False
) -> tuple["Figure", list["Axes"]]:
    """Return a figure of ``size`` (width, height) [inch] and its panels, one below the other.

    Raises:
        UsageError: matplotlib is not installed.

    """
    try:
        from matplotlib.figure import Figure  # noqa: PLC0415 (an extra)
    except ImportError:
        raise UsageError("pictures need matplotlib; pip install 'vegrip[plot]'") from None
    logging.getLogger("matplotlib").setLevel(logging.WARNING)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(rows, 1, sharex=share_x, squeeze=False)
    return figure, list(panels[:, 0])


def save_figure(figure: "Figure", path: Path, dpi: int = DPI) -> None:
    """Write ``figure`` to ``path``, in the format that its ending names; folders are made.

    A figure that is drawn again gives the same file.

    Raises:
        InputError: it cannot be written there, or the ending names no format.

    """
    from matplotlib import rc_context  # noqa: PLC0415 (an extra)

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with rc_context({"svg.hashsalt": "vegrip"}), whole_file(path) as part:
            figure.savefig(part, dpi=dpi)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: the picture cannot be written ({error})") from None
