"""End-to-end protection: the AUTOSAR E2E profiles in use, computed by the library `autosar-e2e`.

A profile puts a checksum and a counter into the message. The checksum also covers a Data ID that both
sides know and that says which message this is, so that a good message in the wrong place is refused.

=======  ============================  ==========================  =========================
profile  where                         checksum                    counter
=======  ============================  ==========================  =========================
P11      8-byte CAN frames             CRC-8, byte 0               0..14, low nibble, byte 1
P05      CAN FD frames                 CRC-16, bytes 0 and 1       0..255, byte 2
P04      msgpack payloads              CRC-32, bytes 8 to 11       0..65535, bytes 2 and 3
=======  ============================  ==========================  =========================

The counter is part of the layout (the signals ``counter`` and ``seq``), hence never incremented here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

from e2e.p04 import e2e_p04_check, e2e_p04_protect
from e2e.p05 import e2e_p05_check, e2e_p05_protect
from e2e.p11 import e2e_p11_check, e2e_p11_protect

COUNTER_MODULUS: Final = 15
"""The counter of profile 11 runs from 0 to 14; 15 is not a counter."""

P04_HEADER: Final = 12
P04_COUNTER: Final = slice(2, 4)  # most significant byte first
P04_LIMIT: Final = 4096
"""Profile 4 is specified for messages of at most 4 kB [AUTOSAR E2E]."""


@dataclass(frozen=True, slots=True)
class Profile:
    """How to check and how to protect; the counter already stands in the data."""

    check: Callable[[bytes, int], bool]
    protect: Callable[[bytearray, int], None]


def _check_p11(data: bytes, data_id: int) -> bool:
    return e2e_p11_check(bytearray(data), data_id)  # the library wants mutable data even to check it


def _check_p04(data: bytes, data_id: int) -> bool:
    return len(data) >= P04_HEADER and e2e_p04_check(bytearray(data), data_id)


P04: Final = Profile(_check_p04, partial(e2e_p04_protect, increment_counter=False))
CAN_PROFILES: Final = {
    "P05": Profile(e2e_p05_check, partial(e2e_p05_protect, increment_counter=False)),
    "P11": Profile(_check_p11, partial(e2e_p11_protect, increment_counter=False)),
}
"""The profiles a frame of the DBC may name in its attribute ``E2EProfile``."""
