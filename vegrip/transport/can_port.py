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

from vegrip.transport.canbus.bus_events import ErrorState
from vegrip.transport.canbus.bus_load import BusLoad
from vegrip.transport.canbus.error_report import reported_state
from vegrip.transport.canbus.frame_time import BitTiming, typical_duration
from vegrip.transport.canbus.hub_wire import MOST_REQUESTS
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import EXTENDED
from vegrip.transport.stamps import StampMap

FIRST_EXTENDED = 1 << 11
"""Identifiers from here on do not fit into 11 bits."""


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
        while True:
            delivery = self._bus.take_plain(deadline)
            if delivery is None or isinstance(delivery, Frame):
                return delivery
            frame = delivery.frame
            if delivery.is_error:
                self._faults[error_name(frame.identifier, frame.data)] += 1
            elif not frame.is_remote and (self._extended or not frame.extended):
                identifier = frame.identifier | EXTENDED if frame.extended else frame.identifier
                return Frame(identifier, frame.data, frame.fd, delivery.end)

    def send(self, frame: Frame) -> None:
        """Queue ``frame``."""
        identifier = frame.arbitration_id
        if frame.fd and identifier < FIRST_EXTENDED:
            self._bus.put_plain(identifier, frame.data)
        elif identifier & EXTENDED:
            self._bus.put(identifier ^ EXTENDED, frame.data, fd=frame.fd, extended=True)
        else:
            self._bus.put(identifier, frame.data, fd=frame.fd)

    def send_several(self, frames: Sequence[Frame]) -> None:
        """Queue ``frames``: one packet for many, where they are CAN FD frames with 11 bits."""
        if all(frame.fd and frame.arbitration_id < FIRST_EXTENDED for frame in frames):
            for first in range(0, len(frames), MOST_REQUESTS):
                some = frames[first : first + MOST_REQUESTS]
                self._bus.put_several([(frame.arbitration_id, frame.data) for frame in some])
        else:
            for frame in frames:
                self.send(frame)

    def load(self) -> float:
        """Return the exact load."""
        return self._bus.load()


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
