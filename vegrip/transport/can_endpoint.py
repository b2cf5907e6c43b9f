"""An endpoint on a CAN bus: any interface of python-can below, the codec above."""

import contextlib
import math
import time
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import Protocol

import can

from vegrip.clock import NS
from vegrip.messages import FingertipState, Message
from vegrip.transport.can_port import CanPort, VirtualPort, open_port
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.canbus.virtual_can import LookAtPacket, VegripBus
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.frame import FrameBlock
from vegrip.transport.codec.frame_codec import Line
from vegrip.transport.endpoint import PACKETS, Endpoint, Intercept, Lossy, losses
from vegrip.transport.sender_clock import ClockEstimate, SenderClock

Arrived = tuple[Message, int]
"""A message and when it came [ns]."""

MOST_HELD = 32  # messages of a finger; a sender of wild numbers must not make it grow


class InOrder:
    """The order of the states of every finger, which wait ``window`` [ns] at most; other messages pass."""

    def __init__(self, window: int) -> None:
        self.window = window
        self.faults: Counter[str] = Counter()  # "late": came after the window; "reordered": put back in place
        self._next: dict[str, int] = {}  # by finger, the number that is expected
        self._stamp: dict[str, int] = {}  # [ns] by finger, of the last one passed on
        self._held: dict[str, list[tuple[FingertipState, int]]] = {}

    def restore(
        self, messages: Sequence[Message], arrivals: Sequence[int], now: int
    ) -> tuple[list[Message], list[int]]:
        """Return what may go on at ``now`` [ns], in order: of what has just come, and of what was waiting."""
        passed: list[Arrived] = []
        for message, arrival in zip(messages, arrivals, strict=True):
            if isinstance(message, FingertipState):
                self._take(message, arrival, passed)
            else:
                passed.append((message, arrival))
        for finger, held in self._held.items():
            while held and (now - held[0][1] >= self.window or len(held) > MOST_HELD):
                self._next[finger] = held[0][0].seq
                self._pass_on(finger, passed)
        return [message for message, _ in passed], [arrival for _, arrival in passed]

    def _take(self, state: FingertipState, arrival: int, passed: list[Arrived]) -> None:
        finger = state.finger
        if state.seq < self._next.get(finger, state.seq):
            self.faults["late"] += 1
            return
        held = self._held.setdefault(finger, [])
        if held and state.seq < held[-1][0].seq:
            self.faults["reordered"] += 1
        held.append((state, arrival))
        held.sort(key=lambda one: one[0].seq)
        self._next.setdefault(finger, state.seq)
        self._pass_on(finger, passed)

    def _pass_on(self, finger: str, passed: list[Arrived]) -> None:
        held = self._held[finger]
        while held and held[0][0].seq <= self._next[finger]:
            state, arrival = held.pop(0)
            after = held[0][0].stamp if held else state.stamp + 1
            before = self._stamp.get(state.finger, min(state.stamp, after) - 1)
            is_between = before < state.stamp < after  # else it is put between its neighbours
            stamp = state.stamp if is_between else max(before + 1, (before + after) // 2)
            self._stamp[finger], self._next[finger] = stamp, state.seq + 1
            passed.append((state if stamp == state.stamp else replace(state, stamp=stamp), arrival))


MOST_FRAMES = 256  # taken in one go; a babbling node must not keep the loop from its ticks
REOPEN_PERIOD = 1.0  # [s] between attempts to open a lost bus again
RETRY_PERIOD_S = 0.001  # between two attempts to send a frame that may wait

SOCKETCAN = "SocketcanBus"  # by name: its module is only there where SocketCAN is
Open = Callable[[], can.BusABC]


class Codec(Lossy, Protocol):
    """What an endpoint needs of a codec."""

    @property
    def rejected(self) -> Mapping[str, int]:
        """What was refused, by name."""

    @property
    def broken(self) -> Mapping[str, int]:
        """States that could not be understood, by finger."""

    def decode(self, frame: Frame) -> Message | None:
        """Return the message that ``frame`` completes."""

    def encode(self, message: Message) -> list[Frame]:
        """Return the frames of ``message``."""


class CanEndpoint(Endpoint):
    """Frames in and out, decoded and encoded.

    After opening nothing raises. Besides the names of the codec ``rejected`` has ``unsent`` for frames the
    bus did not take; ``bus_lost``; ``bus_off``, ``error_passive``, ``bus_restarted`` and ``error_frame`` as
    the controller reports them; ``overrun`` for frames lost because this program did not read;
    ``fd_refused`` for CAN FD frames on a bus opened for classic ones; ``lost`` and ``clipped``;
    with an ``order_window`` [s] ``reordered`` and ``late``, see :class:`InOrder`;
    with the ``clock`` of the hand ``clock_jump``.
    """

    brings = PACKETS

    def __init__(
        self,
        bus: can.BusABC,
        codec: Codec,
        reopen: Open | None = None,
        timing: BitTiming | None = None,
        order_window: float = 0.0,
        clock: SenderClock | None = None,
        *,
        extended: bool = False,
    ) -> None:
        self.arrivals: Sequence[int] = ()
        self.intercept: Intercept | None = None
        """Looks at every frame first."""
        self.intercept_packet: LookAtPacket | None = None
        """Looks at frames first that come together, where a bus brings them so."""
        self.patience_s = 0.0
        """For how long a frame waits for room in a full transmit queue; a control loop does not wait."""
        self._codec, self.broken = codec, codec.broken
        self._reopen = reopen
        self._reopen_at = 0.0  # [s]
        self._timing = timing
        self._order = InOrder(round(order_window * NS)) if order_window > 0.0 else None
        self._clock = clock
        self._faults: Counter[str] = Counter()
        self._extended = extended
        self._bus: can.BusABC | None = bus
        self._port: CanPort | None = open_port(bus, self._faults, timing, extended=extended)
        self._filters: list[can.typechecking.CanFilter] = []

    @property
    def rejected(self) -> Mapping[str, int]:
        seen = {}
        if isinstance(self._bus, VegripBus):
            seen = {"overrun": self._bus.overruns, "fd_refused": self._bus.fd_refused}
        ordered = self._order.faults if self._order is not None else {}
        jumps = {"clock_jump": self._clock.jumps} if self._clock is not None and self._clock.jumps else {}
        met = {name: count for name, count in seen.items() if count}
        return {**self._codec.rejected, **self._faults, **losses(self._codec), **met, **ordered, **jumps}

    @property
    def clock(self) -> ClockEstimate | None:
        return None if self._clock is None else self._clock.estimate()

    def select(self, kinds: Collection[type[Message]]) -> None:
        """Have the controller bring only messages of ``kinds`` to this hand, and what is not understood."""
        if isinstance(self._codec, CanCodec):
            self._filters = [
                {"can_id": identifier, "can_mask": mask, "extended": False}
                for identifier, mask in self._codec.filters(kinds)
            ]
            self._filter()

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a message, then take what is there (``MOST_FRAMES`` at most)."""
        if self.intercept_packet is not None and self._is_answered_at_once(timeout, self.intercept_packet):
            self.arrivals = ()
            return ()
        deadline = time.monotonic() + timeout
        messages: list[Message] = []
        arrivals: list[int] = []
        intercept, dealt = self.intercept, False
        for _ in range(MOST_FRAMES):
            frame = self.next_frame(0.0 if messages or dealt else max(deadline - time.monotonic(), 0.0))
            if frame is None:
                break
            if intercept is not None and intercept(frame):
                dealt = True
                continue
            message = self._codec.decode(frame)
            if message is not None:
                messages.append(message)
                arrivals.append(frame.stamp)
                if intercept is not None:
                    break  # it is answered before the next frame is looked at
        if self._order is not None:
            messages, arrivals = self._order.restore(messages, arrivals, time.monotonic_ns())
        self.arrivals = arrivals
        return messages

    def line(self, finger: str) -> Line | None:
        if not isinstance(self._codec, CanCodec) or self._order is not None or self._clock is not None:
            return None
        return self._codec.line(finger)

    def take_block(self) -> FrameBlock | None:
        """Return the frames that have come, at once; None: :meth:`next_frame` must bring them."""
        if self._port is None or not isinstance(self._bus, VegripBus):
            return None
        from vegrip.transport.delivered_frames import take_block  # noqa: PLC0415 (brings numba)

        return take_block(self._bus)

    def send(self, message: Message) -> None:
        for frame in self._codec.encode(message):
            self.send_frame(frame)

    def send_all(self, messages: Sequence[Message]) -> None:
        self.send_frames([frame for message in messages for frame in self._codec.encode(message)])

    def send_frames(self, frames: Sequence[Frame]) -> None:
        """Queue ``frames``, at once where the bus can."""
        if isinstance(self._port, VirtualPort) and self.patience_s == 0.0:
            try:
                self._port.send_several(frames)
            except (can.CanError, OSError):
                self._faults["unsent"] += len(frames)
        else:
            for frame in frames:
                self.send_frame(frame)

    def send_requests(self, requests: bytes | bytearray | memoryview, count: int) -> None:
        """Queue ``count`` frames packed as requests; counted as unsent when the bus does not take them."""
        try:
            if not isinstance(self._port, VirtualPort):
                raise OSError
            self._port.send_requests(requests)
        except (can.CanError, OSError):
            self._faults["unsent"] += count

    def _is_answered_at_once(self, timeout: float, look: LookAtPacket) -> bool:
        if not isinstance(self._port, VirtualPort):
            return False
        try:
            return self._port.offer_packet(timeout, look) is not False
        except (can.CanError, OSError):
            return False  # the next look at the bus finds out, and counts

    def send_frame(self, frame: Frame) -> None:
        """Queue one frame; counted as unsent when the bus does not take it at once."""
        if self._port is None:
            self._faults["unsent"] += 1
            return
        if not (_is_sent(frame, self._port) or self._is_sent_later(frame, self._port)):
            self._faults["unsent"] += 1

    def _is_sent_later(self, frame: Frame, port: CanPort) -> bool:
        until = time.monotonic() + self.patience_s
        while time.monotonic() < until:
            time.sleep(RETRY_PERIOD_S)
            if _is_sent(frame, port):
                return True
        return False

    def bus_load(self) -> float:
        """Return the load of the last second: exact on the virtual bus, else from the frames seen here."""
        return math.nan if self._port is None else self._port.load()

    def close(self) -> None:
        self._reopen = None
        self._shut()

    def next_frame(self, timeout: float) -> Frame | None:
        """Return the next data frame, None when there is none within ``timeout`` [s] or the bus is lost."""
        port = self._port or self._reopened()
        if port is None:
            time.sleep(timeout)
            return None
        try:
            return port.receive(timeout)
        except (can.CanError, OSError):
            self._faults["bus_lost"] += 1
            if self._reopen is not None:
                self._shut()
            else:
                time.sleep(timeout)
            return None

    def _reopened(self) -> CanPort | None:
        now = time.monotonic()
        if self._reopen is None or now < self._reopen_at:
            return None
        self._reopen_at = now + REOPEN_PERIOD
        try:
            self._bus = self._reopen()
        except (can.CanError, OSError):
            return None
        self._port = open_port(self._bus, self._faults, self._timing, extended=self._extended)
        self._filter()
        return self._port

    def _filter(self) -> None:
        """Set the filters where the bus itself has some; python-can's own would hide error frames."""
        if self._bus is None or not self._filters:
            return
        if isinstance(self._bus, VegripBus) or self._bus.__class__.__name__ == SOCKETCAN:
            with contextlib.suppress(can.CanError, OSError):  # then more comes in than is needed
                self._bus.set_filters(self._filters)

    def _shut(self) -> None:
        if self._bus is not None:
            with contextlib.suppress(can.CanError, OSError):
                self._bus.shutdown()
        self._bus = self._port = None


def _is_sent(frame: Frame, port: CanPort) -> bool:
    try:
        port.send(frame)
    except (can.CanError, OSError):
        return False
    return True
