"""The loop of a node. One thread owns it; it reads and writes no file and holds no lock of others."""

import contextlib
import gc
import logging
import queue
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from vegrip.clock import NS, Clock
from vegrip.config import parameter
from vegrip.errors import DeviceError
from vegrip.host.realtime import LoopPriority, Scheduling
from vegrip.messages import OF_NODES, FingertipState, ForceCommand, Lifecycle, Message, NodeStatus
from vegrip.runtime.channel_watch import ChannelWatch
from vegrip.runtime.managed import ManagedNode
from vegrip.runtime.node import Answered, NodeBase, OfLoop
from vegrip.runtime.sender_watch import HINTS, FaultHints, SenderWatch, level_of
from vegrip.runtime.statistics import LoopStatistics, Schedule
from vegrip.runtime.telemetry import Direction, Telemetry
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.sender_clock import ClockEstimate


class CallQueue:
    """Calls waiting for the thread of the loop; serving an empty inbox costs one look at a queue."""

    def __init__(self) -> None:
        self._waiting: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()
        self._closed = False

    def put(self, call: Callable[[], Any]) -> Future[Any]:
        """Ask the loop to make ``call``; its result, or what it raises, comes in the future."""
        future: Future[Any] = Future()
        self._waiting.put((call, future))
        if self._closed:
            self._refuse()
        return future

    def close(self) -> None:
        self._closed = True
        self._refuse()

    def _refuse(self) -> None:
        with contextlib.suppress(queue.Empty):
            while True:
                _, future = self._waiting.get_nowait()
                future.set_exception(DeviceError("the node is ending"))

    def serve(self) -> None:
        while not self._waiting.empty():
            call, future = self._waiting.get()
            try:
                future.set_result(call())
            except Exception as error:  # noqa: BLE001 (goes to the one who asked)
                future.set_exception(error)


LONGEST_WAIT = 0.1  # [s] so that a request to stop is seen soon whatever the tick period is
STATE_BACKLOG = (
    100  # drains of the bus before activation; a bus that never runs dry must not keep the node from starting
)
LISTEN_BEFORE_ACTIVE_S = (
    0.1  # [s] before the first activation; another sender for these fingers is noticed within
)
RECENT_SENDER_S = 0.5  # [s] a sender that sent so long ago counts as present
MOST_UNFINISHED = 64  # answers put off while states come without end


@dataclass(frozen=True)
class LoopSettings:
    """How the loop runs: the ``[loop]`` table of a node."""

    tick_period: float = parameter(0.002, unit="s", low=1e-4, high=10.0, doc="of on_tick", live=False)
    status_period: float = parameter(1.0, unit="s", low=0.01, high=60.0, doc="of NodeStatus", live=False)
    deadline: float = parameter(
        0.010,
        unit="s",
        low=1e-5,
        high=10.0,
        doc="a command later than this after its state is a miss",
        live=False,
    )


