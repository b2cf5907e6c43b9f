"""The fingers of a hand as CANopen nodes: whether they are there, right, and go on beating."""

from collections.abc import Callable, Sequence

from canopen.objectdictionary import ObjectDictionary

from vegrip.canopen.connection_set import HEARTBEAT, NMT, SDO_ANSWER, SDO_REQUEST
from vegrip.canopen.eds import essentials, wanted_value
from vegrip.canopen.heartbeat import HeartbeatConsumer
from vegrip.canopen.nmt import INITIALISING, OPERATIONAL, START
from vegrip.canopen.sdo_reader import SdoReader

Send = Callable[[int, bytes], None]
RESTART_PERIOD_NS = 1_000_000_000  # [ns] between two commands to start


class Sensor:
    """One finger: read and compared whenever it boots, then started."""

    def __init__(self, node: int, dictionary: ObjectDictionary, send: Send, *, is_master: bool) -> None:
        self.node = node
        self.difference = ""  # from its EDS, in words
        self._dictionary = dictionary
        self._send = send
        self._is_master = is_master
        self._told: int | None = None  # [ns] when it was last told to start
        self._reader: SdoReader | None = None
        self._is_verified = False

    @property
    def is_verified(self) -> bool:
        return self._is_verified

    def begin(self) -> None:
        """Read it anew."""
        self.difference, self._is_verified, self._told = "", False, None
        asked = essentials(self._dictionary)
        self._reader = SdoReader(asked, lambda data: self._send(SDO_REQUEST + self.node, data))

    def answer(self, data: bytes, now: int) -> None:
        if self._reader is not None:
            self._reader.answer(data, now)

    def serve(self, state: int | None, now: int) -> None:
        """Go on reading; start it when it is what it should be."""
        if self._reader is not None:
            self._reader.serve(now)
            if self._reader.is_done:
                self._compare(self._reader)
        if self._is_verified and self._is_master and state not in (None, OPERATIONAL):
            self._start(now)

    def _compare(self, reader: SdoReader) -> None:
        self._reader = None
        if reader.failed:
            self.begin()  # silent: the heartbeat consumer says so; ask on
            return
        for (index, sub), value in reader.values.items():
            wanted = wanted_value(self._dictionary, index, sub)
            if value != wanted:
                has = "does not exist" if value is None else f"is {value:#x}"
                self.difference = f"object {index:04X}sub{sub} {has}, its EDS says {wanted:#x}"
                return
        self._is_verified = True

    def _start(self, now: int) -> None:
        if self._told is None or now - self._told >= RESTART_PERIOD_NS:
            self._told = now
            self._send(NMT, bytes([START, self.node]))


class Sensors:
    """All fingers of a hand.

    Args:
        nodes: node-IDs of the fingers, in their order.
        dictionary: what their EDS says.
        limit: [ns] longest time between two heartbeats.
        first: [ns] that a finger may take to appear.
        send: puts a frame on the bus.
        now: [ns]
        master: whether fingers are told to start.

    """

    def __init__(
        self,
        nodes: Sequence[int],
        dictionary: ObjectDictionary,
        limit: int,
        first: int,
        send: Send,
        now: int,
        *,
        is_master: bool,
    ) -> None:
        self.consumer = HeartbeatConsumer(dict.fromkeys(nodes, limit), now, first)
        self.all = {node: Sensor(node, dictionary, send, is_master=is_master) for node in nodes}
        for sensor in self.all.values():
            sensor.begin()

    def hear(self, can_id: int, data: bytes, now: int) -> None:
        """Take a heartbeat or an SDO answer."""
        service, node = can_id & 0x780, can_id & 0x7F
        sensor = self.all.get(node)
        if sensor is None or not data:
            return
        if service == SDO_ANSWER:
            sensor.answer(data, now)
        elif service == HEARTBEAT:
            state = data[0] & 0x7F
            if self.consumer.take_heartbeat(node, state, now) or state == INITIALISING:
                sensor.begin()

    def serve(self, now: int) -> list[int]:
        """Go on with what is under way; return the nodes that have become missing."""
        for node, sensor in self.all.items():
            sensor.serve(self.consumer.state(node), now)
        return self.consumer.newly_missing(now)

    @property
    def is_ready(self) -> bool:
        return all(
            sensor.is_verified and self.consumer.state(node) == OPERATIONAL
            for node, sensor in self.all.items()
        )
