"""Whole numbers in the bytes of a frame, the least significant byte first."""

from vegrip.grip.kernels.generated import *


def word(data: Bytes, at: int) -> int:
    """Return the 32 bits at byte ``at``."""
    return int(data[at]) | int(data[at + 1]) << 8 | int(data[at + 2]) << 16 | int(data[at + 3]) << 24


def put_word(data: Bytes, at: int, bits: int) -> None:
    """Put 32 bits at byte ``at``."""
    data[at] = bits & 255
    data[at + 1] = (bits >> 8) & 255
    data[at + 2] = (bits >> 16) & 255
    data[at + 3] = (bits >> 24) & 255


def half_word(data: Bytes, at: int) -> int:
    """Return the 16 bits at byte ``at``."""
    return int(data[at]) | int(data[at + 1]) << 8


def put_half_word(data: Bytes, at: int, bits: int) -> None:
    """Put 16 bits at byte ``at``."""
    data[at] = bits & 255
    data[at + 1] = (bits >> 8) & 255
