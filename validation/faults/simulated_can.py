"""A CAN bus on a simulated clock, in one process: every bit takes its time, and nothing waits.

The bus is :mod:`validation.faults.simulated_bus`. Messages go through the codec, frames through arbitration;
what a node receives has the stamp of the end of its frame.
"""

import heapq
import itertools
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence

from validation.faults import simulated_bus
from validation.faults.simulated_bus import SimulatedBus
from vegrip.clock import NS, Clock
from vegrip.messages import Message
from vegrip.transport.can_endpoint import InOrder
from vegrip.transport.canbus import bus_events
from vegrip.transport.canbus.frame_time import BitTiming, BusFrame
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.frame_codec import Line
from vegrip.transport.endpoint import FRAMES, Endpoint, Intercept, losses

Tamper = Callable[[Frame, int], Iterable[tuple[int, Frame]]]
"""What becomes of a frame sent at a time [ns]: any number of frames, each at its own time, not earlier."""

TRANSMIT_QUEUE = 64
"""Frames of one node that may wait for the bus; later ones are unsent."""


class SimulatedCan:
    """The bus; make an :meth:`endpoint` for each node, and let :meth:`advance` follow the clock."""

    def __init__(self, clock: Clock, timing: BitTiming | None = None) -> None:
        self.clock = clock
        self.model = SimulatedBus(timing or BitTiming())
        self.errors: Counter[str] = Counter()  # error frames, by kind
        self._load = bus_events.BusLoad()
        self._endpoints: dict[int, SimulatedEndpoint] = {}
        self._numbers = itertools.count(1)
        self._order = itertools.count()
        self._later: list[tuple[int, int, int, BusFrame]] = []  # heap of time [ns], order, node, frame

    def endpoint(
        self,
        codec: CanCodec,
        *,
        listen_only: bool = False,
        faults: bus_events.NodeFaults = bus_events.NO_FAULTS,
        order_window: float = 0.0,
    ) -> "SimulatedEndpoint":
        """Return a new node on the bus; the arguments are those of the real one."""
        self.advance()
        node = next(self._numbers)
        self.model.attach(node, listen_only=listen_only, faults=faults, time=self.clock.now())
        self._endpoints[node] = SimulatedEndpoint(self, node, codec, order_window)
        return self._endpoints[node]

    def advance(self) -> None:
        """Bring the bus up to the present of the clock, and every finished frame to all nodes."""
        now = self.clock.now()
        while self._later and self._later[0][0] <= now:
            time, _, node, frame = heapq.heappop(self._later)
            self._settle(time - 1)  # who asks at the same instant competes
            if node in self._endpoints:
                self._request(time, node, frame)
        self._settle(now)

    def next_event(self) -> int | None:
        """Return when :meth:`advance` will have something to do [ns]; None: not before a node sends."""
        event = self.model.next_event()
        if not self._later:
            return event
        return self._later[0][0] if event is None else min(event, self._later[0][0])

    def send(self, time: int, node: int, frame: Frame) -> None:
        """Let ``node`` send ``frame`` at ``time`` [ns], now or later."""
        sent = BusFrame(frame.arbitration_id, frame.data, fd=frame.fd, has_bit_rate_switch=frame.fd)
        if time > self.clock.now():
            heapq.heappush(self._later, (time, next(self._order), node, sent))
        else:
            self._settle(time - 1)
            self._request(time, node, sent)

    def load(self) -> float:
        """Return the share of the last second for which the bus was busy."""
        return self._load.share(self.clock.now())

    def leave(self, node: int) -> None:
        if self._endpoints.pop(node, None) is not None:
            self.model.detach(node)

    def _request(self, time: int, node: int, frame: BusFrame) -> None:
        is_full = self.model.waiting(node) >= TRANSMIT_QUEUE
        if is_full or not self.model.request(time, node, frame):
            self._endpoints[node].faults["unsent"] += 1

    def _settle(self, now: int) -> None:
        for event in self.model.advance(now):
            self._tell(event)

    def _tell(self, event: simulated_bus.Event) -> None:
        if isinstance(event, simulated_bus.StateChange):
            if event.node in self._endpoints:
                self._endpoints[event.node].learn(event)
            return
        self._load.carried(event.end, self.model.busy)
        if isinstance(event, simulated_bus.BusError):
            self.errors[event.kind.value] += 1
            for endpoint in self._endpoints.values():
                endpoint.faults["error_frame"] += 1
        elif not event.is_lost:
            self._deliver(event)

    def _deliver(self, sent: simulated_bus.Transmission) -> None:
        frame = Frame(sent.frame.identifier, sent.frame.data, sent.frame.fd, sent.end)
        for node, endpoint in self._endpoints.items():
            if node not in (sent.node, sent.missed_by):
                endpoint.hear(frame)


