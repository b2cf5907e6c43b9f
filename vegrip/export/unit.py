"""What is exported, estimator or finger, for the templates of both."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vegrip.c99.kinds import Kind
from vegrip.estimator.memory import FingerMemory
from vegrip.estimator.origins import Origins


@dataclass(frozen=True)
class Unit:
    """A generated text and its entries, a memory, and what the templates know besides."""

    text: str
    origins: Origins
    entries: Mapping[str, tuple[Kind, ...]]
    blank: FingerMemory
    """Before the first sample."""
    reals: NDArray[np.float64]
    """Of the memory after the recorded sequence."""
    words: Mapping[str, str]
    command: int = 0
    """Bytes of a command."""
