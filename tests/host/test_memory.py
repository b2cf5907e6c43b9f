"""What is free between arrays that stay goes back."""

import sys
from pathlib import Path

import numpy as np
import pytest

from vegrip.host.memory import give_back_memory

ARRAYS, NUMBERS = 2_000, 8_000  # 128 MB, each less than what the C library asks of the system by itself


def resident() -> int:
    """Return the pages that this process has in memory."""
    return int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads what Linux tells of a process")
def test_holes_between_arrays_that_stay_are_given_back() -> None:
    arrays = [np.ones(NUMBERS) for _ in range(ARRAYS)]
    kept, before = arrays[::10], resident()
    del arrays
    give_back_memory()
    freed = (before - resident()) * 4096
    assert freed > 0.5 * 8 * NUMBERS * (ARRAYS - len(kept))
    assert all(one.all() for one in kept)
