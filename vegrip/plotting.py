"""Figures, in one way for all: no window, no global state; matplotlib is an extra."""

import io
import itertools
import logging
import statistics
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vegrip.errors import InputError, UsageError
from vegrip.whole_file import whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 110
MIN_GAP_STEPS = 8.0  # times the usual step, from which on nothing was measured between two columns


def runs(times: Sequence[float]) -> list[slice]:
    """Return the stretches of ``times`` that no gap parts: what was not measured is not drawn.

    >>> runs([0.0, 1.0, 2.0, 60.0, 61.0])
    [slice(0, 3, None), slice(3, 5, None)]
    """
    steps = [later - sooner for sooner, later in itertools.pairwise(times)]
    gap = MIN_GAP_STEPS * statistics.median(steps) if steps else 0.0
    ends = [0, *(i for i, step in enumerate(steps, 1) if step > gap), len(times)]
    return [slice(begin, end) for begin, end in itertools.pairwise(ends) if end > begin]


def empty_figure(size: tuple[float, float]) -> "Figure":
    """Return a figure of ``size`` (width, height) [inch]; as the result of a notebook's cell it is shown.

    Raises:
        UsageError: matplotlib is not installed.

    """
    try:
        from matplotlib.figure import Figure  # noqa: PLC0415 (an extra)
    except ImportError:
        raise UsageError("pictures need matplotlib; pip install 'vegrip[plot]'") from None
    logging.getLogger("matplotlib").setLevel(logging.WARNING)
    figure: Figure = _shown(Figure)(figsize=size, layout="constrained")
    return figure


@cache
def _shown(plain: Any) -> Any:
    class Figure(plain):  # type: ignore[misc]  # matplotlib is an extra
        """A figure that a notebook shows, whether or not pyplot is in use."""

        def _repr_png_(self) -> bytes:
            out = io.BytesIO()
            self.savefig(out, format="png", dpi=DPI)
            return out.getvalue()

    return Figure


def new_figure(
    rows: int = 1, *, size: tuple[float, float], share_x: bool = False
) -> tuple["Figure", list["Axes"]]:
    """Return an :func:`empty_figure` of ``size`` with its panels, one below the other."""
    figure = empty_figure(size)
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
