"""The main job, end to end: virtual hand -> virtual CAN bus -> grasp force node, watched and recorded.

Three processes on one bus: the hand, the node, and this one, which listens as a monitor and recorder would.
Latency is measured in the node, from the arrival of a state to the departure of its command.
"""

import math
import os
import time
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from vegrip.clock import NS
from vegrip.demo.hand_node import DemoHand, HandNews
from vegrip.demo.worker import Job, RunStatistics
from vegrip.demo.worker_handle import WorkerHandle
from vegrip.host.realtime import NODE_PRIORITY, choose_scheduling, is_switched_on, permission
from vegrip.identification.recording.background import BackgroundWriter
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, Message, Reason
from vegrip.runtime.monitor import Board
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.open import Hand, open_endpoint
from vegrip.validation.controllers import candidates
from vegrip.validation.controllers.closed_loop import Course
from vegrip.validation.controllers.scenario import Scenario

REFRESH_PERIOD_S = 0.1  # [s] of the screen
LOOK_PAUSE_S = 0.02  # [s] between two looks at the bus: a process that waits for each frame is woken by each
HOLD_REASONS = (Reason.INPUT_HOLD, Reason.FAIL_SAFE)
TICK_PERIODS_S = {"hand": 0.002, "node": 0.005}  # [s]


NODE = "/grasp_force"  # as a page calls it


class Page(Protocol):
    """A page that shows what is on the bus."""

    def take(self, message: Message, now: int, node: str) -> None:
        """Take a message that came at ``now`` [ns]."""

    def tick(self) -> None:
        """Show what is new, when that is due."""


@dataclass
class Outcome:
    """What a demonstration leaves behind."""

    folder: Path
    course: Course
    node: RunStatistics
    bus_load: float  # [-] mean over the run
    held: float  # [-] share of the commands that only held, because states came too late or not at all
    interrupted: bool = False
    problem: str = ""  # what is not in the recording, in a sentence


@dataclass
class Demo:
    """A demonstration under way."""

    scenario: Scenario
    folder: Path
    board: Board
    loads: list[float] = field(default_factory=list)
    acting: frozenset[str] = frozenset()
    commands: int = 0
    held: int = 0  # of the commands
    news: HandNews | None = None
    page: Page | None = None
    believed: Course = field(default_factory=lambda: Course(()))  # of friction
    _load_due: float = 0.0
    _first_stamp: int | None = None

    def watch(self, endpoint: Endpoint, recorder: BackgroundWriter) -> None:
        """Take what is on the bus."""
        time.sleep(LOOK_PAUSE_S)
        while messages := endpoint.receive(0.0):
            for message in messages:
                self._count(message)
                self._believe(message)
                self.board.take(message, time.monotonic_ns())
                recorder.offer(message)
                if self.page is not None:
                    self.page.take(message, time.monotonic_ns(), NODE)
        if self.page is not None:
            self.page.tick()
        if time.monotonic() >= self._load_due:
            self._load_due = time.monotonic() + 1.0
            load = endpoint.bus_load()
            if not math.isnan(load):
                self.loads.append(load)

    def _believe(self, message: Message) -> None:
        """Note what the estimates say of friction, by the time of the hand."""
        if isinstance(message, FingertipState) and self._first_stamp is None:
            self._first_stamp = message.stamp
        if isinstance(message, ContactEstimate) and self._first_stamp is not None:
            self.believed.believe(message, (message.stamp - self._first_stamp) / NS)

    def _count(self, message: Message) -> None:
        if isinstance(message, ForceCommand) and self.news is not None:
            self.commands += 1
            self.held += message.reason in HOLD_REASONS

    def title(self) -> str:
        """Return the headline of the screen; the scenario's time is behind the clock on a slow machine."""
        load = f", bus load {100.0 * self.loads[-1]:.0f} %" if self.loads else ""
        fingers = f"vegrip demo: {len(self.board.fingers)} fingers"
        if self.news is None:
            return fingers + load
        return f"{fingers}, scenario {self.news.time:.0f} s, slips: {self.news.slips}{load}"

    def tell(self, news: HandNews | None) -> None:
        """Put what happens to the object on the board's log."""
        if news is None:
            return
        if self.news is not None and news.slips > self.news.slips:
            self.board.say("the object slipped", time.monotonic_ns(), "bold red")
        self.news = news
        now = time.monotonic_ns()
        for name in sorted(set(news.acting) - self.acting):
            self.board.say(f"{news.time:.1f} s in the scenario: {DESCRIPTION.get(name, name)}", now, "yellow")
        self.acting = frozenset(news.acting)


