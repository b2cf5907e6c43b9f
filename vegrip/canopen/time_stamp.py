"""The TIME object of CiA 301: milliseconds since midnight and days since 1984, sent by one node for all.

A resolution of a millisecond is coarse for contact, but enough to bring the logs of all devices of a bus
onto one time. States that must share an instant are asked for with SYNC.
"""

import struct
import time
from datetime import UTC, datetime
from typing import Final

from vegrip.canopen.network import LoopNetwork, PeriodicTask
from vegrip.clock import NS

TIME_COB_ID: Final = 0x100  # COB-ID
PRODUCED: Final = 1 << 30  # in object 1012h
CONSUMED: Final = 1 << 31

_EPOCH: Final = int(datetime(1984, 1, 1, tzinfo=UTC).timestamp())  # [s] since 1970
_DAY: Final = 86_400  # [s]
_TIME_OF_DAY: Final = struct.Struct("<IH")
_MILLISECOND: Final = NS // 1000


def pack_time(time_of_day: int) -> bytes:
    """Return the TIME of ``time_of_day`` [ns since 1970]."""
    days, rest = divmod(time_of_day - _EPOCH * NS, _DAY * NS)
    return _TIME_OF_DAY.pack(rest // _MILLISECOND, days)


def unpack_time(data: bytes) -> int | None:
    """Return the time of a TIME message [ns since 1970], None when it is none."""
    if len(data) != _TIME_OF_DAY.size:
        return None
    counted, days = (int(number) for number in _TIME_OF_DAY.unpack(data))
    milliseconds = counted & 0x0FFF_FFFF  # four bits are reserved
    if milliseconds >= _DAY * 1000:
        return None
    return (_EPOCH + days * _DAY) * NS + milliseconds * _MILLISECOND


class TimeProducer(PeriodicTask):
    """Sends the wall clock of this machine every ``period`` [s]."""

    def __init__(self, period: float, now: int, owner: LoopNetwork) -> None:
        super().__init__(TIME_COB_ID, b"", period, now, owner)

    def serve(self, now: int) -> None:
        if now >= self.due:
            self.update(pack_time(time.time_ns()))
        super().serve(now)
