"""One CANopen device: object dictionary, SDO server, NMT state, heartbeat and EMCY, served from a loop."""

from collections.abc import Callable
from typing import Final

import canopen
from canopen.objectdictionary import ObjectDictionary

from vegrip.canopen.network import (
    EMCY,
    ENTER_PRE_OPERATIONAL,
    HEARTBEAT,
    INITIALISING,
    OPERATIONAL,
    PRE_OPERATIONAL,
    RESET_COMMUNICATION,
    RESET_NODE,
    SDO_ANSWER,
    SDO_REQUEST,
    START,
    STOP,
    STOPPED,
    LoopNetwork,
)

HEARTBEAT_LOST: Final = 0x8130
ID_TAKEN: Final = 0x8150
SOFTWARE: Final = 0x6100
NOT_ITS_EDS: Final = 0x6300
NO_ERROR: Final = 0x0000

GENERIC, COMMUNICATION = 0x01, 0x10  # bits of the error register, object 1001h
REGISTER: Final = {
    HEARTBEAT_LOST: GENERIC | COMMUNICATION,
    ID_TAKEN: GENERIC | COMMUNICATION,
    SOFTWARE: GENERIC,
    NOT_ITS_EDS: GENERIC | COMMUNICATION,
}

Send = Callable[[int, int, bytes], None]
"""Takes code, error register and the bytes of the manufacturer."""


class Emergencies:
    """What is wrong now; each beginning and the end of the last is reported once."""

    def __init__(self, send: Send) -> None:
        self.standing: dict[tuple[int, int], str] = {}
        """``(code, node-ID)`` -> what is wrong, in one sentence."""
        self._send = send

    @property
    def register(self) -> int:
        bits = 0
        for code, _ in self.standing:
            bits |= REGISTER[code]
        return bits

    def begin(self, code: int, node: int, sentence: str, lifecycle: int) -> bool:
        """Report that something is wrong with ``node``; return whether that is new."""
        if (code, node) in self.standing:
            return False
        self.standing[code, node] = sentence
        self._send(code, self.register, bytes([lifecycle, node, 0, 0, 0]))
        return True

    def end(self, code: int, node: int, lifecycle: int) -> None:
        if self.standing.pop((code, node), None) is not None:
            self._send(NO_ERROR, self.register, bytes([lifecycle, node, 0, 0, 0]))


LARGEST_WRITE = 256  # [bytes] by segmented SDO; the longest parameter is a path
ABORT_TOO_LONG = 0x06070010
FORGET_NODE_AFTER_S = 5.0  # [s] silence after which another node with our node-ID has gone
SDO_LENGTH = 8  # [bytes] of every SDO frame

Command = Callable[[int], None]


class Device:
    """A ``canopen.LocalNode`` in a :class:`LoopNetwork`."""

    def __init__(
        self, node: int, dictionary: ObjectDictionary, network: LoopNetwork, on_command: Command | None = None
    ) -> None:
        self.id = node
        self.local = canopen.LocalNode(node, dictionary)
        self.emergencies = Emergencies(self.local.emcy.send)
        self.foreign = 0  # frames of another node that bears our node-ID
        self._foreign_until = 0.0  # [s] when the last of them is forgotten
        self._on_command = on_command or self._obey  # called with each NMT command for this device
        network[node] = self.local
        network.unsubscribe(self.local.sdo.rx_cobid, self.local.sdo.on_request)
        network.unsubscribe(0, self.local.nmt.on_command)
        network.subscribe(SDO_REQUEST + node, self._on_sdo)
        network.subscribe(0, self._on_nmt)
        for service in (HEARTBEAT, SDO_ANSWER, EMCY):
            network.subscribe(service + node, self._on_foreign)
        self.local.add_read_callback(self._read)

    @property
    def state(self) -> int:
        return int(self.local.nmt._state)

    @property
    def is_operational(self) -> bool:
        return self.state == OPERATIONAL

    def boot(self) -> None:
        """Say that we are here: the boot-up message, then heartbeats."""
        self.local.nmt.stop_heartbeat()
        self.local.nmt.state = "INITIALISING"
        self.local.nmt.state = "PRE-OPERATIONAL"

    def set_state(self, state: int) -> None:
        if state != self.state:
            self.local.nmt._state = state
            self.local.nmt.update_heartbeat()

    def number(self, index: int, sub: int = 0) -> int:
        return int.from_bytes(self.local.get_data(index, sub), "little")

    def store(self, index: int, sub: int, data: bytes) -> None:
        self.local.data_store.setdefault(index, {})[sub] = data

    def _on_nmt(self, _: int, data: bytes, __: float) -> None:
        if len(data) == 2 and data[1] in (self.id, 0):
            self._on_command(data[0])

    def _obey(self, command: int) -> None:
        states = {START: OPERATIONAL, STOP: STOPPED, ENTER_PRE_OPERATIONAL: PRE_OPERATIONAL}
        if command in states:
            self.set_state(states[command])
        elif command in (RESET_NODE, RESET_COMMUNICATION):
            self.boot()

    def _on_sdo(self, can_id: int, data: bytes, stamp: float) -> None:
        if len(data) != SDO_LENGTH or self.state in (STOPPED, INITIALISING):
            return
        server = self.local.sdo
        server.on_request(can_id, data, stamp)
        if server._buffer is not None and len(server._buffer) > LARGEST_WRITE:
            server._buffer = None
            server.abort(ABORT_TOO_LONG)

    def serve(self, stamp: float) -> None:
        """Forget another node with our node-ID when it was silent for a while; ``stamp`` [s]."""
        if stamp > self._foreign_until:
            self.emergencies.end(ID_TAKEN, self.id, self.state)

    def _on_foreign(self, _: int, __: bytes, stamp: float) -> None:
        """Take in our own node-ID: a node does not receive its own frames, so another one has taken it."""
        self.foreign += 1
        self._foreign_until = stamp + FORGET_NODE_AFTER_S
        sentence = f"another node has the node-ID {self.id}; give one of them another"
        self.emergencies.begin(ID_TAKEN, self.id, sentence, self.state)

    def _read(self, index: int, subindex: int, od: object) -> int | None:  # noqa: ARG002 (called by name)
        return self.emergencies.register if index == 0x1001 else None
