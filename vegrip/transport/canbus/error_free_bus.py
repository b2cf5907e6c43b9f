"""A bus without errors in flat memory, for the kernels: loaded from model and members, and stored back."""

import ctypes
from array import array
from collections.abc import Iterator, Sequence
from typing import Protocol

from vegrip.transport.canbus.acceptance import Acceptance
from vegrip.transport.canbus.bus_model import BusModel, ErrorFreeState
from vegrip.transport.canbus.frame_time import FD_SIZES, BusFrame
from vegrip.transport.canbus.hub_wire import pack_request, unpack_request
from vegrip.transport.canbus.kernels import memory as at
from vegrip.transport.canbus.kernels.limits import NO_EVENT

REMOTE = 2  # flag of a request
MOST_WAITING = at.QUEUE_PLACES // 2
"""Frames of a member with which the kernels begin, so that there is room for more."""


class Receiver(Protocol):
    """What the memory holds of a member beside its queue."""

    node: int
    hears_itself: bool
    patience: int | None  # [ns]
    acceptance: Acceptance
    number: int  # of the next delivery
    gathered: bytearray
    due: int  # [ns]

    def fileno(self) -> int:
        """Return the descriptor of its connection."""


class ErrorFreeBus:
    """The memory of the kernels."""

    def __init__(self) -> None:
        self.wholes = array("q", bytes(8 * at.MEMORY_WHOLES))
        self.bytes = bytearray(at.MEMORY_BYTES)
        self._members: Sequence[Receiver] = ()
        self._exported = (ctypes.c_char * at.MEMORY_BYTES).from_buffer(self.bytes)
        self.addresses = self.wholes.buffer_info()[0], ctypes.addressof(self._exported)
        """Of both, for C."""

    def load(self, model: BusModel, members: Sequence[Receiver], door: int) -> bool:
        """Take over a bus and its members, who are all there; False: it is for the model to go on.

        ``door`` is the descriptor on which newcomers are heard.
        """
        state = model.error_free_state()
        if state is None or not _fits(state, members):
            return False
        t = self.wholes
        t[at.BITRATE], t[at.DATA_BITRATE] = model.timing.bitrate, model.timing.data_bitrate
        t[at.BUSY], t[at.FREE], t[at.CURRENT] = state.busy, state.free, at.NO_SLOT
        t[at.QUEUED], t[at.MEMBERS], t[at.DOOR] = 0, len(members), door
        t[at.SENT] = t[at.PACKETS] = t[at.BYTES_TO_SEND] = 0
        t[at.DUE] = min(NO_EVENT, *(member.due for member in members))
        pair = 0
        for slot, member in enumerate(members):
            self._load_member(slot, member, pair, is_listener=model.listens_only(member.node))
            self._load_queue(slot, state.queues.get(member.node, ()))
            pair += len(member.acceptance.pairs)
            if state.current is not None and state.current[2] == member.node:
                t[at.START], t[at.END], t[at.CURRENT] = *state.current[:2], slot
        self._members = members
        return True

    def store(self, model: BusModel) -> int:
        """Give everything back but what is to be sent (:meth:`unsent`).

        Returns:
            When the first of what is gathered is to be handed out [ns].

        """
        t = self.wholes
        current = None
        if t[at.CURRENT] >= 0:
            current = t[at.START], t[at.END], self._members[t[at.CURRENT]].node
        queues = {member.node: self._queue(slot) for slot, member in enumerate(self._members)}
        model.restore(ErrorFreeState(t[at.BUSY], t[at.FREE], current, queues))
        for slot, member in enumerate(self._members):
            place = at.SLOTS + slot * at.SLOT
            gathered = at.GATHERINGS + slot * at.GATHERED_BYTES
            member.number, member.due = t[place + at.NUMBER], t[place + at.GATHERED_DUE]
            member.gathered[:] = self.bytes[gathered : gathered + t[place + at.GATHERED]]
        return t[at.DUE]

    def unsent(self) -> Iterator[tuple[int, bytes]]:
        """Take out what is to be sent: nodes and packets, in their order."""
        t = self.wholes
        for number in range(t[at.SENT], t[at.PACKETS]):
            place = at.TO_SEND + number * at.PACKET_ENTRY
            begin = t[place + at.TO_SEND_AT]
            packet = bytes(self.bytes[begin : begin + t[place + at.TO_SEND_BYTES]])
            yield self._members[t[place + at.TO_SLOT]].node, packet
        t[at.SENT] = t[at.PACKETS] = t[at.BYTES_TO_SEND] = 0

    def received(self) -> tuple[int, bytes]:
        """Return the node and the packet with which the loop has left; an empty one: it has gone."""
        length = max(self.wholes[at.LENGTH], 0)
        packet = bytes(self.bytes[at.RECEIVED : at.RECEIVED + length])
        return self._members[self.wholes[at.WHO]].node, packet

    def _load_member(self, slot: int, member: Receiver, pair: int, *, is_listener: bool) -> None:
        t, place = self.wholes, at.SLOTS + slot * at.SLOT
        t[place + at.NODE], t[place + at.DESCRIPTOR] = member.node, member.fileno()
        t[place + at.HEARS_ITSELF], t[place + at.LISTENS_ONLY] = member.hears_itself, is_listener
        t[place + at.PATIENCE] = at.NO_PATIENCE if member.patience is None else member.patience
        t[place + at.NUMBER], t[place + at.GATHERED] = member.number, len(member.gathered)
        t[place + at.GATHERED_DUE] = min(member.due, NO_EVENT)
        gathered = at.GATHERINGS + slot * at.GATHERED_BYTES
        self.bytes[gathered : gathered + len(member.gathered)] = member.gathered
        t[place + at.FIRST_PAIR], t[place + at.PAIRS] = pair, len(member.acceptance.pairs)
        for number, (identifier, mask) in enumerate(member.acceptance.pairs, start=pair):
            t[at.FILTERS + 2 * number], t[at.FILTERS + 2 * number + 1] = identifier, mask

    def _load_queue(self, slot: int, queue: Sequence[tuple[int, BusFrame]]) -> None:
        t, place = self.wholes, at.SLOTS + slot * at.SLOT
        t[place + at.FIRST], t[place + at.WAITING] = 0, len(queue)
        t[at.QUEUED] += len(queue)
        for number, (time, frame) in enumerate(queue, start=slot * at.QUEUE_PLACES):
            packed = pack_request(0, frame)[at.REQUEST_IDENTIFIER :]
            begin = at.FRAMES + number * at.FRAME_BYTES
            self.bytes[begin : begin + len(packed)] = packed
            request = at.REQUESTS + number * at.REQUEST_WHOLES
            t[request + at.TIME], t[request + at.KEY] = time, frame.arbitration_key

    def _queue(self, slot: int) -> list[tuple[int, BusFrame]]:
        t, place = self.wholes, at.SLOTS + slot * at.SLOT
        return [
            self._request(slot * at.QUEUE_PLACES + number % at.QUEUE_PLACES)
            for number in range(t[place + at.FIRST], t[place + at.FIRST] + t[place + at.WAITING])
        ]

    def _request(self, number: int) -> tuple[int, BusFrame]:
        begin = at.FRAMES + number * at.FRAME_BYTES
        head = bytes(at.REQUEST_IDENTIFIER) + self.bytes[begin : begin + at.FRAME_DATA]
        is_remote = head[at.REQUEST_IDENTIFIER + at.FRAME_FLAGS] & REMOTE
        length = 0 if is_remote else FD_SIZES[head[-1]]
        asked = unpack_request(head + self.bytes[begin + at.FRAME_DATA : begin + at.FRAME_DATA + length])
        assert asked is not None, "only frames are queued"  # noqa: S101
        return self.wholes[at.REQUESTS + number * at.REQUEST_WHOLES + at.TIME], asked[1]


def _fits(state: ErrorFreeState, members: Sequence[Receiver]) -> bool:
    pairs = sum(len(member.acceptance.pairs) for member in members)
    waiting = max((len(queue) for queue in state.queues.values()), default=0)
    return len(members) <= at.MOST_SLOTS and pairs <= at.MOST_PAIRS and waiting <= MOST_WAITING
