"""Frames between a python-can bus and the codec; the virtual bus has a short way of its own.

``can.Message`` is built for comfort: one for each of some thousand frames a second costs more than decoding
them. Every other interface goes through python-can's own interface.
"""

import math
import time
from collections import Counter
from collections.abc import Sequence
from typing import Final, Protocol

import can

from vegrip.transport.canbus import bus_records as wire
from vegrip.transport.canbus.bus_events import BusLoad, ErrorState
from vegrip.transport.canbus.frame_time import BitTiming, typical_duration
from vegrip.transport.canbus.hub_wire import MOST_REQUESTS, PLAIN_FLAGS, reported_state
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import EXTENDED
from vegrip.transport.stamps import StampMap


class CanPort(Protocol):
    """An open bus. Both directions raise ``can.CanError`` or ``OSError`` when it fails."""

    def receive(self, timeout: float) -> Frame | None:
        """Return the next data frame that is wanted, None when none comes in ``timeout`` [s]."""

    def send(self, frame: Frame) -> None:
        """Queue ``frame``."""

    def load(self) -> float:
        """Return the share of the last second for which the bus was busy, NaN if not known."""


def open_port(
    bus: can.BusABC, faults: Counter[str], timing: BitTiming | None, *, extended: bool = False
) -> CanPort:
    """Return the port of ``bus``, which counts in ``faults`` what the controller reports.

    Frames with 29-bit identifiers come through only if ``extended``; ours have 11 bits.
    """
    if isinstance(bus, VegripBus):
        return VirtualPort(bus, faults, extended=extended)
    return PythonCanPort(bus, faults, timing, extended=extended)


def error_name(classes: int, detail: bytes) -> str:
    """Return the name under which an error frame of SocketCAN is counted."""
    told = reported_state(classes, detail)
    if told is ErrorState.OFF:
        return "bus_off"
    if told is ErrorState.PASSIVE:
        return "error_passive"
    return "bus_restarted" if told is ErrorState.ACTIVE else "error_frame"


class VirtualPort:
    """The short way to the virtual bus of vegrip, which stamps on the monotonic clock."""

    def __init__(self, bus: VegripBus, faults: Counter[str], *, extended: bool = False) -> None:
        self._bus = bus
        self._extended = extended
        self._faults = faults
        self.offer_packet: Final = bus.offer_packet
        self.send_requests: Final = bus.put_requests

    def receive(self, timeout: float) -> Frame | None:
        """Return the next frame, or None."""
        deadline = time.monotonic() + timeout
        while (delivery := self._bus.take(deadline)) is not None:
            flags, identifier = delivery.flags, delivery.identifier
            if flags & wire.ERROR:
                self._faults[error_name(identifier, delivery.data)] += 1
            elif not flags & wire.REMOTE and (self._extended or not flags & wire.EXTENDED):
                identifier |= EXTENDED if flags & wire.EXTENDED else 0
                return Frame(identifier, delivery.data, bool(flags & wire.FD), delivery.end)
        return None

    def send(self, frame: Frame) -> None:
        """Queue ``frame``."""
        self._bus.put(_for_bus(frame))

    def send_several(self, frames: Sequence[Frame]) -> None:
        """Queue ``frames``, many in one packet."""
        for first in range(0, len(frames), MOST_REQUESTS):
            self._bus.put(*map(_for_bus, frames[first : first + MOST_REQUESTS]))

    def load(self) -> float:
        """Return the exact load."""
        return self._bus.load()


def _for_bus(frame: Frame) -> tuple[int, bytes, int]:
    """Return identifier, data and flags of ``frame`` as the virtual bus takes them."""
    flags = PLAIN_FLAGS if frame.fd else 0
    if frame.arbitration_id & EXTENDED:
        return frame.arbitration_id ^ EXTENDED, frame.data, flags | wire.EXTENDED
    return frame.arbitration_id, frame.data, flags


class PythonCanPort:
    """Any interface of python-can; the load is estimated from the frames seen here."""

    def __init__(
        self, bus: can.BusABC, faults: Counter[str], timing: BitTiming | None, *, extended: bool = False
    ) -> None:
        self._bus = bus
        self._extended = extended
        self._faults = faults
        self._timing = timing
        self._stamps = StampMap()
        self._load = BusLoad()

    def receive(self, timeout: float) -> Frame | None:
        """Return the next frame, or None; error frames are counted on the way."""
        deadline = time.monotonic() + timeout
        while True:
            remaining = max(deadline - time.monotonic(), 0.0)
            received = self._bus.recv(remaining)
            if received is None:
                return None
            if received.is_error_frame:
                self._faults[error_name(received.arbitration_id, bytes(received.data))] += 1
            elif not received.is_remote_frame and (self._extended or not received.is_extended_id):
                stamp = self._stamps.to_monotonic(received.timestamp)
                identifier = received.arbitration_id | (EXTENDED if received.is_extended_id else 0)
                frame = Frame(identifier, bytes(received.data), received.is_fd, stamp)
                self._measure(frame)
                return frame
            if remaining == 0.0:
                return None

    def send(self, frame: Frame) -> None:
        """Queue ``frame``."""
        self._bus.send(
            can.Message(
                arbitration_id=frame.arbitration_id & ~EXTENDED,
                is_extended_id=bool(frame.arbitration_id & EXTENDED),
                is_fd=frame.fd,
                bitrate_switch=frame.fd,
                data=frame.data,
            )
        )
        self._measure(frame)

    def load(self) -> float:
        """Return the load that the frames seen here make up."""
        return math.nan if self._timing is None else self._load.share(time.monotonic_ns())

    def _measure(self, frame: Frame) -> None:
        if self._timing is not None:
            duration = typical_duration(len(frame.data), frame.fd, self._timing)
            self._load.add(frame.stamp or time.monotonic_ns(), duration)
