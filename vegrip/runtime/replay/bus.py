"""A CAN bus with a recording at its far end, in simulated time: real frames, and nothing waits."""

from collections.abc import Callable, Iterable, Mapping, Sequence

from vegrip.clock import NS, SimulatedClock
from vegrip.messages import FingertipState, Message
from vegrip.transport.canbus.bus_load import BusLoad
from vegrip.transport.canbus.frame_time import BitTiming, typical_duration
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.endpoint import ClosedByWith

Keep = Callable[[Message], None]


class RecordedBus(ClosedByWith):
    """An endpoint that receives a recording and keeps what the node sends.

    Every state is encoded, carried and decoded as on a real bus, so that the node sees what the wire leaves
    of it. What the node sends is encoded too, to count what the wire cannot carry; :attr:`keep` gets it as
    the node said it.

    Args:
        states: in the order of their stamps.
        fingers: in the order of the bus.
        clock: moved from state to state.
        keep: gets every state as received, and every message sent.
        fd: CAN FD, else classic CAN.

    """

    def __init__(
        self,
        states: Iterable[FingertipState],
        fingers: Sequence[str],
        clock: SimulatedClock,
        keep: Keep,
        *,
        fd: bool = True,
    ) -> None:
        self.arrivals: Sequence[int] = ()
        self._states = iter(states)
        self._next = next(self._states, None)
        self._clock = clock
        self._keep = keep
        self._hand, self._node = CanCodec(fingers, fd=fd), CanCodec(fingers, fd=fd)
        self._timing = BitTiming()
        self._load = BusLoad()
        self.busy = 0  # [ns] for which the bus was busy

    @property
    def finished(self) -> bool:
        return self._next is None

    @property
    def rejected(self) -> Mapping[str, int]:
        clipped = self._hand.clipped + self._node.clipped
        return {**self._node.rejected, **{f"clipped {name}": n for name, n in clipped.items()}}

    def receive(self, timeout: float) -> Sequence[Message]:
        """Move the clock to the next state, at most by ``timeout`` [s]; return what that state became."""
        deadline = self._clock.now() + round(timeout * NS)
        if self._next is None or self._next.stamp > deadline:
            self._clock.sleep_until(deadline)
            return self._arrived([])
        state, self._next = self._next, next(self._states, None)
        self._clock.sleep_until(state.stamp)
        return self._arrived(self._carried(state))

    def send(self, message: Message) -> None:
        for frame in self._node.encode(message):
            self._occupy(frame)
        self._keep(message)

    def bus_load(self) -> float:
        """Return the load of the last simulated second, as on a bus of 1 and 5 Mbit/s."""
        return self._load.share(self._clock.now())

    def close(self) -> None:
        """Nothing to release."""

    def _carried(self, state: FingertipState) -> list[Message]:
        now = self._clock.now()
        decoded = []
        for frame in self._hand.encode(state):
            self._occupy(frame)
            decoded.append(self._node.decode(frame._replace(stamp=now)))
        return [message for message in decoded if message is not None]

    def _arrived(self, messages: list[Message]) -> list[Message]:
        self.arrivals = [self._clock.now()] * len(messages)
        for message in messages:
            self._keep(message)
        return messages

    def _occupy(self, frame: Frame) -> None:
        duration = typical_duration(len(frame.data), frame.fd, self._timing)
        self.busy += duration
        self._load.add(self._clock.now(), duration)
