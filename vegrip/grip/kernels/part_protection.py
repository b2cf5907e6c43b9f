"""AUTOSAR E2E profile 11: CRC-8 of the Data ID, low byte first, and of all bytes behind it."""

import numpy as np

from vegrip.grip.kernels.generated import *

CRC8_OF_NIBBLE = np.array([
    0x00, 0x1D, 0x3A, 0x27, 0x74, 0x69, 0x4E, 0x53, 0xE8, 0xF5, 0xD2, 0xCF, 0x9C, 0x81, 0xA6, 0xBB,
])  # fmt: skip
"""Remainders of the polynomial 0x1D (CRC-8 of SAE J1850)."""
NO_COUNTER = 15  # of profile 11


def crc8_with(crc: int, byte: int) -> int:
    """Return the remainder after one more byte, half by half."""
    mixed = crc ^ byte
    high = (mixed << 4 & 0xFF) ^ int(CRC8_OF_NIBBLE[mixed >> 4])
    return (high << 4 & 0xFF) ^ int(CRC8_OF_NIBBLE[high >> 4])


def crc8_of(data: Bytes, length: int, data_id: int) -> int:
    """Return the checksum of a frame of ``length`` bytes."""
    crc = crc8_with(crc8_with(0, data_id & 255), data_id >> 8)
    for i in range(1, length):
        crc = crc8_with(crc, int(data[i]))
    return crc


def is_part_intact(data: Bytes, length: int, data_id: int) -> bool:
    """Return whether the checksum fits and the counter is one."""
    return (int(data[1]) & 15) != NO_COUNTER and int(data[0]) == crc8_of(data, length, data_id)


def protect_short(data: Bytes, length: int, data_id: int) -> None:
    """Put the checksum into a frame that is complete."""
    data[0] = crc8_of(data, length, data_id)
