"""Sizes of the fields of a frame [ISO2015]_."""

from typing import Final

DATA_SIZES: Final = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)  # bytes by length code
AFTER_CRC: Final = 1 + 1 + 1 + 7 + 3  # CRC delimiter, ACK, ACK delimiter, end of frame, between frames
AFTER_CRC_FD: Final = AFTER_CRC - 1  # the CRC delimiter is sent at the data bit rate
