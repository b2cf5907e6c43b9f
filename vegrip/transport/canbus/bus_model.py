"""A CAN bus as a whole: arbitration, time, acknowledgement, errors, confinement. Pure: time comes in.

The same model runs on the wall clock (:mod:`vegrip.transport.canbus.hub`) and on a simulated one
(:mod:`vegrip.transport.simulated_can`). What happens to a frame is settled when it begins, since who joins
later cannot receive it. A frame that goes wrong stays first in its node's queue and asks for the bus again.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from vegrip.clock import NS
from vegrip.transport.canbus.arbiter import Arbiter
from vegrip.transport.canbus.bus_events import BusError, Counters, ErrorKind, Event, StateChange, Transmission
from vegrip.transport.canbus.error_signalling import (
    Error,
    bit_stream,
    error_duration,
    suspension,
    unacknowledged_duration,
)
from vegrip.transport.canbus.fault_confinement import RECOVERY_BITS, Confinement, ErrorState
from vegrip.transport.canbus.frame_time import BitTiming, BusFrame, frame_duration
from vegrip.transport.canbus.node_faults import NO_FAULTS, NOBODY, Chance, NodeFaults


class _Attempt(NamedTuple):
    start: int
    end: int
    node: int
    frame: BusFrame
    error: ErrorKind | None = None
    found_by: int = NOBODY
    missed_by: int = NOBODY


class ErrorFreeState(NamedTuple):
    """A bus whose nodes have no errors, all there, and on which every frame is acknowledged."""

    busy: int  # [ns]
    free: int  # [ns]
    current: (
        tuple[int, int, int] | None
    )  # start, end [ns] and node of the frame on the bus, the first of its queue
    queues: Mapping[int, Sequence[tuple[int, BusFrame]]]  # node -> times [ns] and frames that wait


class _Node:
    """What the bus knows of a node."""

    __slots__ = ("chance", "confinement", "leaving", "listen_only", "since", "state")

    def __init__(self, listen_only: bool, faults: NodeFaults) -> None:
        self.listen_only = listen_only
        self.chance = None if faults == NO_FAULTS else Chance(faults)
        self.confinement = Confinement()
        self.state = ErrorState.ACTIVE  # as last told
        self.since = 0  # [ns] a node that is off counts recessive bits from here on
        self.leaving = False

    @property
    def acknowledges(self) -> bool:
        return not (self.listen_only or self.leaving) and self.state is not ErrorState.OFF


class BusModel:
    """The bus and its nodes, which are numbers given by the caller."""

    def __init__(self, timing: BitTiming) -> None:
        self.timing = timing
        self.busy = 0  # [ns] for how long the bus has carried frames, good or bad
        self._arbiter = Arbiter()
        self._nodes: dict[int, _Node] = {}
        self._free = 0  # [ns] when the bus is (or was) free
        self._current: _Attempt | None = None
        self._is_hopeless = False  # a lone error-passive node repeats its frame, and nothing changes by that
        self._acknowledging = 0  # number of nodes that do
        self._troubled: set[int] = set()  # nodes with a counter that is not zero
        self._off: set[int] = set()
        self._misreaders: list[int] = []
        self._has_faults = False  # whether a node suffers faults

    def attach(
        self, node: int, *, listen_only: bool = False, faults: NodeFaults = NO_FAULTS, time: int = 0
    ) -> None:
        """Connect ``node`` at ``time`` [ns]; from the next frame on it takes part."""
        self._nodes[node] = _Node(listen_only, faults)
        self._census()
        self._babble(node, time)

    def endure(self, node: int, faults: NodeFaults, time: int = 0) -> None:
        """Let ``node`` suffer ``faults`` from ``time`` [ns] on, in place of those it had."""
        self._nodes[node].chance = None if faults == NO_FAULTS else Chance(faults)
        self._census()
        self._babble(node, time)

    def detach(self, node: int) -> None:
        """Disconnect ``node``; what it has queued is still sent, if a node is there to acknowledge it."""
        leaving = self._nodes[node]
        leaving.leaving, leaving.chance = True, None
        self._census()
        for other in [n for n, known in self._nodes.items() if known.leaving]:
            self._forget_if_done(other)

    def request(self, time: int, node: int, frame: BusFrame) -> bool:
        """Queue ``frame`` of ``node`` at ``time`` [ns]; refused from a node that is off or only listens."""
        asking = self._nodes[node]
        if asking.listen_only or asking.state is ErrorState.OFF:
            return False
        self._arbiter.request(asking.chance.delayed(time) if asking.chance else time, node, frame)
        self._is_hopeless = False
        return True

    def waiting(self, node: int) -> int:
        """Return how many frames of ``node`` wait for the bus or are on it."""
        return self._arbiter.waiting(node)

    @property
    def queued(self) -> int:
        """How many frames of all nodes wait for the bus or are on it."""
        return self._arbiter.queued

    @property
    def is_healthy(self) -> bool:
        """Whether no node has errors, and none is made to have some."""
        return not (self._troubled or self._off or self._has_faults)

    def error_free_state(self) -> ErrorFreeState | None:
        """Return all that decides what happens next, None unless that is arbitration and time alone."""
        is_error_free = self.is_healthy and self._acknowledging >= 2  # every frame is acknowledged
        if not is_error_free or any(node.leaving for node in self._nodes.values()):
            return None
        current = self._current
        if current is not None and (current.error is not None or current.missed_by != NOBODY):
            return None
        queues = self._arbiter.queues()
        if queues is None:
            return None
        on_bus = None if current is None else (current.start, current.end, current.node)
        return ErrorFreeState(self.busy, self._free, on_bus, queues)

    def restore(self, state: ErrorFreeState) -> None:
        """Go on from ``state``, which a bus of these nodes was in."""
        self.busy, self._free, self._current = state.busy, state.free, None
        self._arbiter.restore(state.queues)
        if state.current is not None:
            start, end, node = state.current
            self._current = _Attempt(start, end, node, state.queues[node][0][1])

    def listens_only(self, node: int) -> bool:
        """Whether ``node`` sends nothing."""
        return self._nodes[node].listen_only

    def is_heard(self, node: int) -> bool:
        """Whether another node would acknowledge a frame of ``node``."""
        return self._acknowledging > self._nodes[node].acknowledges

    def state(self, node: int) -> ErrorState:
        """Return the error state of ``node``."""
        return self._nodes[node].confinement.state

    def counters(self, node: int) -> Counters:
        """Return the transmit and the receive error counter of ``node``."""
        confinement = self._nodes[node].confinement
        return confinement.transmit, confinement.receive

    def advance(self, now: int) -> list[Event]:
        """Let time pass up to ``now`` [ns] and return what was finished, in order."""
        events: list[Event] = []
        while True:
            if self._is_hopeless:  # it may become so within a call that has much to make up for
                self._repeat_until(now)
            if self._off:
                self._recover(now, events)
            current = self._current or self._begin(now)
            if current is None or current.end > now:
                return events
            self._current = None
            self._finish(current, events)

    def conclude(self, now: int) -> list[Event]:
        """Finish the frame on the bus if it has ended by ``now`` [ns], but begin no other.

        For members that must know of it before the next arbitration.
        """
        events: list[Event] = []
        current = self._current
        if current is not None and current.end <= now and not self._is_hopeless:
            self._current = None
            self._finish(current, events)
        return events

    def next_event(self) -> int | None:
        """Return when :meth:`advance` will have something to do [ns]; None: not before the next request."""
        if self._current is not None:
            return None if self._is_hopeless else self._current.end
        start = self._arbiter.next_start(self._free)
        if not self._off:
            return start
        back = min(self._recovery(node) for node in self._off)
        return back if start is None else min(start, back)

    # --- a frame begins

    def _begin(self, now: int) -> _Attempt | None:
        """Put the next frame on the free bus if its time has come, and return it."""
        start = self._arbiter.next_start(self._free)
        if start is None or start > now:
            return None
        node, frame = self._arbiter.winner(start)
        if frame.fd and self._nodes[node].state is ErrorState.PASSIVE:
            frame = frame._replace(is_error_passive=True)
        self._current = self._attempt(start, node, frame)
        self._free = self._current.end
        self._arbiter.resume()
        return self._current

    def _attempt(self, start: int, node: int, frame: BusFrame) -> _Attempt:
        sender = self._nodes[node]
        if sender.chance is not None and sender.chance.happens(sender.chance.faults.corruption):
            return self._disturbed(start, node, frame, sender.chance, NOBODY)
        missed_by = NOBODY
        for reader in self._misreaders:
            chance = self._nodes[reader].chance
            if reader != node and chance is not None and chance.happens(chance.faults.misreading):
                if self._nodes[reader].confinement.state is ErrorState.ACTIVE:
                    return self._disturbed(start, node, frame, chance, reader)
                missed_by = reader
        if self._acknowledging - sender.acknowledges - (missed_by != NOBODY) <= 0:
            end = start + unacknowledged_duration(frame, self.timing)
            return _Attempt(start, end, node, frame, ErrorKind.ACK, node, missed_by)
        return _Attempt(
            start, start + frame_duration(frame, self.timing), node, frame, None, NOBODY, missed_by
        )

    def _disturbed(self, start: int, node: int, frame: BusFrame, chance: Chance, reader: int) -> _Attempt:
        """Return the attempt that fails in a bit that all nodes (or only ``reader``) see inverted."""
        stream, alone, sender = bit_stream(frame), reader != NOBODY, self._nodes[node]
        error = Error(
            position=chance.position(stream.first, stream.last),
            found_by_one=alone,
            is_passive=sender.state is ErrorState.PASSIVE,
            answered=self._acknowledging - sender.acknowledges - alone > 0,
        )
        took = error_duration(stream, error, self.timing)
        kind, found_by = (ErrorKind.STUFF, reader) if alone else (ErrorKind.BIT, node)
        return _Attempt(start, start + took, node, frame, kind, found_by)

    # --- a frame ends

    def _finish(self, attempt: _Attempt, events: list[Event]) -> None:
        self.busy += attempt.end - attempt.start
        if attempt.error is None:
            self._succeed(attempt, events)
        else:
            self._fail(attempt, attempt.error, events)
        for node in self._off:
            self._hear(node, attempt)
        if self._nodes[attempt.node].state is ErrorState.PASSIVE:
            self._arbiter.suspend(attempt.node, attempt.end + suspension(self.timing))
        self._forget_if_done(attempt.node)

    def _succeed(self, attempt: _Attempt, events: list[Event]) -> None:
        node, frame = attempt.node, attempt.frame
        self._arbiter.done(node)
        sender = self._nodes[node]
        if self._troubled:
            self._reward(attempt, events)
        is_lost = False
        if sender.chance is not None:
            frame, is_lost = sender.chance.carried(frame), sender.chance.happens(sender.chance.faults.loss)
            self._babble(node, attempt.end)
        events.append(Transmission(attempt.start, attempt.end, node, frame, is_lost, attempt.missed_by))

    def _reward(self, attempt: _Attempt, events: list[Event]) -> None:
        for node in sorted(self._troubled):
            confinement = self._nodes[node].confinement
            if node == attempt.node:
                confinement.sent()
            elif node == attempt.missed_by:
                confinement.failed_to_receive(is_first=False)
            elif node not in self._off:
                confinement.received()
            self._judge(node, attempt.end, events)

    def _fail(self, attempt: _Attempt, kind: ErrorKind, events: list[Event]) -> None:
        sender = self._nodes[attempt.node].confinement
        before = sender.state
        if kind is ErrorKind.ACK:
            sender.not_acknowledged()
            self._is_hopeless = (
                before is ErrorState.PASSIVE
                and len(self._arbiter_nodes()) == 1
                and not (self._off or self.is_heard(attempt.node))
            )
        else:
            sender.failed_to_send()
            self._blame_receivers(attempt)
        counters = {node: self.counters(node) for node in self._nodes}
        events.append(BusError(*attempt[:4], kind, attempt.found_by, counters))
        for node in list(self._nodes):
            self._judge(node, attempt.end, events)

    def _blame_receivers(self, attempt: _Attempt) -> None:
        for node, known in self._nodes.items():
            if node != attempt.node and known.acknowledges:
                known.confinement.failed_to_receive(is_first=node == attempt.found_by)

    def _judge(self, node: int, time: int, events: list[Event]) -> None:
        """Take note of the counters of ``node``, and of a change of its state."""
        known = self._nodes[node]
        if known.confinement.is_clean:
            self._troubled.discard(node)
        else:
            self._troubled.add(node)
        state = known.confinement.state
        if state is known.state:
            return
        known.state = state
        dropped = 0
        if state is ErrorState.OFF:
            dropped = self._arbiter.drop(node)
            self._off.add(node)
            known.since = time
        self._census()
        events.append(StateChange(time, node, state, self.counters(node), dropped))

    # --- nodes that are off

    def _hear(self, node: int, attempt: _Attempt) -> None:
        """Count the silence before a frame, and the 11 recessive bits at the end of any frame."""
        known = self._nodes[node]
        if attempt.end <= known.since:
            return  # the frame that put it off
        known.confinement.missing -= max(attempt.start - known.since, 0) // self._sequence + 1
        known.since = attempt.end

    def _recovery(self, node: int) -> int:
        """Return when ``node`` recovers if the bus stays free [ns]."""
        known = self._nodes[node]
        return known.since + max(known.confinement.missing, 0) * self._sequence

    def _recover(self, now: int, events: list[Event]) -> None:
        if self._current is not None:
            return
        start = self._arbiter.next_start(self._free)
        until = now if start is None else min(now, start)
        for node in sorted(self._off, key=self._recovery):
            time = self._recovery(node)
            if time <= until:
                self._nodes[node].confinement.count_silence(self._nodes[node].confinement.missing)
                self._off.discard(node)
                self._judge(node, time, events)
                self._babble(node, time)

    @property
    def _sequence(self) -> int:
        return RECOVERY_BITS * NS // self.timing.bitrate

    # --- a node that is alone

    def _repeat_until(self, now: int) -> None:
        """Skip the attempts of a lone error-passive node up to ``now`` [ns]: each is like the one before."""
        current = self._current or self._begin(now)
        if current is None or current.end > now:
            return
        period = current.end - current.start + suspension(self.timing)
        skipped = (now - current.start) // period
        self.busy += skipped * (current.end - current.start)
        shift = skipped * period
        self._current = current._replace(start=current.start + shift, end=current.end + shift)
        self._free = self._current.end

    def _arbiter_nodes(self) -> list[int]:
        return [node for node in self._nodes if self._arbiter.waiting(node)]

    # --- who is there

    def _census(self) -> None:
        self._acknowledging = sum(node.acknowledges for node in self._nodes.values())
        self._misreaders = [
            number
            for number, node in self._nodes.items()
            if node.chance is not None and node.chance.faults.misreading > 0.0 and node.acknowledges
        ]
        self._has_faults = any(node.chance is not None for node in self._nodes.values())
        self._is_hopeless = False

    def _babble(self, node: int, time: int) -> None:
        chance = self._nodes[node].chance
        if chance is None or chance.faults.babble == NOBODY or self._arbiter.waiting(node):
            return
        if self._nodes[node].listen_only:
            return
        self._arbiter.request(time, node, BusFrame(chance.faults.babble, bytes(8)))

    def _forget_if_done(self, node: int) -> None:
        """Forget a node that has left, once its frames have, or can no longer be acknowledged."""
        is_on_bus = self._current is not None and self._current.node == node
        if not self._nodes[node].leaving or is_on_bus:
            return
        if self._acknowledging and self._arbiter.waiting(node):
            return
        self._arbiter.drop(node)
        del self._nodes[node]
        self._troubled.discard(node)
        self._off.discard(node)
