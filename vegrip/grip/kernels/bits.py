"""IEEE 754 singles as they stand in a frame: bits from and to numbers. In C a helper stands for these two."""

import numpy as np


def real_of_bits(bits: int) -> float:
    """Return the number of a single whose 32 bits are given."""
    return float(np.uint32(bits).view(np.float32))


def bits_of_real(value: float) -> int:
    """Return the bits of the nearest single; ``value`` must not be beyond the largest."""
    return int(np.int64(np.float32(value).view(np.uint32)))
