"""Types that every part names alike."""

from collections.abc import MutableSequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
"""An array of floating-point numbers; its shape stands in the docstring of what takes or returns it."""

Numbers = MutableSequence[float] | Floats
"""What text reads and writes that runs over a list in Python and over an array when compiled."""


class NamedNumbers(Protocol):
    """Numbers in flat arrays, by name: what the compiled finger step works on (:mod:`vegrip.grip.layout`)."""

    def __getitem__(self, name: str) -> Any:
        """Return a number."""

    def __setitem__(self, name: str, value: float) -> None:
        """Set a number."""

    def section(self, name: str) -> NDArray[Any]:
        """Return the numbers of a section, to read and to write."""
