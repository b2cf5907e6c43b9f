"""The last half minute of one finger as columns: least, greatest and newest value of each 40 ms.

A screen has fewer columns than a node has samples; keeping the least and the greatest of each column loses no
peak. Pure; a column is closed by its owner's clock.
"""

import math
from collections import deque
from dataclasses import dataclass, field

COLUMN_PERIOD_S = 0.04  # [s] of one column
SPAN = 30.0  # [s] that are kept
COLUMN_COUNT = round(SPAN / COLUMN_PERIOD_S)
COLUMN_NAMES = (
    "margin",  # [-]
    "bound",  # [-] lower bound of the margin
    "normal_force",  # [N]
    "contact_radius",  # [m]
    "pressure_exponent",  # [-]
    "friction_coefficient",  # [-]
    "command",  # [N]
)
BANDS = ("normal_force", "contact_radius", "pressure_exponent", "friction_coefficient")
"""Quantities that are kept with their standard deviation."""

Column = list[float | None]
"""[least, greatest, newest] of each of ``COLUMN_NAMES``, then the newest std of each of ``BANDS``."""


@dataclass
class Columns:
    """The columns of one finger, oldest first."""

    closed: deque[Column] = field(default_factory=lambda: deque(maxlen=COLUMN_COUNT))
    _open: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    _stds: dict[str, float] = field(default_factory=dict)

    def note(self, name: str, value: float, std: float = math.nan) -> None:
        """Take a value of the open column; one that is not finite is none."""
        if not math.isfinite(value):
            return
        least, greatest, _ = self._open.get(name, (value, value, value))
        self._open[name] = (min(least, value), max(greatest, value), value)
        self._stds[name] = std

    def close(self) -> Column:
        """End the open column, keep and return it; what was not heard in it is None."""
        column: Column = []
        for name in COLUMN_NAMES:
            column += [_short(v) for v in self._open.get(name, (math.nan,) * 3)]
        column += [_short(self._stds.get(name, math.nan)) for name in BANDS]
        self.closed.append(column)
        self._open, self._stds = {}, {}
        return column


def _short(value: float) -> float | None:
    return float(f"{value:.4g}") if math.isfinite(value) else None
