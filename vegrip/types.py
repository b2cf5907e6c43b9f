"""Types that every part names alike."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
"""An array of floating-point numbers; its shape stands in the docstring of what takes or returns it."""
