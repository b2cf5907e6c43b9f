"""The memory of one finger that the compiled step works on: two flat arrays, and names for their places."""

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.grip.layout import FingerLayout


class FingerMemory:
    """Real numbers ``f``, whole numbers ``t``, and every one of them by its name.

    Args:
        layout: the names.

    """

    def __init__(self, layout: FingerLayout) -> None:
        self.layout = layout
        self.f = np.zeros(layout.n_reals)
        self.t = np.zeros(layout.n_wholes, dtype=np.int64)
        self._places: dict[str, tuple[NDArray[Any], int]] = {
            **{name: (self.f, place) for name, place in layout.reals.items()},
            **{name: (self.t, place) for name, place in layout.wholes.items()},
        }

    def __getitem__(self, name: str) -> Any:
        """Return a number."""
        array, place = self._places[name]
        return array.item(place)

    def __setitem__(self, name: str, value: float) -> None:
        """Set a number."""
        array, place = self._places[name]
        array[place] = value

    def take_over(self, other: "FingerMemory", but: Collection[str]) -> None:
        """Take all sections from another memory, but for those named."""
        for name, (start, end) in other.layout.sections.items():
            if name not in but and name in self.layout.sections and end > start:
                self.section(name)[:] = other.section(name)

    def section(self, name: str) -> NDArray[Any]:
        """Return the numbers of a section, to read and to write."""
        start, end = self.layout.sections[name]
        array = self.f if name == "ESTIMATOR" else self._places[f"{name}0"][0]
        return array[start:end]
