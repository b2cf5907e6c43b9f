"""The picture of a draft: what the model left, and what the law adds, over the law's variable."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vegrip.identification.draft.search import Draft
from vegrip.identification.draft.text import PROBE_NAME
from vegrip.identification.fit.problem import AT
from vegrip.identification.fit.solve import covariance
from vegrip.plotting import new_figure, save_figure
from vegrip.types import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DRAWN = 4000  # dots
SURE = 1.96  # standard deviations: 95 %


def curve(found: Draft, most: int) -> dict[str, Any]:
    """Return what the model left and what the law adds [N] over its variable, of no more than ``most`` rows.

    ``low`` and ``high`` hold the change with 95 %, as far as the amount is concerned.
    """
    taken = found.taken
    assert taken is not None  # noqa: S101
    problem = found.base.problem
    before = problem.table(found.base.optimum.u)[:, AT["normal_force"]]
    after = taken.fitted.problem.table(taken.fitted.optimum.u)[:, AT["normal_force"]]
    rows = np.flatnonzero((problem.stiffness > 0.0) & problem.used)
    rows = rows[:: max(-(-rows.size // most), 1)]
    low, high = interval(found, before, after)
    left = problem.measured.force - before
    columns = {"q": found.q, "left": left, "law": after - before, "low": low, "high": high}
    return {
        "title": taken.law.equation,
        "label": f"q: {taken.law.scaled}",
        "columns": {name: values[rows].tolist() for name, values in columns.items()},
    }


def draw_draft(found: Draft, path: Path) -> None:
    """Draw the law that was taken."""
    save_figure(draft_figure(found), path)


def draft_figure(found: Draft) -> "Figure":
    """Return the picture of the law that was taken."""
    shown = curve(found, DRAWN)
    q, left, law, low, high = shown["columns"].values()
    figure, (axis,) = new_figure(size=(7.5, 4.5))
    axis.plot(q, left, ".", ms=2, color="0.6", label="measured less model")
    axis.vlines(q, low, high, color="C0", alpha=0.25, label="its 95 % interval")
    axis.plot(q, law, ".", ms=2, color="C0", label="model with the law less model")
    axis.set_xlabel(shown["label"])
    axis.set_ylabel("normal force [N]")
    axis.set_title(shown["title"], fontsize=10)
    axis.legend(markerscale=4)
    return figure


def interval(found: Draft, before: Floats, after: Floats) -> tuple[Floats, Floats]:
    """Return the least and the largest change [N] (n,) within 95 % of the amount's standard error."""
    taken = found.taken
    assert taken is not None  # noqa: S101
    k = taken.fitted.problem.unknowns
    at = k.names.index(f"c_{PROBE_NAME}")
    std = math.sqrt(float(covariance(taken.fitted.problem, taken.fitted.optimum)[at, at]))
    part = SURE * std / max(abs(float(taken.fitted.optimum.u[at])), 1e-300)
    change = after - before
    return change - part * np.abs(change), change + part * np.abs(change)