class SimulatedEndpoint(Endpoint):
    """One node's place on a :class:`SimulatedCan`; an :class:`~vegrip.transport.endpoint.Endpoint`.

    ``tamper`` may be set to falsify what this node sends.
    """

    brings = FRAMES

    def __init__(self, bus: SimulatedCan, node: int, codec: CanCodec, order_window: float = 0.0) -> None:
        self.arrivals: Sequence[int] = ()
        self.intercept: Intercept | None = None
        """Looks at every frame first."""
        self.faults: Counter[str] = Counter()
        self.heard = 0  # frames
        self.tamper: Tamper | None = None
        self._bus, self._node, self._codec = bus, node, codec
        self.broken = codec.broken
        self._inbox: deque[Frame] = deque()
        self._order = InOrder(round(order_window * NS)) if order_window > 0.0 else None

    @property
    def has_waiting(self) -> bool:
        return bool(self._inbox)

    @property
    def state(self) -> bus_events.ErrorState:
        return self._bus.model.state(self._node)

    @property
    def rejected(self) -> Mapping[str, int]:
        ordered = self._order.faults if self._order is not None else {}
        return {**self._codec.rejected, **self.faults, **losses(self._codec), **ordered}

    def receive(self, timeout: float) -> Sequence[Message]:
        """Take what is there; with nothing there, let the clock run up to ``timeout`` [s] until there is."""
        clock = self._bus.clock
        deadline = clock.now() + round(timeout * NS)
        self._bus.advance()
        while not self._inbox and clock.now() < deadline:
            event = self._bus.next_event()
            clock.sleep_until(deadline if event is None else min(event, deadline))
            self._bus.advance()
        return self._decoded()

    def send(self, message: Message) -> None:
        """Ask for the bus with the frames of ``message``; what the queue does not take is unsent."""
        now = self._bus.clock.now()
        for frame in self._codec.encode(message):
            self.put(frame, now)

    def line(self, finger: str) -> Line | None:
        return None if self._order is not None else self._codec.line(finger)

    def send_frame(self, frame: Frame) -> None:
        self.put(frame, self._bus.clock.now())

    def send_frames(self, frames: Sequence[Frame]) -> None:
        for frame in frames:
            self.send_frame(frame)

    def put(self, frame: Frame, now: int) -> None:
        """Send ``frame`` at ``now`` [ns], past the codec."""
        for time, sent in self.tamper(frame, now) if self.tamper else ((now, frame),):
            self._bus.send(time, self._node, sent)

    def endure(self, faults: bus_events.NodeFaults) -> None:
        self._bus.advance()
        self._bus.model.endure(self._node, faults, self._bus.clock.now())

    def hear(self, frame: Frame) -> None:
        self.heard += 1
        self._inbox.append(frame)

    def learn(self, change: simulated_bus.StateChange) -> None:
        """Count a change of the error state."""
        name = {bus_events.ErrorState.OFF: "bus_off", bus_events.ErrorState.PASSIVE: "error_passive"}
        self.faults[name.get(change.state, "bus_restarted")] += 1
        self.faults["unsent"] += change.dropped

    def bus_load(self) -> float:
        return self._bus.load()

    def close(self) -> None:
        self._bus.leave(self._node)

    def _decoded(self) -> list[Message]:
        messages: list[Message] = []
        arrivals: list[int] = []
        while self._inbox:
            frame = self._inbox.popleft()
            if self.intercept is not None and self.intercept(frame):
                continue
            message = self._codec.decode(frame)
            if message is not None:
                messages.append(message)
                arrivals.append(frame.stamp)
                if self.intercept is not None:
                    break  # it is answered before the next frame is looked at
        if self._order is not None:
            messages, arrivals = self._order.restore(messages, arrivals, self._bus.clock.now())
        self.arrivals = arrivals
        return messages
