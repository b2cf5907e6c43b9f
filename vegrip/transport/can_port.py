"""Frames between a python-can bus and the codec; the virtual bus has a short way of its own.

``can.Message`` is built for comfort: one for each of some thousand frames a second costs more than decoding
them. Every other interface goes through python-can's own interface.

Whether a SocketCAN interface can carry what is asked of it is asked of the kernel before the bus is opened.
The kernel lets a socket be bound to an interface that is down or too small for CAN FD, and complains only
when the first frame is read or sent; a node should say so when it starts. One that is missing is found here
too, because python-can leaves a socket open when it finds none.
"""

import errno
import fcntl
import json
import math
import os
import shutil
import socket
import struct
import subprocess
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Final, Protocol

import can

from vegrip.transport.canbus import bus_records as wire
from vegrip.transport.canbus.bus_events import BusLoad, ErrorState
from vegrip.transport.canbus.frame_time import BitTiming, typical_duration
from vegrip.transport.canbus.hub_wire import MOST_REQUESTS, PLAIN_FLAGS, reported_state
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import EXTENDED
from vegrip.transport.sender_clock import StampMap

IP_TIMEOUT_S = 5.0  # [s]
Ask = Callable[[str], str]


def check_rates(channel: str, bitrate: int, data_bitrate: int, *, fd: bool, ask: Ask | None = None) -> None:
    """Refuse an interface that is set to other bit rates; one without (vcan, or no ``ip`` here) passes."""
    nominal, fast = rates((ask or _ip)(channel))
    wrong = nominal not in (0, bitrate)
    wrong_data = fd and fast not in (0, data_bitrate)
    if wrong or wrong_data:
        data = f" dbitrate {data_bitrate} fd on" if fd else ""
        actual = f"{nominal} and {fast}" if fd else f"{nominal}"
        asked = f"{bitrate} and {data_bitrate}" if fd else f"{bitrate}"
        raise can.CanInitializationError(
            f"it is set to {actual} bit/s, not {asked}; set transport.bitrate"
            + (" and transport.data_bitrate" if fd else "")
            + f" to what the bus has, or `sudo ip link set {channel} down; sudo ip link set {channel} "
            f"type can bitrate {bitrate}{data}; sudo ip link set {channel} up`"
        )


def rates(said: str) -> tuple[int, int]:
    """Return nominal and data bit rate [bit/s] in what ``ip -details -json link show`` said; 0: none."""
    try:
        data = json.loads(said)[0]["linkinfo"]["info_data"]
        nominal, fast = (int(data.get(k, {}).get("bitrate", 0)) for k in ("bittiming", "data_bittiming"))
    except (ValueError, LookupError, TypeError, AttributeError):
        return 0, 0
    return nominal, fast


def _ip(channel: str) -> str:
    program = shutil.which("ip")
    if program is None:
        return ""
    command = [program, "-details", "-json", "link", "show", "dev", channel]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=IP_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return ""
    return done.stdout


GET_FLAGS, GET_MTU = 0x8913, 0x8921  # SIOCGIFFLAGS, SIOCGIFMTU of linux/sockios.h
UP = 1  # IFF_UP
FD_MTU = 72  # [bytes] of struct canfd_frame; an interface for classic frames has 16


def check_link(channel: str, *, fd: bool) -> None:
    """Refuse an interface that is missing, down, or carries classic frames only though ``fd`` is asked.

    Raises:
        OSError: EAFNOSUPPORT, ENODEV or ENETDOWN, as the kernel says or would say later.
        can.CanInitializationError: no room for CAN FD frames.

    """
    if not _ask(channel, GET_FLAGS, "h") & UP:
        raise OSError(errno.ENETDOWN, os.strerror(errno.ENETDOWN))
    if fd and _ask(channel, GET_MTU, "i") < FD_MTU:
        raise can.CanInitializationError(
            "it carries classic frames only; set fd = false, or make it CAN FD: "
            f"`sudo ip link set {channel} type can ... dbitrate 5000000 fd on` "
            f"(a virtual one: `sudo ip link set {channel} mtu {FD_MTU}`)"
        )


def _ask(channel: str, what: int, kind: str) -> int:
    request = struct.pack("=16s16x", channel.encode()[:15])  # struct ifreq begins with the name
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as unbound:
        answer = fcntl.ioctl(unbound, what, request)
    return int(struct.unpack_from(f"={kind}", answer, 16)[0])


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
    actual = reported_state(classes, detail)
    if actual is ErrorState.OFF:
        return "bus_off"
    if actual is ErrorState.PASSIVE:
        return "error_passive"
    return "bus_restarted" if actual is ErrorState.ACTIVE else "error_frame"


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
        self._bus.put(_for_bus(frame))

    def send_several(self, frames: Sequence[Frame]) -> None:
        for first in range(0, len(frames), MOST_REQUESTS):
            self._bus.put(*map(_for_bus, frames[first : first + MOST_REQUESTS]))

    def load(self) -> float:
        return self._bus.load()


def _for_bus(frame: Frame) -> tuple[int, bytes, int]:
    flags = PLAIN_FLAGS if frame.fd else 0
    if frame.arbitration_id & EXTENDED:
        return frame.arbitration_id ^ EXTENDED, frame.data, flags | wire.EXTENDED
    return frame.arbitration_id, frame.data, flags


def message_of(frame: Frame) -> can.Message:
    return can.Message(
        arbitration_id=frame.arbitration_id & ~EXTENDED,
        is_extended_id=bool(frame.arbitration_id & EXTENDED),
        is_fd=frame.fd,
        bitrate_switch=frame.fd,
        data=frame.data,
    )


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
        self._bus.send(message_of(frame))
        self._measure(frame)

    def load(self) -> float:
        return math.nan if self._timing is None else self._load.share(time.monotonic_ns())

    def _measure(self, frame: Frame) -> None:
        if self._timing is not None:
            duration = typical_duration(len(frame.data), frame.fd, self._timing)
            self._load.add(frame.stamp or time.monotonic_ns(), duration)
