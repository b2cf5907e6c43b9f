"""What both ends of a CANopen bus share: PDOs go through the codec, other frames to the services."""

import math
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import can

from vegrip.canopen.network import LAST_WORDS, TIME_COB_ID, LoopNetwork, unpack_time
from vegrip.clock import NS
from vegrip.messages import ContactEstimate, Message, make_row
from vegrip.transport.can_endpoint import CanEndpoint, Open
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.sender_clock import ClockEstimate, SenderClock


class CanopenCodec:
    """What :class:`~vegrip.transport.can_endpoint.CanEndpoint` needs of a codec.

    The ``end`` of the bus says by its COB-ID whether a PDO may be taken or sent now, takes all other frames,
    and keeps what is read by SDO: estimates have no PDO.
    """

    def __init__(self, codec: CanCodec, identifiers: Mapping[int, int], end: "CanopenEndpoint") -> None:
        self._codec, self._end = codec, end
        self.rejected, self.broken, self.clipped = codec.rejected, codec.broken, codec.clipped
        self._identifier = dict(identifiers)
        self._cob_id = {identifier: cob_id for cob_id, identifier in identifiers.items()}

    @property
    def lost(self) -> int:
        return self._codec.lost

    def decode(self, frame: Frame) -> Message | None:
        """Return the message that a PDO completes; hand any other frame to the services."""
        cob_id = frame.arbitration_id
        identifier = self._identifier.get(cob_id)
        if identifier is None:
            self._end.service(frame)
            return None
        return self._codec.decode(frame, identifier) if self._end.accepts(cob_id) else None

    def encode(self, message: Message) -> list[Frame]:
        """Return the PDOs of ``message`` that may be sent; messages without a PDO have none."""
        frames = [] if isinstance(message, ContactEstimate) else self._codec.encode(message)
        self._end.keep(message, frames)
        sent: list[Frame] = []
        for identifier, *rest in frames:
            cob_id = self._cob_id.get(identifier)
            if cob_id is not None and self._end.speaks(cob_id):
                sent.append(make_row(Frame, (cob_id, *rest)))
        return sent


class CanopenEndpoint(Endpoint):
    """An endpoint that only listens; the ends of a hand build on it.

    Besides the names of :class:`~vegrip.transport.can_endpoint.CanEndpoint` ``rejected`` has ``malformed``
    for frames that a service could not read, and what the ends count.
    """

    def __init__(
        self,
        bus: can.BusABC,
        codec: CanCodec,
        identifiers: Mapping[int, int],
        reopen: Open | None = None,
        timing: BitTiming | None = None,
    ) -> None:
        self.arrivals: Sequence[int] = ()
        self.faults: Counter[str] = Counter()
        self.now: Callable[[], int] = time.monotonic_ns
        self.network = LoopNetwork(self.put, self.now)
        self.pdos = CanopenCodec(codec, identifiers, self)
        self.can = CanEndpoint(bus, self.pdos, reopen, timing)
        self.broken = codec.broken
        self._clock = SenderClock()
        self.network.subscribe(TIME_COB_ID, self._on_time)

    @property
    def rejected(self) -> Mapping[str, int]:
        malformed = {"malformed": self.network.malformed} if self.network.malformed else {}
        jumps = {"clock_jump": self._clock.jumps} if self._clock.jumps else {}
        return {**self.can.rejected, **self.faults, **malformed, **jumps}

    @property
    def clock(self) -> ClockEstimate | None:
        """The clock of the producer of TIME, in ns since 1970, against ours; None before the first."""
        known = self._clock.estimate()
        return None if math.isnan(known.offset) else known

    def _on_time(self, _: int, data: bytearray, stamp: float) -> None:
        sender_time = unpack_time(bytes(data))
        if sender_time is None:
            self.network.malformed += 1
        else:
            self._clock.observe(sender_time, round(stamp * NS))

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a message; meanwhile serve what is due."""
        end = self.now() + round(timeout * NS)
        while True:
            now = self.now()
            self.serve(now)
            wait = max(min(end, self.due) - now, 0) / NS
            messages = self.can.receive(wait)
            if messages or self.now() >= end:
                self.arrivals = self.can.arrivals
                return messages

    def send(self, message: Message) -> None:
        self.can.send(message)

    def put(self, cob_id: int, data: bytes) -> None:
        self.can.send_frame(Frame(cob_id, data))

    def bus_load(self) -> float:
        return self.can.bus_load()

    def close(self) -> None:
        time.sleep(LAST_WORDS)
        self.can.close()

    @property
    def due(self) -> int:
        """When :meth:`serve` must be called next [ns]."""
        return self.network.due

    def serve(self, now: int) -> None:
        self.network.serve(now)

    def service(self, frame: Frame) -> None:
        self.network.receive(frame.arbitration_id, frame.data, frame.stamp)

    def accepts(self, cob_id: int) -> bool:  # noqa: ARG002 (for those who build on this)
        return True

    def speaks(self, cob_id: int) -> bool:  # noqa: ARG002
        return False

    def keep(self, message: Message, frames: list[Frame]) -> None:
        """Keep what is sent, to be read by SDO."""
