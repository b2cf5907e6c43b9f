"""Parts of a virtual hand by themselves: their records, and the compiled steps on them."""

from dataclasses import fields

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import kernels
from vegrip.virtual.fingertip import Grid, even_grid
from vegrip.virtual.history import History, prony
from vegrip.virtual.profile import coefficient_logarithms, ring_shares


def tips_of(count: int, **values: float | list[float] | Floats) -> kernels.Records:
    """Return records of tips; what is not given is zero."""
    tips = np.zeros(count, kernels.TIP)
    for name, value in values.items():
        tips[name] = value
    return tips


def body_of(*settings: object, **values: float) -> kernels.Records:
    """Return the record that the fingers share, with what settings have of it."""
    body = np.zeros(1, kernels.BODY)
    known = {f.name: getattr(one, f.name) for one in settings for f in fields(one)} | values  # type: ignore[arg-type]
    for name in known.keys() & kernels.Body.__annotations__.keys():
        body[name] = known[name]
    return body


def hand_of(body: kernels.Records, tips: kernels.Records, grid: Grid | None = None) -> kernels.Hand:
    """Return all that the compiled steps of a hand work on."""
    grid = grid or even_grid(8, 16)
    history = History([prony((0.2,), (3.0,))] * len(tips), 1e-3, fine=8)
    tables = coefficient_logarithms(), ring_shares(grid.edges)
    return kernels.Hand(body, grid.contacts(tips), history.memory, *tables)
