"""Frames between a python-can bus and the codec; the virtual bus has a short way of its own.

``can.Message`` is built for comfort: one for each of some thousand frames a second costs more than decoding
them. Every other interface goes through python-can's own interface.
"""

import math
import time
from collections import Counter
from typing import Protocol

import can

from vegrip.transport.canbus.bus_load import BusLoad
from vegrip.transport.canbus.error_report import told_state
from vegrip.transport.canbus.fault_confinement import ErrorState
from vegrip.transport.canbus.frame_time import BitTiming, typical_duration
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.transport.codec import Frame
from vegrip.transport.stamps import StampMap


class CanPort(Protocol):
    """An open bus. Both directions raise ``can.CanError`` or ``OSError`` when it fails."""

    def receive(self, timeout: float) -> Frame | None:
        """Return the next data frame with an 11-bit identifier, None when none comes in ``timeout`` [s]."""

    def send(self, frame: Frame) -> None:
        """Queue ``frame``."""

    def load(self) -> float:
        """Return the share of the last second for which the bus was busy, NaN if not known."""


def open_port(bus: can.BusABC, faults: Counter[str], timing: BitTiming | None) -> CanPort:
    """Return the port of ``bus``, which counts in ``faults`` what the controller reports."""
    if isinstance(bus, VegripBus):
        return VirtualPort(bus, faults)
    return PythonCanPort(bus, faults, timing)


def error_name(classes: int, detail: bytes) -> str:
    """Return the name under which an error frame of SocketCAN is counted."""
    told = told_state(classes, detail)
    if told is ErrorState.OFF:
        return "bus_off"
    if told is ErrorState.PASSIVE:
        return "error_passive"
    return "bus_restarted" if told is ErrorState.ACTIVE else "error_frame"


class VirtualPort:
    """The short way to the virtual bus of vegrip, which stamps on the monotonic clock."""

    def __init__(self, bus: VegripBus, faults: Counter[str]) -> None:
        self._bus = bus
        self._faults = faults

    def receive(self, timeout: float) -> Frame | None:
        """Return the next frame, or None."""
        deadline = time.monotonic() + timeout
        while True:
            delivery = self._bus.take(deadline)
            if delivery is None:
                return None
            frame = delivery.frame
            if delivery.error:
                self._faults[error_name(frame.identifier, frame.data)] += 1
            elif not (frame.remote or frame.extended):
                return Frame(frame.identifier, frame.data, frame.fd, delivery.end)

    def send(self, frame: Frame) -> None:
        """Queue ``frame``."""
        self._bus.put(frame.arbitration_id, frame.data, fd=frame.fd)

    def load(self) -> float:
        """Return the exact load."""
        return self._bus.load()


class PythonCanPort:
    """Any interface of python-can; the load is estimated from the frames seen here."""

    def __init__(self, bus: can.BusABC, faults: Counter[str], timing: BitTiming | None) -> None:
        self._bus = bus
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
            elif not (received.is_remote_frame or received.is_extended_id):
                stamp = self._stamps.to_monotonic(received.timestamp)
                frame = Frame(received.arbitration_id, bytes(received.data), received.is_fd, stamp)
                self._measure(frame)
                return frame
            if remaining == 0.0:
                return None

    def send(self, frame: Frame) -> None:
        """Queue ``frame``."""
        self._bus.send(
            can.Message(
                arbitration_id=frame.arbitration_id,
                is_extended_id=False,
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