DESCRIPTION = {
    "Push": "push",
    "Twist": "twist",
    "SlowLoad": "slowly growing load",
    "Shake": "shaking",
    "AddedMass": "mass added",
    "Turn": "hand turned against gravity",
    "Wetting": "faces get wet, friction falls",
}


def run(
    scenario: Scenario,
    folder: Path,
    refresh: Callable[[Demo], None],
    say: Callable[[str], None],
    page: Page | None = None,
) -> Outcome:
    """Run the demonstration; Ctrl-C ends it early and in order.

    Args:
        scenario: what the hand goes through.
        folder: where the recording goes; must not hold one.
        refresh: called some times a second to draw.
        say: called with a sentence while things get ready.
        page: shows it besides, where there is one.

    Raises:
        VegripError: the bus cannot be opened, the folder cannot be made, or a process fails.

    """
    parameters = candidates.parameters("vegrip", candidates.KNOBS[scenario.grasp]["vegrip"])
    fingers = scenario.settings.fingers
    transport: dict[str, Any] = {"kind": "can", "channel": f"demo-{os.getpid()}", "sender_time": True}
    board = Board(time.monotonic_ns(), fingers)
    demo = Demo(scenario, folder, board, page=page, believed=Course(fingers))
    noise = {name: getattr(parameters.noise, name) for name in ("normal_force", "displacement", "torque_z")}
    with ExitStack() as stack:
        writer = RecordingWriter(folder, radius=parameters.tip.radius, sensors=noise)
        recorder = stack.enter_context(closing(BackgroundWriter(writer)))
        endpoint = stack.enter_context(closing(open_endpoint(transport, Hand(fingers))))
        if sentence := choose_scheduling(NODE_PRIORITY, permission(), on=is_switched_on()).sentence:
            say(sentence)
        say("starting hand and node (the first run compiles, which takes a minute)")
        node = WorkerHandle(
            "grasp_force",
            Job(candidates.make_node, (parameters, fingers), transport, fingers, TICK_PERIODS_S["node"]),
        )
        stack.callback(node.stop)
        hand = WorkerHandle(
            "virtual_hand", Job(DemoHand, (scenario,), transport, fingers, TICK_PERIODS_S["hand"])
        )
        stack.callback(hand.stop)
        interrupted = _play(demo, hand, node, endpoint, recorder, refresh)
        hand.stop()
        node.stop()
    if hand.statistics_at_end is None or node.statistics_at_end is None:
        raise KeyboardInterrupt  # interrupted before there was anything to sum up
    load = sum(demo.loads) / len(demo.loads) if demo.loads else math.nan
    held = demo.held / max(demo.commands, 1)
    course: Course = hand.statistics_at_end.rest
    course.friction = demo.believed.friction
    return Outcome(folder, course, node.statistics_at_end, load, held, interrupted, writer.problem)


def _play(
    demo: Demo,
    hand: WorkerHandle,
    node: WorkerHandle,
    endpoint: Endpoint,
    recorder: BackgroundWriter,
    refresh: Callable[[Demo], None],
) -> bool:
    """Start both nodes and watch until the hand is done; tell whether it was interrupted."""
    for child in (node, hand):  # both compile at the same time; the node is active before the hand speaks
        child.wait("ready")
    for child in (node, hand):
        child.say("start")
        child.wait("active")
    demo.board.start = time.monotonic_ns()
    due = 0.0
    with suppress(KeyboardInterrupt):
        while hand.listen() and node.listen():
            demo.watch(endpoint, recorder)
            demo.tell(hand.news)
            if time.monotonic() >= due:
                due = time.monotonic() + REFRESH_PERIOD_S
                demo.board.look(time.monotonic_ns())
                refresh(demo)
        demo.board.look(time.monotonic_ns())
        refresh(demo)
        return False
    return True


def elapsed(demo: Demo) -> float:
    """Return the time since the hand started [s]."""
    return (time.monotonic_ns() - demo.board.start) / NS
