"""What the bus needs of its surroundings: clock, connections, bytes; ``outside.c`` has the same for C.

Connections are descriptors of sequenced-packet sockets that do not block.
"""

import ctypes
import os
import select
import time
from typing import Any

from vegrip.clock import NS

Bytes = Any  # an array of c_uint8
Wholes = Any  # an array of c_int64


def nearest(value: float) -> int:
    """Return the nearest whole number; of two, the even one."""
    return round(value)


def copy_bytes(to: Bytes, place: int, source: Bytes, begin: int, size: int) -> None:
    """Copy ``size`` bytes; the two do not overlap."""
    ctypes.memmove(ctypes.byref(to, place), ctypes.byref(source, begin), size)


def store(to: Bytes, place: int, value: int, size: int) -> None:
    """Store a whole number in ``size`` bytes, the least significant first."""
    to[place : place + size] = (value & (1 << 8 * size) - 1).to_bytes(size, "little")


def load(source: Bytes, begin: int, size: int) -> int:
    """Return the whole number of up to seven bytes that :func:`store` has stored."""
    return int.from_bytes(source[begin : begin + size], "little")


def clock() -> int:
    """Return the time [ns]."""
    return time.monotonic_ns()


def sleep_until(end: int) -> bool:
    """Sleep; False: a signal has come."""
    time.sleep(max(end - clock(), 0) / NS)
    return True


def look(watched: Wholes, ready: Wholes, count: int, patience: int) -> bool:
    """Wait up to ``patience`` [ns] for descriptors to become readable; False: a signal has come."""
    wanted = watched[:count]
    found = select.select([fd for fd in wanted if fd >= 0], (), (), patience / NS)[0]
    ready[:count] = [fd in found for fd in wanted]
    return True


def receive(descriptor: int, to: Bytes, room: int) -> int:
    """Receive a packet and return its length; 0: the other side has gone; -1: there is none."""
    try:
        packet = os.read(descriptor, room)
    except (BlockingIOError, InterruptedError):
        return -1
    except OSError:
        return 0
    to[: len(packet)] = packet
    return len(packet)


def send(descriptor: int, source: Bytes, begin: int, size: int) -> bool:
    """Send a packet, though maybe to one that has gone; False: the other side does not read."""
    try:
        os.write(descriptor, bytes(source[begin : begin + size]))
    except (BlockingIOError, InterruptedError):
        return False
    except OSError:
        pass  # it has gone; reading from it will show that
    return True