class Runner:
    """Carries messages from the bus to the node and back, ticks, serves requests, reports.

    ``now`` is read once per message and once per tick; the node sees no other time.
    """

    def __init__(
        self,
        node: NodeBase,
        endpoint: Endpoint,
        clock: Clock,
        settings: LoopSettings | None = None,
        telemetry: Telemetry | None = None,
        full_name: str = "",
        beside: Mapping[str, int] | None = None,  # what the threads beside the loop refuse, counted by name
        priority: LoopPriority | None = None,
    ) -> None:
        settings = settings or LoopSettings()
        self.full_name = full_name or node.name
        self.managed = ManagedNode(node, logging.getLogger(f"vegrip.{self.full_name}"))
        self.inbox = CallQueue()
        self.schedule = Schedule(settings.tick_period)
        self.statistics = LoopStatistics(round(settings.deadline * NS), clock.now())
        self.status: NodeStatus | None = None  # the last one sent
        self.clock: ClockEstimate | None = None  # of the sender, as of then
        self._endpoint = endpoint
        self._clock = clock
        self._telemetry = telemetry
        self._status_schedule = Schedule(settings.status_period)
        self._stop = False
        self._unfinished: deque[Iterator[Message | None]] = deque()  # whose command has been sent
        self._begun = False  # a part of the first of them has been sent
        self._more = False  # the last look at the bus may have left something there
        self._owed: set[str] = set()  # fingers whose reports are among them
        self.running = False  # whether run() has begun
        self._pending = False  # to be activated as soon as nothing stands in the way
        self._remedies = FaultHints()
        self._faults: Set[tuple[str, str]] = frozenset()  # of devices, as last logged
        self._also_sent = 0  # messages of others that only this node may send
        self._broken = endpoint.broken
        self._broken_reported: dict[str, int] = {}  # as far as the node knows of them
        self._missed: dict[str, int] = {}  # counts of what came before this node listened
        self._other: tuple[int, str] | None = None  # [ns] when the last of them came, and what it was
        self._beside = beside
        received = getattr(node, "received_messages", ())  # nodes of others may have none
        if received:
            endpoint.select(received)
        self._priority = priority or LoopPriority(Scheduling())
        self._senders = SenderWatch()
        lacking = getattr(node, "lacking", None)  # nodes of others may have none
        self.channels = ChannelWatch(lacking) if lacking is not None else None
        path = getattr(node, "frame_path", None)  # nodes of others may have none
        of_loop = OfLoop(clock, self.statistics, self._senders, telemetry, self.channels)
        self.frame_path = path(endpoint, of_loop) if endpoint.brings and path is not None else None
        """Answers states that come as bytes; None: none do."""
        self._renumber = True  # commands may have been sent in the node's place

    @property
    def state(self) -> Lifecycle:
        return self.managed.state

    @property
    def path_taken(self) -> str:
        """Which way the states of fingers go through the loop, and why; "" for a node that answers none."""
        return getattr(self.managed.node, "path_taken", "")

    @property
    def due(self) -> int:
        """When :meth:`step` has something to do even if nothing comes in [ns]."""
        return min(self.schedule.due, self._status_schedule.due)

    def start(self) -> None:
        self.change("configure")
        self.change("activate")

    def bring_up(self) -> None:
        """Configure, listen, and activate; an endpoint in trouble is waited for, in state inactive."""
        self.change("configure")
        self._forget_the_past()
        end = self._clock.now() + round(LISTEN_BEFORE_ACTIVE_S * NS)
        while (left := end - self._clock.now()) > 0:
            self._answer_all(self._endpoint.receive(left / NS))
        self._pending = True
        self._activate_if_well()
        if self._pending:
            self._report(self._clock.now())

    def give_up(self) -> None:
        self.change("shutdown")
        self._report(self._clock.now())

    def change(self, transition: str) -> None:
        """Make a lifecycle transition, in the thread of the loop."""
        if transition == "activate":
            self._refuse_a_second()
            gc.collect()  # takes a tenth of a second, so before the node is said to be active
        else:
            self._priority.give_back()  # what is compiled must not stand before everything else
        self.managed.change(transition)
        self._renumber = True
        if transition == "configure" and self.frame_path is not None:
            self.frame_path.prepare()
        self._pending = False
        if transition == "activate":
            self._settle()
        else:
            self._status_schedule.start(self._clock.now())  # others are to know at once

    def run(self) -> None:
        """Loop until :meth:`stop` is called or the node has finished, then shut the node down."""
        self.running = True
        while not (self._stop or self.managed.node.finished):
            self.step()
        if self.state is not Lifecycle.FINALIZED:
            self.change("shutdown")
        self.inbox.close()
        self._report(self._clock.now())

    def stop(self) -> None:
        """End the loop soon; may be called from a signal handler or another thread."""
        self._stop = True

    def step(self) -> None:
        """Wait for messages or the next tick, whichever comes first, and serve it."""
        wait = (self.due - self._clock.now()) / NS
        self._answer_all(self._gather(min(max(wait, 0.0), LONGEST_WAIT)))
        while self._unfinished and not (self._stop or self.managed.node.finished):
            if len(self._unfinished) < MOST_UNFINISHED:
                self._answer_all(self._endpoint.receive(0.0))
            if self._clock.now() >= self.due:
                self._serve_due()
            self._finish_one()
        self._serve_due()

    def _serve_due(self) -> None:
        self.inbox.serve()
        if self._broken:
            self._tell_broken()
        now = self._clock.now()
        if now >= self.schedule.due:
            self._tick(now)
        if now >= self._status_schedule.due:
            self._status_schedule.take(now)
            self._activate_if_well()
            self._report(now)

    def _tell_broken(self) -> None:
        now = self._clock.now()
        for finger, count in self._broken.items():
            if count != self._broken_reported.get(finger, 0):
                self._broken_reported[finger] = count
                self.managed.on_broken(finger, now)

    def _gather(self, wait: float) -> Sequence[Message]:
        """Return what has come after ``wait`` [s] at most; a node that answers nothing sleeps meanwhile."""
        if self.managed.node.wakes_on_messages:
            return self._endpoint.receive(wait)
        if not self._more:
            self._clock.sleep_until(self._clock.now() + round(wait * NS))
        messages = self._endpoint.receive(0.0)
        self._more = bool(messages)
        return messages

    def _answer_all(self, messages: Sequence[Message]) -> None:
        if not messages:
            return
        for message, arrived in zip(messages, self._endpoint.arrivals, strict=True):
            self._answer(message, arrived)

    def _answer(self, message: Message, arrived: int) -> None:
        if isinstance(message, FingertipState) and self.state is Lifecycle.ACTIVE:
            self.statistics.state(message.finger, arrived)
            self._senders.note(message)
            if self.channels is not None:
                self.channels.note(message)
        elif isinstance(message, ForceCommand):
            self.statistics.commands_received += 1
        if isinstance(message, self.managed.node.exclusive_messages) and not isinstance(message, OF_NODES):
            self._also_sent += 1
            self._other = (arrived, f"{type(message).__name__} of {message.finger}")
        if self._telemetry is not None:
            self._telemetry.offer(message, Direction.IN)
        answers = self.managed.on_message(message, self._clock.now())
        for answer in answers:
            if not isinstance(answer, ForceCommand):
                self._finish_begun()
            self._send((answer,))
            if isinstance(answer, ForceCommand):
                if self.statistics.pace.allows(answer.finger, self._clock.now()):
                    self._unfinished.append(answers)
                return

    def _guarded(self, answer: Callable[..., Answered | None]) -> Callable[..., Any]:
        """Return what an endpoint asks of states that come as bytes; None where nothing is answered.

        That is while the node is not active, and where it fails.
        """

        def intercept(*given: Any) -> Any:
            if self.state is not Lifecycle.ACTIVE or self.frame_path is None:
                self._renumber = True
                return None
            try:
                if self._renumber:
                    self._renumber = False
                    self.frame_path.renumber(self.managed.numbers_sent())
                answered = answer(*given)
            except Exception as error:  # noqa: BLE001 (whatever a node raises must not end the loop)
                self.managed.fail(error, self._clock.now())
                return None
            if answered is None:
                return None
            found, fingers = answered
            if fingers:
                self._put_off_reports(self.frame_path, fingers)
            return found

        return intercept

    def _put_off_reports(self, path: Any, fingers: Iterable[str]) -> None:
        now, pace = self._clock.now(), self.statistics.pace
        due = [finger for finger in fingers if finger not in self._owed and pace.allows(finger, now)]
        if not due:
            return
        self._owed.update(due)
        reports = self.managed.answers(lambda: path.reports(due, now), now)
        self._unfinished.append(self._until_delivered(due, reports))

    def _until_delivered(
        self, fingers: Sequence[str], reports: Iterator[Message | None]
    ) -> Iterator[Message | None]:
        yield from reports
        self._owed.difference_update(fingers)

    def _finish_one(self) -> None:
        while self._unfinished:
            for answer in self._unfinished[0]:
                self._begun = True
                if answer is not None:
                    self._send_later(answer)
                return
            self._unfinished.popleft()
            self._begun = False

    def _finish_begun(self) -> None:
        """Send the rest of a report of which a part has been sent, so that no later one overtakes it."""
        if self._begun:
            self._begun = False
            for answer in self._unfinished.popleft():
                if answer is not None:
                    self._send((answer,))

    def _tick(self, now: int) -> None:
        self.statistics.ticked(self.schedule.take(now))
        self._finish_begun()
        self._send(self.managed.on_tick(now))
        self._endpoint.flush()

    def _send(self, messages: Sequence[Message]) -> None:
        if len(messages) > 1:
            self._endpoint.send_all(messages)
        elif messages:
            self._endpoint.send(messages[0])
        for message in messages:
            if isinstance(message, ForceCommand):
                self.statistics.command(message.finger, self._clock.now())
            elif isinstance(message, FingertipState):
                self.statistics.states_sent += 1
            if self._telemetry is not None:
                self._telemetry.offer(message, Direction.OUT)
        if messages:
            self._endpoint.flush()

    def _send_later(self, message: Message) -> None:
        """Send a message that nothing waits for; where that saves waking a thread, behind the next one."""
        if isinstance(message, ForceCommand | FingertipState):
            self._send((message,))
            return
        self._endpoint.put_off(message)
        if self._telemetry is not None:
            self._telemetry.offer(message, Direction.OUT)

    def zero(self) -> bool:
        """Have the devices behind the endpoint take their own zeros; whether they can."""
        return self._endpoint.zero()

    def _report(self, now: int) -> None:
        dropped = self._telemetry.dropped if self._telemetry is not None else 0
        self.status = self.statistics.status(self.full_name, self.state, now, dropped, self._rejected())
        self.clock = self._endpoint.clock
        if self.state is not Lifecycle.FINALIZED:  # a node that ends for that reason reports it last
            news = list(self._remedies.news(self.status.rejected, now, self._endpoint.hints))
            for level in (logging.ERROR, logging.WARNING, logging.INFO):
                if lines := [sentence for name, sentence in news if level_of(name) == level]:
                    self.managed.logger.log(level, "%s", "\n".join(lines))  # one record: one a second passes
            self._tell_faults(self._endpoint.device_faults)
            if self.channels is not None:
                self._tell_fingers(self.channels)
        self._send([self.status])

    def _tell_faults(self, faults: Set[tuple[str, str]]) -> None:
        """Log what devices have begun to say of themselves since the last report, and what is over."""
        begun, over, self._faults = faults - self._faults, self._faults - faults, frozenset(faults)
        if begun:  # one record each: one line a second passes
            self.managed.logger.warning("%s", _sentences("says of itself", begun))
        if over:
            self.managed.logger.info("%s", _sentences("no longer says", over))

    def _tell_fingers(self, channels: ChannelWatch) -> None:
        if sentences := list(channels.news()):
            self.managed.logger.warning("%s", "; ".join(sentences))
        describe = getattr(self.managed.node, "describe_finger", None)  # nodes of others may have none
        if describe is None:
            return
        if lines := [line for one in channels.fresh() if (line := describe(*one))]:
            self.managed.logger.info("%s", "\n".join(lines))  # one record: one line a second passes

    def _rejected(self) -> Mapping[str, int]:
        of_others = {"also_sent": self._also_sent, "two_senders": self._senders.count}
        own = {"reports_lowered": self.statistics.pace.lowered}
        if self.frame_path is not None:
            self.frame_path.read_counters()  # of the frames: part of what is counted
        counts = {
            **self._endpoint.rejected,
            **self.managed.node.rejected,
            **self.managed.faults,
            **of_others,
            **own,
            **(self._beside or {}),
        }
        for name in counts.keys() & self._missed.keys():
            counts[name] -= self._missed[name]
        return {name: count for name, count in counts.items() if count}

    def _refuse_a_second(self) -> None:
        if self._other is None:
            return
        received, what = self._other
        if self._clock.now() - received < RECENT_SENDER_S * NS:
            raise DeviceError(f"{self.full_name} is not activated ({what}): {HINTS['also_sent']}")

    def _activate_if_well(self) -> None:
        if self._pending and not self._endpoint.in_trouble:
            self.change("activate")
            self.managed.logger.info("active")

    def _settle(self) -> None:
        """Freeze what exists out of the garbage collector's sight, drop what came before, lay the grid."""
        if self.path_taken:
            self.managed.logger.info("%s", self.path_taken)
        gc.freeze()
        if sentence := self._priority.take():
            self.managed.logger.warning("%s", sentence)
        self._forget_the_past()
        self._missed = {name: self._endpoint.rejected.get(name, 0) for name in ("lost", "overrun")}
        now = self._clock.now()
        self.statistics.forget_states()
        self.schedule.start(now)
        self._status_schedule.start(now)

    def _forget_the_past(self) -> None:
        if self.frame_path is not None:
            self.frame_path.look(None)
        for _ in range(STATE_BACKLOG):
            if not self._endpoint.receive(0.0):
                break
        if self.frame_path is not None:
            self.frame_path.look(self._guarded)


def _sentences(says: str, faults: Set[tuple[str, str]]) -> str:
    return "; ".join(f"{device} {says}: {name.replace('_', ' ')}" for device, name in sorted(faults))
