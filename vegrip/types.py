"""Types that every part names alike."""

from collections.abc import MutableSequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
"""An array of floating-point numbers; its shape stands in the docstring of what takes or returns it."""

Numbers = MutableSequence[float] | Floats
"""What text reads and writes that runs over a list in Python and over an array when compiled."""
