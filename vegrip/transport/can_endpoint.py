"""A hand on a CAN bus: any interface of python-can below, the codec above."""

import contextlib
import math
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import can

from vegrip.codec import CanCodec, Frame
from vegrip.messages import Message
from vegrip.transport.bus_load import BusLoad
from vegrip.transport.frame_time import BitTiming, typical_duration
from vegrip.transport.losses import losses
from vegrip.transport.stamps import StampMap
from vegrip.transport.virtual_can import VegripBus

MOST_FRAMES = 256  # taken in one go; a babbling node must not keep the loop from its ticks
REOPEN_PERIOD = 1.0  # [s] between attempts to open a lost bus again
BUS_OFF = 0x40  # class of a SocketCAN error frame (linux/can/error.h)
CONTROLLER = 0x04
PASSIVE = 0x30  # data[1] of a CONTROLLER frame

Open = Callable[[], can.BusABC]


class CanEndpoint:
    """Frames in and out, decoded and encoded.

    After opening nothing raises. Besides the names of the codec ``rejected`` has ``unsent`` for frames the
    bus did not take; ``bus_lost``; ``bus_off``, ``error_passive`` and ``error_frame`` as the controller
    reports them; ``overrun`` for frames lost because this program did not read; ``lost`` and ``clipped``.
    """

    def __init__(
        self, bus: can.BusABC, codec: CanCodec, reopen: Open | None = None, timing: BitTiming | None = None
    ) -> None:
        self.arrivals: Sequence[int] = ()
        self._bus: can.BusABC | None = bus
        self._codec = codec
        self._reopen = reopen
        self._reopen_at = 0.0  # [s]
        self._timing = timing
        self._load = BusLoad()
        self._stamps = StampMap()
        self._faults: Counter[str] = Counter()

    @property
    def rejected(self) -> Mapping[str, int]:
        """What went wrong so far, by name."""
        overruns = self._bus.overruns if isinstance(self._bus, VegripBus) else 0
        overrun = {"overrun": overruns} if overruns else {}
        return {**self._codec.rejected, **self._faults, **losses(self._codec), **overrun}

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a message, then take what is there (``MOST_FRAMES`` at most)."""
        deadline = time.monotonic() + timeout
        messages: list[Message] = []
        arrivals: list[int] = []
        for _ in range(MOST_FRAMES):
            frame = self._next(0.0 if messages else max(deadline - time.monotonic(), 0.0))
            if frame is None:
                break
            message = self._codec.decode(frame)
            if message is not None:
                messages.append(message)
                arrivals.append(frame.stamp)
        self.arrivals = arrivals
        return messages

    def send(self, message: Message) -> None:
        """Queue the frames of ``message``; what the bus does not take at once is counted as unsent."""
        for frame in self._codec.encode(message):
            outgoing = can.Message(
                arbitration_id=frame.arbitration_id,
                is_extended_id=False,
                is_fd=frame.fd,
                bitrate_switch=frame.fd,
                data=frame.data,
            )
            if self._bus is None:
                self._faults["unsent"] += 1
                continue
            try:
                self._bus.send(outgoing)
            except (can.CanError, OSError):
                self._faults["unsent"] += 1
            else:
                self._measure(frame)

    def bus_load(self) -> float:
        """Return the load of the last second: exact on the virtual bus, else from the frames seen here."""
        if isinstance(self._bus, VegripBus):
            return self._bus.load()
        return math.nan if self._timing is None else self._load.share(time.monotonic_ns())

    def close(self) -> None:
        """Leave the bus."""
        self._reopen = None
        self._shut()

    def _next(self, timeout: float) -> Frame | None:
        """Return the next data frame, None when there is none within ``timeout`` [s]."""
        deadline = time.monotonic() + timeout
        while True:
            remaining = max(deadline - time.monotonic(), 0.0)
            received = self._received(remaining)
            if received is None:
                return None
            if received.is_error_frame:
                self._count_error(received)
            elif not (received.is_remote_frame or received.is_extended_id):
                stamp = self._stamps.to_monotonic(received.timestamp)
                frame = Frame(received.arbitration_id, bytes(received.data), received.is_fd, stamp)
                self._measure(frame)
                return frame
            if remaining == 0.0:
                return None

    def _received(self, timeout: float) -> can.Message | None:
        bus = self._bus or self._reopened()
        if bus is None:
            time.sleep(timeout)
            return None
        try:
            return bus.recv(timeout)
        except (can.CanError, OSError):
            self._faults["bus_lost"] += 1
            if self._reopen is not None:
                self._shut()
            else:
                time.sleep(timeout)
            return None

    def _reopened(self) -> can.BusABC | None:
        """Try to open a lost bus again, at most once per ``REOPEN_PERIOD``."""
        now = time.monotonic()
        if self._reopen is None or now < self._reopen_at:
            return None
        self._reopen_at = now + REOPEN_PERIOD
        try:
            self._bus = self._reopen()
        except (can.CanError, OSError):
            return None
        return self._bus

    def _shut(self) -> None:
        if self._bus is not None:
            with contextlib.suppress(can.CanError, OSError):
                self._bus.shutdown()
        self._bus = None

    def _count_error(self, frame: can.Message) -> None:
        if frame.arbitration_id & BUS_OFF:
            self._faults["bus_off"] += 1
        elif frame.arbitration_id & CONTROLLER and len(frame.data) > 1 and frame.data[1] & PASSIVE:
            self._faults["error_passive"] += 1
        else:
            self._faults["error_frame"] += 1

    def _measure(self, frame: Frame) -> None:
        if self._timing is not None:
            duration = typical_duration(len(frame.data), frame.fd, self._timing)
            self._load.add(frame.stamp or time.monotonic_ns(), duration)
